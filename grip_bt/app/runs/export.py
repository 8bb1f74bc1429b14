"""A run of the journal as a file for other tools: lines of JSON, a table, or a recording that Foxglove opens."""

from __future__ import annotations

import base64
import csv
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.base.errors import DocumentError, GripError, MissingPartError, UnknownNameError
from grip_bt.base.values import DepthImage, Grasp, Image, PointCloud, Pose, RgbdFrame
from grip_bt.runtime import Event, JournalReader

Message = tuple[str, dict[str, Any]]

_TIME = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0}},
}
_BYTES = {"type": "string", "contentEncoding": "base64"}
_NUMBER, _STRING, _COUNT = {"type": "number"}, {"type": "string"}, {"type": "integer", "minimum": 0}


def _object(**properties: object) -> dict[str, Any]:
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


COLUMNS = ("seq", "t", "wall", "path", "event", "outcome", "code", "data", "meaning")


def export_run(reader: JournalReader, run: str, file: Path, to: str) -> int:
    """Write the events of a run to a file; return how many there were.

    Args:
        reader: of the journal.
        run: its id.
        file: written anew.
        to: `jsonl`, `csv` or `mcap`.

    Raises:
        UnknownNameError: there is no such run or format.
        MissingPartError: `mcap` isn't installed.
        DocumentError: the file can't be written.
    """
    if to not in FORMATS:
        raise UnknownNameError("format", to, FORMATS)
    reader.run(run)
    try:
        return FORMATS[to](reader, run, file)
    except OSError as error:
        raise DocumentError(f"can't be written: {error.strerror}", str(file)) from None


def _jsonl(reader: JournalReader, run: str, file: Path) -> int:
    count = 0
    with file.open("w", encoding="utf-8", errors="backslashreplace") as lines:
        for event in reader.iterate(run):
            lines.write(json.dumps(asdict(event), ensure_ascii=False) + "\n")
            count += 1
    return count


def _csv(reader: JournalReader, run: str, file: Path) -> int:
    count = 0
    with file.open("w", encoding="utf-8", newline="", errors="backslashreplace") as table:
        writer = csv.writer(table)
        writer.writerow(COLUMNS)
        for event in reader.iterate(run):
            row = asdict(event)
            row["data"] = json.dumps(event.data, ensure_ascii=False) if event.data else ""
            writer.writerow([row[column] for column in COLUMNS])
            count += 1
    return count


_ANY = {"type": "object", "properties": {"preview": {"type": "string"}, "value": {}}}
_EVENT = {
    "type": "object",
    "properties": {
        "seq": {"type": "integer"},
        "t": {"type": "number"},
        "wall": {"type": "number"},
        "path": {"type": "string"},
        "event": {"type": "string"},
        "outcome": {"type": ["string", "null"]},
        "code": {"type": ["string", "null"]},
        "data": {"type": "object"},
        "meaning": {"type": ["string", "null"]},
    },
}
_SCHEMAS = {**SCHEMAS, "grip.Event": _EVENT, "grip.Value": _ANY}
_INFO, _WARNING, _ERROR = 2, 3, 4
"""Levels of foxglove.Log."""


def _write_mcap(reader: JournalReader, run: str, file: Path) -> int:
    """Write a run to an MCAP file; return how many events it has.

    Topics: `/grip/events` (everything), `/grip/log` (for people), `/grip/data/VARIABLE` (what was written). Times are
    wall times, so that a recording of ROS topics made meanwhile lies beside it.

    Raises:
        MissingPartError: the mcap library isn't installed.
    """
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise MissingPartError("the mcap library", "pip install 'grip-bt[recording]'") from error
    count = 0
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="", library="grip")
        channels = _Channels(writer)
        record = asdict(reader.run(run))
        writer.add_metadata("run", {key: "" if value is None else str(value) for key, value in record.items()})
        for event in reader.iterate(run):
            _add(channels, reader, event)
            count += 1
        writer.finish()
    return count


class _Channels:
    """Makes a channel when its first message comes."""

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
                text = json.dumps({"title": schema, **_SCHEMAS[schema]}).encode()
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
        for suffix, (schema, message) in _drawn(reader, event, nanoseconds).items():
            channels.send(topic + suffix, schema, nanoseconds, message)


def _drawn(reader: JournalReader, event: Event, nanoseconds: int) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return the messages of a write; where Foxglove has no schema for the value, or it wasn't kept, its preview."""
    try:
        found = messages(reader.value(event), nanoseconds)
    except GripError:
        found = {}
    kept: dict[str, Any] = {key: event.data[key] for key in ("preview", "value") if key in event.data}
    return found or {"": ("grip.Value", kept)}


def _line(event: Event) -> tuple[str, int]:
    code = f" ({event.code})" if event.code else ""
    said = {
        key: value for key, value in event.data.items() if key in ("text", "message", "variable", "preview", "status")
    }
    text = " ".join([event.event, *([event.outcome + code] if event.outcome else []), *map(str, said.values())])
    level = (
        _ERROR
        if event.event in ("error", "damaged")
        else _WARNING
        if event.meaning == "failure" or event.event == "interrupted"
        else _INFO
    )
    return text, level


FORMATS: dict[str, Callable[[JournalReader, str, Path], int]] = {"jsonl": _jsonl, "csv": _csv, "mcap": _write_mcap}
