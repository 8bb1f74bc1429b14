"""ROS's own buffer of transforms, where `tf2_ros` can be imported: with a sourced ROS, not with the wheels."""

from __future__ import annotations

import importlib
from typing import Any

from grip_bt.base.values import Pose

from .convert_geometry import pose_from_transform_stamped, pose_to_transform
from .frames import FrameError, FrameTree

OURS = "grip"
"""Who says so, where TF asks for it."""


class Tf2Buffer:
    """Wraps `tf2_ros.Buffer`, without a listener of its own: what we hear is handed on.

    Args:
        module: `tf2_ros`.
        fixed: frames that never move; they are static transforms there.
    """

    def __init__(self, module: Any, fixed: FrameTree):
        self._module, self._buffer = module, module.Buffer()
        for child, pose in fixed.poses.items():
            self._buffer.set_transform_static(_stamped(child, pose), OURS)

    @classmethod
    def make(cls, fixed: FrameTree) -> Tf2Buffer | None:
        """Return a buffer; None where there is no `tf2_ros`."""
        try:
            return cls(importlib.import_module("tf2_ros"), fixed)
        except ImportError:
            return None

    def add(self, transform: Any, fixed: bool) -> None:
        """Take in a `TransformStamped`."""
        (self._buffer.set_transform_static if fixed else self._buffer.set_transform)(transform, OURS)

    def lookup(self, target: str, source: str, at: float) -> Pose:
        """Return the pose of `source` in `target` at a time [s].

        Raises:
            FrameError: it isn't known; the words are tf2's.
        """
        from rclpy.time import Time

        try:
            found = self._buffer.lookup_transform(target, source, Time(nanoseconds=round(at * 1e9)))
        except self._module.TransformException as error:
            raise FrameError(str(error), frame=source) from None
        return pose_from_transform_stamped(found)


def _stamped(child: str, pose: Pose) -> Any:
    from geometry_msgs.msg import TransformStamped

    made = TransformStamped(child_frame_id=child, transform=pose_to_transform(pose))
    made.header.frame_id = pose.frame
    return made
