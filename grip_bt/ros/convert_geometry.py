"""Poses, joints and trajectories to and from messages. Only here do quaternions have another order than w x y z."""

from __future__ import annotations

from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Transform, TransformStamped, Vector3
from geometry_msgs.msg import Pose as PoseMessage
from numpy.typing import NDArray
from sensor_msgs.msg import JointState as JointStateMessage
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from grip_bt.base.values import JointState, Pose, Trajectory

DEFAULT_FRAME = "world"
"""The frame of a message that names none."""


def header(frame: str, time: float = 0.0) -> Header:
    """Return a header of `frame` at `time` [s] of the run's clock."""
    return Header(frame_id=frame, stamp=Time(**_split(time)))


def seconds(stamp: Any) -> float:
    """Return a stamp or a duration in seconds."""
    return float(stamp.sec + stamp.nanosec * 1e-9)


def pose_to_message(pose: Pose) -> PoseMessage:
    """Convert a pose; its frame is lost."""
    x, y, z = map(float, pose.position)
    return PoseMessage(position=Point(x=x, y=y, z=z), orientation=_quaternion(pose))


def pose_from_message(message: PoseMessage | Transform, frame: str = DEFAULT_FRAME) -> Pose:
    """Convert a pose, or a transform that maps the posed body to `frame`."""
    if isinstance(message, Transform):
        p, q = message.translation, message.rotation
    else:
        p, q = message.position, message.orientation
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.w, q.x, q.y, q.z]), frame or DEFAULT_FRAME)


def pose_to_stamped(pose: Pose) -> PoseStamped:
    """Convert a pose with its frame."""
    return PoseStamped(header=header(pose.frame), pose=pose_to_message(pose))


def pose_from_stamped(message: PoseStamped | TransformStamped) -> Pose:
    """Convert a pose or a transform with its frame."""
    inner = message.transform if isinstance(message, TransformStamped) else message.pose
    return pose_from_message(inner, message.header.frame_id)


def pose_to_transform(pose: Pose) -> Transform:
    """Convert a pose to the transform that maps the posed body to the pose's frame."""
    x, y, z = map(float, pose.position)
    return Transform(translation=Vector3(x=x, y=y, z=z), rotation=_quaternion(pose))


def pose_to_transform_stamped(pose: Pose) -> TransformStamped:
    """Convert a pose with its frame; the child frame is left empty."""
    return TransformStamped(header=header(pose.frame), transform=pose_to_transform(pose))


def joints_to_message(state: JointState) -> JointStateMessage:
    """Convert a joint state; unknown velocities and efforts are left empty."""
    return JointStateMessage(
        header=header("", state.time),
        name=list(state.names),
        position=state.position.tolist(),
        velocity=[] if state.velocity is None else state.velocity.tolist(),
        effort=[] if state.effort is None else state.effort.tolist(),
    )


def joints_from_message(message: JointStateMessage) -> JointState:
    """Convert a joint state; empty velocities and efforts are unknown."""
    return JointState(
        tuple(message.name),
        np.asarray(message.position),
        np.asarray(message.velocity) if message.velocity else None,
        np.asarray(message.effort) if message.effort else None,
        seconds(message.header.stamp),
    )


def trajectory_to_message(trajectory: Trajectory, ahead: float = 0.0) -> JointTrajectory:
    """Convert a trajectory, whose first point is due `ahead` [s] after its beginning."""

    def row(values: NDArray[np.float64] | None, k: int) -> list[float]:
        return [] if values is None else values[k].tolist()

    points = [
        JointTrajectoryPoint(
            positions=row(trajectory.positions, k),
            velocities=row(trajectory.velocities, k),
            accelerations=row(trajectory.accelerations, k),
            time_from_start=Duration(**_split(float(time) + ahead)),
        )
        for k, time in enumerate(trajectory.times)
    ]
    return JointTrajectory(joint_names=list(trajectory.names), points=points)


def trajectory_from_message(message: JointTrajectory) -> Trajectory:
    """Convert a trajectory; velocities and accelerations are kept when every point has them."""
    points = message.points

    def rows(name: str) -> NDArray[np.float64] | None:
        values = [getattr(p, name) for p in points]
        return np.array(values) if values and all(len(v) for v in values) else None

    times = np.array([seconds(p.time_from_start) for p in points])
    positions = np.array([p.positions for p in points])
    return Trajectory(tuple(message.joint_names), times, positions, rows("velocities"), rows("accelerations"))


def _quaternion(pose: Pose) -> Quaternion:
    w, x, y, z = map(float, pose.quaternion)
    return Quaternion(x=x, y=y, z=z, w=w)


def _split(time: float) -> dict[str, int]:
    nanoseconds = round(time * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}
