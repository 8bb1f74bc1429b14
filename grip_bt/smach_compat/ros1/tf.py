"""`tf`: frames, as ROS 2's TF has them."""

from __future__ import annotations

from typing import Any

from grip_bt.smach_compat.smach_ros._connection import ros, seconds
from grip_bt.smach_compat.smach_ros._port import NoFrameError

from . import transformations as transformations
from ._messages import Duration, Time, now

Frame = tuple[tuple[float, float, float], tuple[float, float, float, float]]


class LookupException(Exception):
    """A frame isn't known."""


class ConnectivityException(Exception):
    """Two frames aren't joined; none is raised, nor of the next: a frame is known or not."""


class ExtrapolationException(Exception):
    """A frame wasn't known at that time."""


class TransformListener:
    """Tells where frames are."""

    def __init__(self, *_: object, **__: object):
        """Take what ROS 1's takes, such as how long frames are kept."""

    def lookupTransform(self, target_frame: str, source_frame: str, time: Any = 0) -> Frame:
        return self._look(target_frame, source_frame, time, 0.0)

    def waitForTransform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any, polling_sleep_duration: Any = None
    ) -> None:
        self._look(target_frame, source_frame, time, seconds(timeout))

    def canTransform(self, target_frame: str, source_frame: str, time: Any = 0) -> bool:
        try:
            self._look(target_frame, source_frame, time, 0.0)
        except LookupException:
            return False
        return True

    def getLatestCommonTime(self, source_frame: str, target_frame: str) -> Any:
        """Return the time; a transform of the time 0 is the last one."""
        return now()

    def _look(self, target: str, source: str, time: Any, timeout: float) -> Frame:
        try:
            return ros().transform(target.strip("/"), source.strip("/"), seconds(time) or None, timeout)
        except NoFrameError as error:
            raise LookupException(str(error)) from None

    def _in(self, target: str, stamped: Any) -> Any:
        header = stamped.header
        move, turn = self._look(target, header.frame_id, header.stamp, 0.0)
        return transformations.concatenate_matrices(
            transformations.translation_matrix(move), transformations.quaternion_matrix(turn)
        )

    def transformPoint(self, target_frame: str, ps: Any) -> Any:
        moved = self._in(target_frame, ps) @ (ps.point.x, ps.point.y, ps.point.z, 1.0)
        made = type(ps)()
        made.header.frame_id, made.header.stamp = target_frame, ps.header.stamp
        made.point.x, made.point.y, made.point.z = map(float, moved[:3])
        return made

    def transformPose(self, target_frame: str, ps: Any) -> Any:
        there, here = self._in(target_frame, ps), ps.pose
        place = transformations.translation_matrix((here.position.x, here.position.y, here.position.z))
        turn = (here.orientation.x, here.orientation.y, here.orientation.z, here.orientation.w)
        moved = there @ place @ transformations.quaternion_matrix(turn)
        made = type(ps)()
        made.header.frame_id, made.header.stamp = target_frame, ps.header.stamp
        made.pose.position.x, made.pose.position.y, made.pose.position.z = map(float, moved[:3, 3])
        turned = transformations.quaternion_from_matrix(moved)
        for axis, value in zip("xyzw", turned, strict=True):
            setattr(made.pose.orientation, axis, float(value))
        return made


class TransformBroadcaster:
    """Tells others where frames are."""

    def sendTransform(self, translation: Any, rotation: Any, time: Any, child: str, parent: str) -> None:
        ros().broadcast(parent.strip("/"), child.strip("/"), tuple(translation), tuple(rotation), seconds(time))


globals()["Exception"] = LookupException  # `tf.Exception`, after all classes that derive from Python's
__all__ = ["Duration", "Time", "TransformBroadcaster", "TransformListener", "transformations"]
