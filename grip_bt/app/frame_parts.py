"""Which frames of a project never move."""

from __future__ import annotations

from grip_bt.base.errors import GripError
from grip_bt.ros.frames import FrameTree

from .project import Project
from .resources import Progress


def robot_frames(project: Project) -> FrameTree:
    """Return the links of the project's robot that never move, as far as its description can be had here."""
    if project.file.robot is None:
        return FrameTree()
    try:
        return FrameTree.of_urdf(project.description().urdf)
    except (ImportError, GripError):
        return FrameTree()


def provide_frames(progress: Progress) -> None:
    """Have the messages of TF, built where they aren't installed; without them only fixed frames are known."""
    from grip_bt.ros.definitions import provide

    try:
        built = provide("tf2_msgs")
        progress("frames", f"tf2_msgs, built in {built[0]}" if built else "tf2_msgs, as installed")
    except GripError as error:
        progress("frames", f"only those that never move: {error}")
