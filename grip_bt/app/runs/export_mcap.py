"""A run of the journal as an MCAP file for Foxglove: events, values, and the robot and the scene as they moved."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.base.values import DepthImage, Grasp, Image, PointCloud, Pose, RgbdFrame
from grip_bt.runtime import Event, JournalReader, RunRecord

from .motion_record import moments, motion_file

Message = tuple[str, dict[str, Any]]

_TIME = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0}},
}
_BYTES = {"type": "string", "contentEncoding": "base64"}
_NUMBER, _STRING, _COUNT = {"type": "number"}, {"type": "string"}, {"type": "integer", "minimum": 0}


def _object(**properties: object) -> dict[str, object]:
    return {"type": "object", "properties": properties}


def _stamped(**properties: object) -> dict[str, object]:
    return _object(timestamp=_TIME, frame_id=_STRING, **properties)


def _list_of(items: object) -> dict[str, object]:
    return {"type": "array", "items": items}


_XYZ = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_TURN = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)
_POSE = _object(position=_XYZ, orientation=_TURN)
_FIELDS = _list_of(_object(name=_STRING, offset=_COUNT, type=_COUNT))
_MOVED = {"parent_frame_id": _STRING, "child_frame_id": _STRING, "translation": _XYZ, "rotation": _TURN}
_PRIMITIVES = ("cubes", "spheres", "cylinders", "triangles")
_UINT8, _FLOAT32 = 1, 7
"""Of foxglove.PackedElementField."""
COLUMNS = ("seq", "t", "wall", "path", "event", "outcome", "code", "data", "meaning")
_TYPES: dict[str, dict[str, Any]] = {"seq": {"type": "integer"}, "t": _NUMBER, "wall": _NUMBER, "data": _object()}
_TYPES |= dict.fromkeys(("path", "event"), _STRING)
_TYPES |= dict.fromkeys(("outcome", "code", "meaning"), {"type": ["string", "null"]})
SCHEMAS: dict[str, dict[str, object]] = {
    "grip.Event": _object(**{column: _TYPES[column] for column in COLUMNS}),
    "grip.Text": _object(data=_STRING),
    "grip.Value": _object(preview=_STRING, value={}),
    "foxglove.Log": _object(timestamp=_TIME, level=_COUNT, message=_STRING, name=_STRING, file=_STRING, line=_COUNT),
    "foxglove.PoseInFrame": _stamped(pose=_POSE),
    "foxglove.PosesInFrame": _stamped(poses=_list_of(_POSE)),
    "foxglove.PointCloud": _stamped(pose=_POSE, point_stride=_COUNT, fields=_FIELDS, data=_BYTES),
    "foxglove.RawImage": _stamped(width=_COUNT, height=_COUNT, encoding=_STRING, step=_COUNT, data=_BYTES),
    "foxglove.FrameTransforms": _object(transforms=_list_of(_object(timestamp=_TIME, **_MOVED))),
    "foxglove.SceneUpdate": _object(deletions=_list_of(_object()), entities=_list_of(_object())),
}


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


_INFO, _WARNING, _ERROR = 2, 3, 4
"""Levels of foxglove.Log."""


@contextmanager
def write_mcap(reader: JournalReader, record: RunRecord, file: Path) -> Iterator[Callable[[Event], object]]:
    """Write a run to an MCAP file.

    Topics: `/grip/events` (everything), `/grip/log` (for people), `/grip/data/VARIABLE` (what was written),
    `/grip/scene`, `/robot_description` and `/tf`, by which Foxglove draws the robot. Times are wall times, so that a
    recording of ROS topics made meanwhile lies beside it.
    """
    from mcap.writer import Writer  # of the extra `recording`

    times: list[tuple[float, float]] = []
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="", library="grip")
        writer.add_metadata("run", {k: "" if value is None else str(value) for k, value in asdict(record).items()})
        channels = _Channels(writer)

        def write(event: Event) -> None:
            times.append((event.t, event.wall))
            _add(channels, reader, event)

        yield write
        with suppress(GripError, ImportError, OSError):  # without its robot, or its motion, the rest is worth a look
            _drawn(channels, record, np.array(times), motion_file(reader.file, record.id))
        writer.finish()


class _Channels:
    def __init__(self, writer: Any):
        self._writer = writer
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        self._sent = 0

    def send(self, topic: str, schema: str, nanoseconds: int, message: dict[str, Any]) -> None:
        """Add a message."""
        channel = self._channels.get((topic, schema))
        if channel is None:
            if schema not in self._schemas:
                text = json.dumps({"title": schema, **SCHEMAS[schema]}).encode()
                self._schemas[schema] = self._writer.register_schema(schema, "jsonschema", text)
            channel = self._writer.register_channel(topic, "json", self._schemas[schema])
            self._channels[topic, schema] = channel
        data = json.dumps(message, default=str).encode()
        self._sent += 1
        self._writer.add_message(channel, nanoseconds, data, nanoseconds, self._sent)


def _add(channels: _Channels, reader: JournalReader, event: Event) -> None:
    nanoseconds = round(event.wall * 1e9)
    channels.send("/grip/events", "grip.Event", nanoseconds, asdict(event))
    text, level = _line(event)
    log = {"timestamp": stamp(nanoseconds), "level": level, "message": text, "name": event.path, "file": "", "line": 0}
    channels.send("/grip/log", "foxglove.Log", nanoseconds, log)
    if event.event == "write":
        topic = f"/grip/data/{event.data['variable']}"
        try:
            found = messages(reader.value(event), nanoseconds)
        except GripError:
            found = {}
        kept: dict[str, object] = {key: event.data[key] for key in ("preview", "value") if key in event.data}
        for suffix, (schema, message) in (found or {"": ("grip.Value", kept)}).items():
            channels.send(topic + suffix, schema, nanoseconds, message)


def _line(event: Event) -> tuple[str, int]:
    code = f" ({event.code})" if event.code else ""
    said = [str(event.data[key]) for key in event.data if key in ("text", "message", "variable", "preview", "status")]
    text = " ".join([event.event, *([event.outcome + code] if event.outcome else []), *said])
    poor = event.meaning == "failure" or event.event == "interrupted"
    level = _ERROR if event.event == "error" else _WARNING if poor else _INFO
    return text, level


def _drawn(channels: _Channels, record: RunRecord, times: np.ndarray[Any, Any], motion: Path) -> None:
    """Write what draws the robot and the scene as they moved.

    Args:
        times: of the events, shape (n, 2): on the run's clock, and by the wall's [s].
        motion: what `motion_record` has kept.
    """
    from grip_bt.commanders.kinematics.model import RobotModel

    model = RobotModel(find_project(record.task_path).description())
    channels.send("/robot_description", "grip.Text", round(times[0, 1] * 1e9), {"data": model.description.urdf})
    there = dict[str, Any]()
    for moment in moments(motion, model):
        at = round(float(np.interp(moment.t, *times.T)) * 1e9)
        if moment.links:
            moved = [_transform(link, pose, at) for link, pose in moment.links.items()]
            channels.send("/tf", "foxglove.FrameTransforms", at, {"transforms": moved})
        if moment.scene is not None:
            before, there = there, dict(moment.scene)
            gone = [{"timestamp": stamp(at), "type": 0, "id": name} for name in before if name not in there]
            new = [_entity(name, it, moment.bodies, at) for name, it in there.items() if it != before.get(name)]
            channels.send("/grip/scene", "foxglove.SceneUpdate", at, {"deletions": gone, "entities": new})


def _transform(link: str, pose: Pose, at: int) -> dict[str, object]:
    fields = _pose_fields(pose)
    place = {"translation": fields["position"], "rotation": fields["orientation"]}
    return {"timestamp": stamp(at), "parent_frame_id": "world", "child_frame_id": link, **place}


def _entity(name: str, thing: Mapping[str, Any], bodies: Mapping[str, Any], at: int) -> dict[str, Any]:
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
