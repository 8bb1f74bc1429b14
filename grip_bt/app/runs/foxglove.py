"""Values as messages of Foxglove's well-known schemas, in JSON; https://docs.foxglove.dev/docs/sdk/schemas.

Each function returns the schema's name and the message. Quaternions change from w x y z to fields here.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from grip_bt.base.values import DepthImage, Grasp, Image, PointCloud, Pose, RgbdFrame

Message = tuple[str, dict[str, Any]]

_TIME = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0}},
}
_BYTES = {"type": "string", "contentEncoding": "base64"}
_NUMBER, _STRING, _COUNT = {"type": "number"}, {"type": "string"}, {"type": "integer", "minimum": 0}


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


_XYZ = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_POSE = _object(position=_XYZ, orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER))
_FIELD = _object(name=_STRING, offset=_COUNT, type=_COUNT)
_UINT8, _FLOAT32 = 1, 7
"""Of foxglove.PackedElementField."""

SCHEMAS: dict[str, dict[str, Any]] = {
    "foxglove.Log": _object(timestamp=_TIME, level=_COUNT, message=_STRING, name=_STRING, file=_STRING, line=_COUNT),
    "foxglove.PoseInFrame": _object(timestamp=_TIME, frame_id=_STRING, pose=_POSE),
    "foxglove.PosesInFrame": _object(timestamp=_TIME, frame_id=_STRING, poses={"type": "array", "items": _POSE}),
    "foxglove.PointCloud": _object(
        timestamp=_TIME,
        frame_id=_STRING,
        pose=_POSE,
        point_stride=_COUNT,
        fields={"type": "array", "items": _FIELD},
        data=_BYTES,
    ),
    "foxglove.RawImage": _object(
        timestamp=_TIME, frame_id=_STRING, width=_COUNT, height=_COUNT, encoding=_STRING, step=_COUNT, data=_BYTES
    ),
}


def stamp(nanoseconds: int) -> dict[str, int]:
    """Return a time since 1970."""
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def messages(value: Any, nanoseconds: int) -> dict[str, Message]:
    """Return what Foxglove can draw of a value: suffix of the topic -> message; empty for anything else."""
    match value:
        case Pose():
            return {"": _pose(value, nanoseconds)}
        case Grasp():
            return {"": _poses([value], nanoseconds)}
        case [Grasp(), *_] if all(isinstance(grasp, Grasp) for grasp in value):
            return {"": _poses(value, nanoseconds)}
        case PointCloud():
            return {"": _cloud(value, nanoseconds)}
        case Image():
            return {"": _image(value, nanoseconds)}
        case DepthImage():
            return {"": _depth(value, nanoseconds)}
        case RgbdFrame():
            return {"/image": _image(value.image, nanoseconds), "/depth": _depth(value.depth, nanoseconds)}
    return {}


def _pose_fields(pose: Pose) -> dict[str, Any]:
    position = dict(zip("xyz", map(float, pose.position), strict=True))
    return {"position": position, "orientation": dict(zip("wxyz", map(float, pose.quaternion), strict=True))}


def _pose(pose: Pose, nanoseconds: int) -> Message:
    message = {"timestamp": stamp(nanoseconds), "frame_id": pose.frame, "pose": _pose_fields(pose)}
    return "foxglove.PoseInFrame", message


def _poses(grasps: list[Grasp], nanoseconds: int) -> Message:
    poses = [_pose_fields(grasp.pose) for grasp in grasps]
    frame = grasps[0].pose.frame
    return "foxglove.PosesInFrame", {"timestamp": stamp(nanoseconds), "frame_id": frame, "poses": poses}


def _cloud(cloud: PointCloud, nanoseconds: int) -> Message:
    fields = [{"name": name, "offset": 4 * i, "type": _FLOAT32} for i, name in enumerate("xyz")]
    parts = [np.ascontiguousarray(cloud.points, "<f4").view(np.uint8).reshape(-1, 12)]
    if cloud.colors is not None:
        opaque = np.full((len(cloud.points), 1), 255, np.uint8)
        parts += [cloud.colors, opaque]
        fields += [
            {"name": name, "offset": 12 + i, "type": _UINT8} for i, name in enumerate(("red", "green", "blue", "alpha"))
        ]
    packed = np.hstack(parts)
    return "foxglove.PointCloud", {
        "timestamp": stamp(nanoseconds),
        "frame_id": cloud.frame,
        "pose": _pose_fields(Pose()),
        "point_stride": packed.shape[1],
        "fields": fields,
        "data": base64.b64encode(packed.tobytes()).decode(),
    }


def _raw(frame: str, pixels: np.ndarray[Any, Any], encoding: str, nanoseconds: int) -> Message:
    return "foxglove.RawImage", {
        "timestamp": stamp(nanoseconds),
        "frame_id": frame,
        "width": pixels.shape[1],
        "height": pixels.shape[0],
        "encoding": encoding,
        "step": pixels.strides[0],
        "data": base64.b64encode(pixels.tobytes()).decode(),
    }


def _image(image: Image, nanoseconds: int) -> Message:
    return _raw(image.frame, np.ascontiguousarray(image.pixels), "rgb8", nanoseconds)


def _depth(image: DepthImage, nanoseconds: int) -> Message:
    return _raw(image.info.pose.frame, np.ascontiguousarray(image.depth, "<f4"), "32FC1", nanoseconds)
