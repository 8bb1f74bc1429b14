"""`tf`: frames, as ROS 2's TF has them; and `tf.transformations`.

Rotations are about fixed or own axes, as matrices of 4 by 4 and quaternions x, y, z, w. Axes are named as there: `sxyz`
about the fixed axes x, y and z, in this order; `rxyz` about those that turn along.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from grip_bt.smach_compat.ros1 import Duration, Time, now
from grip_bt.smach_compat.smach_ros._connection import ros, seconds
from grip_bt.smach_compat.smach_ros._port import NoFrameError

_Array = Any


def _axes(axes: str) -> str:
    return axes[1:].lower() if axes[0] == "s" else axes[1:].upper()


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = "sxyz") -> _Array:
    """Return the quaternion of three angles [rad]."""
    return Rotation.from_euler(_axes(axes), [ai, aj, ak]).as_quat()


def euler_from_quaternion(quaternion: _Array, axes: str = "sxyz") -> tuple[float, ...]:
    """Return three angles [rad]."""
    return tuple(float(angle) for angle in Rotation.from_quat(np.asarray(quaternion, float)).as_euler(_axes(axes)))


def quaternion_matrix(quaternion: _Array) -> _Array:
    return _matrix(rotation=Rotation.from_quat(quaternion).as_matrix())


def quaternion_from_matrix(matrix: _Array) -> _Array:
    return Rotation.from_matrix(np.asarray(matrix, float)[:3, :3]).as_quat()


def euler_matrix(ai: float, aj: float, ak: float, axes: str = "sxyz") -> _Array:
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: _Array, axes: str = "sxyz") -> tuple[float, ...]:
    return euler_from_quaternion(quaternion_from_matrix(matrix), axes)


def quaternion_multiply(quaternion1: _Array, quaternion0: _Array) -> _Array:
    """Return the rotation that is first the second one, then the first."""
    (x1, y1, z1, w1), (x0, y0, z0, w0) = quaternion1, quaternion0
    vector = np.cross((x1, y1, z1), (x0, y0, z0)) + w1 * np.array((x0, y0, z0)) + w0 * np.array((x1, y1, z1))
    return np.array((*vector, w1 * w0 - x1 * x0 - y1 * y0 - z1 * z0))


def quaternion_conjugate(quaternion: _Array) -> _Array:
    return np.array(quaternion, float) * (-1, -1, -1, 1)


def quaternion_inverse(quaternion: _Array) -> _Array:
    return quaternion_conjugate(quaternion) / np.dot(quaternion, quaternion)


def quaternion_about_axis(angle: float, axis: _Array) -> _Array:
    """Return the quaternion of an angle [rad] about an axis of any length."""
    axis = np.asarray(axis, float)
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_quat()


def rotation_matrix(angle: float, direction: _Array) -> _Array:
    """Return the matrix of an angle [rad] about an axis through the origin."""
    return quaternion_matrix(quaternion_about_axis(angle, direction))


def translation_matrix(direction: _Array) -> _Array:
    return _matrix(translation=direction)


def translation_from_matrix(matrix: _Array) -> _Array:
    return np.array(matrix, float)[:3, 3]


def concatenate_matrices(*matrices: _Array) -> _Array:
    return np.linalg.multi_dot([np.eye(4), np.eye(4), *matrices])


inverse_matrix, identity_matrix = np.linalg.inv, partial(np.eye, 4)


def _matrix(rotation: _Array = None, translation: _Array = (0, 0, 0)) -> _Array:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = np.eye(3) if rotation is None else rotation, translation
    return made


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
        """Return the matrix from the frame of what has one, and a new one in the target's."""
        header, made = stamped.header, type(stamped)()
        move, turn = self._look(target, header.frame_id, header.stamp, 0.0)
        made.header.frame_id, made.header.stamp = target, header.stamp
        return concatenate_matrices(translation_matrix(move), quaternion_matrix(turn)), made

    def transformPoint(self, target_frame: str, ps: Any) -> Any:
        there, made = self._in(target_frame, ps)
        made.point.x, made.point.y, made.point.z = map(float, (there @ (ps.point.x, ps.point.y, ps.point.z, 1.0))[:3])
        return made

    def transformPose(self, target_frame: str, ps: Any) -> Any:
        (there, made), here = self._in(target_frame, ps), ps.pose
        place = translation_matrix((here.position.x, here.position.y, here.position.z))
        turn = (here.orientation.x, here.orientation.y, here.orientation.z, here.orientation.w)
        moved = there @ place @ quaternion_matrix(turn)
        made.pose.position.x, made.pose.position.y, made.pose.position.z = map(float, moved[:3, 3])
        for axis, value in zip("xyzw", quaternion_from_matrix(moved), strict=True):
            setattr(made.pose.orientation, axis, float(value))
        return made


class TransformBroadcaster:
    """Tells others where frames are."""

    def sendTransform(self, translation: Any, rotation: Any, time: Any, child: str, parent: str) -> None:
        ros().broadcast(parent.strip("/"), child.strip("/"), tuple(translation), tuple(rotation), seconds(time))


globals()["Exception"] = LookupException  # `tf.Exception`, after all classes that derive from Python's
transformations = sys.modules[__name__]
__all__ = ["Duration", "Time", "TransformBroadcaster", "TransformListener", "transformations"]
