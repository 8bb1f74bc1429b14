"""Foxglove's messages: their schemas, and what of our values and scenes they can draw."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike

from grip_bt.base.values import DepthImage, Grasp, Image, PointCloud, Pose, RgbdFrame

Message = tuple[str, dict[str, Any]]

_PRIMITIVES = ("cubes", "spheres", "cylinders", "triangles")
_UINT8, _FLOAT32 = 1, 7
"""Of foxglove.PackedElementField."""
COLUMNS = ("seq", "t", "wall", "path", "event", "outcome", "code", "data", "meaning")
_FILE = Path(__file__).with_name("foxglove.yaml")
SCHEMAS: dict[str, dict[str, object]] = yaml.safe_load(_FILE.read_text("utf-8"))["schemas"]


def stamp(nanoseconds: int) -> dict[str, int]:
    """Return a time since 1970."""
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def messages(value: Any, nanoseconds: int) -> dict[str, Message]:
    """Return what Foxglove can draw of a value: suffix of the topic -> message; empty for anything else."""
    if isinstance(value, RgbdFrame):
        seen = {"/image": value.image, "/depth": value.depth}
        return {suffix: messages(each, nanoseconds)[""] for suffix, each in seen.items()}
    match value:
        case Pose():
            kind, frame, fields = "PoseInFrame", value.frame, dict[str, Any](pose=_pose_fields(value))
        case Grasp():
            return messages([value], nanoseconds)
        case [Grasp(), *_] if all(isinstance(grasp, Grasp) for grasp in value):
            poses = [_pose_fields(grasp.pose) for grasp in value]
            kind, frame, fields = "PosesInFrame", value[0].pose.frame, {"poses": poses}
        case PointCloud():
            kind, frame, fields = "PointCloud", value.frame, _cloud(value)
        case Image():
            kind, frame, fields = "RawImage", value.frame, _raw(np.ascontiguousarray(value.pixels), "rgb8")
        case DepthImage():
            depth = np.ascontiguousarray(value.depth, "<f4")
            kind, frame, fields = "RawImage", value.info.pose.frame, _raw(depth, "32FC1")
        case _:
            return {}
    return {"": (f"foxglove.{kind}", {"timestamp": stamp(nanoseconds), "frame_id": frame, **fields})}


def _pose_fields(pose: Pose) -> dict[str, object]:
    position = dict(zip("xyz", map(float, pose.position), strict=True))
    return {"position": position, "orientation": dict(zip("wxyz", map(float, pose.quaternion), strict=True))}


def _cloud(cloud: PointCloud) -> dict[str, object]:
    fields = [{"name": name, "offset": 4 * i, "type": _FLOAT32} for i, name in enumerate("xyz")]
    parts = [np.ascontiguousarray(cloud.points, "<f4").view(np.uint8).reshape(-1, 12)]
    if cloud.colors is not None:
        opaque = np.full((len(cloud.points), 1), 255, np.uint8)
        parts += [cloud.colors, opaque]
        colours = enumerate(("red", "green", "blue", "alpha"), 12)
        fields += [{"name": name, "offset": offset, "type": _UINT8} for offset, name in colours]
    packed = np.hstack(parts)
    data = base64.b64encode(packed.tobytes()).decode()
    return {"pose": _pose_fields(Pose()), "point_stride": packed.shape[1], "fields": fields, "data": data}


def _raw(pixels: np.ndarray[Any, Any], encoding: str) -> dict[str, Any]:
    size = {"width": pixels.shape[1], "height": pixels.shape[0], "step": pixels.strides[0]}
    return {**size, "encoding": encoding, "data": base64.b64encode(pixels.tobytes()).decode()}


def transform(link: str, pose: Pose, at: int) -> dict[str, object]:
    """Return where a link is in world, at a time since 1970 [ns]."""
    fields = _pose_fields(pose)
    place = {"translation": fields["position"], "rotation": fields["orientation"]}
    return {"timestamp": stamp(at), "parent_frame_id": "world", "child_frame_id": link, **place}


def entity(name: str, thing: Mapping[str, Any], bodies: Mapping[str, Any], at: int) -> dict[str, Any]:
    """Return an object of the scene: grey what never moves, the others yellow."""
    grey, yellow = {"r": 0.6, "g": 0.6, "b": 0.6, "a": 1.0}, {"r": 0.9, "g": 0.7, "b": 0.2, "a": 1.0}
    place, size, colour = Pose(thing["at"][:3], thing["at"][3:]), thing["size"], grey if thing["fixed"] else yellow

    def part(pose: Pose = place, **more: Any) -> dict[str, Any]:
        return {"pose": _pose_fields(pose), "color": colour, **more}

    body = {key: base64.b64decode(text) for key, text in bodies.get(str(thing.get("body")), {}).items()}
    points = np.frombuffer(body.get("points", b""), "<f4").reshape(-1, 3).astype(float)
    parts: dict[str, list[dict[str, Any]]] = {kind: [] for kind in _PRIMITIVES}
    match thing["kind"]:
        case "box":
            parts["cubes"] = [part(size=_xyz(size))]
        case "cylinder":
            parts["cylinders"] = [part(size=_xyz((2 * size[0], 2 * size[0], size[1])))]
        case "sphere":
            parts["spheres"] = [part(size=_xyz([2 * size[0]] * 3))]
        case "cells":
            parts["cubes"] = [part(place @ Pose(point), size=_xyz([size[0]] * 3)) for point in points]
        case _:
            indices = np.frombuffer(body["triangles"], "<u4").tolist()
            parts["triangles"] = [part(points=[_xyz(point) for point in points], indices=indices)]
    return {"timestamp": stamp(at), "frame_id": "world", "id": name, "frame_locked": True, **parts}


def _xyz(point: ArrayLike) -> dict[str, float]:
    return dict(zip("xyz", np.asarray(point, dtype=float).tolist(), strict=True))
