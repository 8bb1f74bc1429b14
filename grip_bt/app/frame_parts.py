"""Which frames of a project never move."""

from __future__ import annotations

from grip_bt.errors import GripError
from grip_bt.ros.frames import FrameTree

from .project import Project


def robot_frames(project: Project) -> FrameTree:
    """Return the links of the project's robot that never move, as far as its description can be had here."""
    if project.file.robot is None:
        return FrameTree()
    try:
        return FrameTree.of_urdf(project.description().urdf)
    except (ImportError, GripError):
        return FrameTree()
