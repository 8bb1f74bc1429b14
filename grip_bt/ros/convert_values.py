"""Poses, joints, trajectories, clouds and images to and from messages, without a Python loop over points or pixels.

Only here do quaternions have another order than w x y z.
"""

from __future__ import annotations

import array
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Transform, TransformStamped, Vector3
from geometry_msgs.msg import Pose as PoseMessage
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo as CameraInfoMessage
from sensor_msgs.msg import Image as ImageMessage
from sensor_msgs.msg import JointState as JointStateMessage
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from grip_bt.base.values import CameraInfo, DepthImage, Image, JointState, PointCloud, Pose, Trajectory

from .client.types import ConversionError

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


_FLOATS = {PointField.FLOAT32: "f4", PointField.FLOAT64: "f8"}
_CHANNELS = {"rgb8": (0, 1, 2), "bgr8": (2, 1, 0), "rgba8": (0, 1, 2), "bgra8": (2, 1, 0), "mono8": (0, 0, 0)}


def cloud_to_message(cloud: PointCloud) -> PointCloud2:
    """Convert a cloud to x y z as float32, and its colours, if any, to the usual packed `rgb`."""
    names = ("x", "y", "z") if cloud.colors is None else ("x", "y", "z", "rgb")
    n, step = len(cloud.points), 4 * len(names)
    data = array.array("B", bytes(1)) * (n * step)  # written in place: a second copy of a big cloud costs a millisecond
    table = np.frombuffer(data, "<f4").reshape(n, len(names))
    for column in range(3):  # much quicker than row by row
        table[:, column] = cloud.points[:, column]
    if cloud.colors is not None:
        for channel in range(3):  # as numbers 0x00RRGGBB: none is NaN as a float
            table.view(np.uint8)[:, 14 - channel] = cloud.colors[:, channel]
    message = PointCloud2(
        header=header(cloud.frame, cloud.time),
        height=1,
        width=n,
        fields=[
            PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, name in enumerate(names)
        ],
        is_bigendian=False,
        point_step=step,
        row_step=step * n,
        is_dense=bool(np.isfinite(cloud.points).all()),
    )
    message.data = data  # not by the constructor: that copies it
    return message


def cloud_from_message(message: PointCloud2) -> PointCloud:
    """Convert a cloud with fields x, y, z (float32 or float64) and perhaps `rgb` or `rgba`.

    Points that aren't finite, which stand for "nothing seen" in an organised cloud, are left out.

    Raises:
        ConversionError: a coordinate is missing or isn't a float, or there is less data than the sizes say.
    """
    fields = {f.name: f for f in message.fields}
    needed = message.height * message.row_step
    if len(message.data) < needed or message.row_step < message.width * message.point_step:
        raise ConversionError("data", f"holds {len(message.data)} bytes, {needed} are announced")
    for name in "xyz":
        if name not in fields:
            raise ConversionError("fields", f"no {name!r} (available: {', '.join(fields)})")
        if fields[name].datatype not in _FLOATS:
            raise ConversionError("fields", f"{name!r} is neither float32 nor float64")
    order = ">" if message.is_bigendian else "<"
    kinds = {name: (order + _FLOATS[fields[name].datatype], fields[name].offset) for name in "xyz"}
    packed = fields.get("rgb") or fields.get("rgba")
    if packed is not None:  # numbers 0xAARRGGBB
        kinds |= {c: ("u1", packed.offset + (1 + k if message.is_bigendian else 2 - k)) for k, c in enumerate("rgb")}
    formats, offsets = zip(*kinds.values(), strict=True)
    dtype = np.dtype({"names": [*kinds], "formats": formats, "offsets": offsets, "itemsize": message.point_step})
    table = _view(message.data, (message.height, message.width), dtype, 0, (message.row_step, message.point_step))
    points, colors = _columns(table, "xyz", np.float32), _columns(table, "rgb", np.uint8) if packed else None
    if not message.is_dense:
        seen = np.isfinite(points).all(axis=1)
        points, colors = points[seen], None if colors is None else colors[seen]
    return PointCloud(points, colors, message.header.frame_id or DEFAULT_FRAME, seconds(message.header.stamp))


def image_to_message(image: Image) -> ImageMessage:
    """Convert a colour image to `rgb8`."""
    return _image_message(image.pixels, "rgb8", header(image.frame, image.time))


def image_from_message(message: ImageMessage) -> Image:
    """Convert an image of 8 bits a channel.

    Raises:
        ConversionError: another encoding, or less data than the sizes say.
    """
    order = _CHANNELS.get(message.encoding)
    if order is None:
        raise ConversionError("encoding", f"{message.encoding!r} isn't one of {', '.join(_CHANNELS)}")
    depth = {"mono8": 1, "rgba8": 4, "bgra8": 4}.get(message.encoding, 3)
    shape, strides = (message.height, message.width, depth), (message.step, depth, 1)
    pixels = _view(message.data, shape, "u1", 0, strides)
    return Image(pixels[:, :, order], message.header.frame_id, seconds(message.header.stamp))


def depth_to_message(depth: DepthImage) -> ImageMessage:
    """Convert a depth image to `32FC1` [m]; the camera's geometry goes by `camera_to_message`."""
    return _image_message(depth.depth.astype("<f4", copy=False), "32FC1", header(depth.info.pose.frame, depth.time))


def _image_message(values: NDArray[Any], encoding: str, head: Header) -> ImageMessage:
    rows, columns = values.shape[:2]
    step = columns * values.itemsize * (values.shape[2] if values.ndim == 3 else 1)
    message = ImageMessage(header=head, height=rows, width=columns, encoding=encoding, is_bigendian=0, step=step)
    message.data = _bytes(values)
    return message


def depth_from_message(message: ImageMessage, info: CameraInfo) -> DepthImage:
    """Convert a depth image in metres (`32FC1`) or millimetres (`16UC1`); what isn't finite becomes 0, nothing seen.

    Raises:
        ConversionError: another encoding, another size than the camera's, or less data than the sizes say.
    """
    kinds = {"32FC1": ("<f4", 4, 1.0), "16UC1": ("<u2", 2, 0.001)}
    if message.encoding not in kinds:
        raise ConversionError("encoding", f"{message.encoding!r} isn't one of {', '.join(kinds)}")
    if (message.height, message.width) != (info.height, info.width):
        size = f"{message.width} x {message.height}"
        raise ConversionError("width", f"it is {size}, the camera {info.width} x {info.height}")
    kind, size_of, unit = kinds[message.encoding]
    raw = _view(message.data, (message.height, message.width), kind, 0, (message.step, size_of))
    depth = raw.astype(np.float32) * np.float32(unit)
    return DepthImage(np.where(np.isfinite(depth), depth, np.float32(0)), info, seconds(message.header.stamp))


def camera_to_message(info: CameraInfo) -> CameraInfoMessage:
    """Convert a camera's geometry; ROS has pixel centres at whole numbers, so the principal point moves by a half."""
    matrix = np.array(info.matrix)
    matrix[:2, 2] -= 0.5
    projection = np.hstack([matrix, np.zeros((3, 1))])
    return CameraInfoMessage(
        header=header(info.pose.frame),
        height=info.height,
        width=info.width,
        distortion_model="plumb_bob",
        d=[0.0] * 5,
        k=matrix.ravel(),
        r=np.eye(3).ravel(),
        p=projection.ravel(),
    )


def camera_from_message(message: CameraInfoMessage) -> CameraInfo:
    """Convert a camera's geometry; its pose is the identity in the message's optical frame."""
    matrix = np.array(message.k, dtype=float).reshape(3, 3)
    matrix[:2, 2] += 0.5
    return CameraInfo(message.width, message.height, matrix, Pose(frame=message.header.frame_id or DEFAULT_FRAME))


def _columns(table: NDArray[Any], names: str, kind: type[np.generic]) -> NDArray[Any]:
    """Return numbers of every point, shape (n, 3)."""
    made = np.empty((table.size, len(names)), kind)
    for column, name in enumerate(names):  # much quicker than row by row
        made[:, column] = table[name].reshape(-1)
    return made


def _view(data: Any, shape: tuple[int, ...], dtype: Any, offset: int, strides: tuple[int, ...]) -> NDArray[Any]:
    if 0 in shape:
        return np.zeros(shape, dtype)
    try:
        return np.ndarray(shape, dtype, buffer=data, offset=offset, strides=strides)
    except (TypeError, ValueError) as error:
        raise ConversionError("data", f"doesn't hold what the sizes announce: {error}") from None


def _bytes(values: NDArray[Any]) -> array.array[int]:
    """Return the memory of an array as the one type of sequence that messages take without a look at each element."""
    data = array.array("B")
    if values.size:
        data.frombytes(memoryview(np.ascontiguousarray(values).data).cast("B"))
    return data
