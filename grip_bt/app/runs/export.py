"""A run of the journal as a file for other tools: lines of JSON, a table, or a recording that Foxglove opens."""

from __future__ import annotations

import base64
import csv
import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.base.values import DepthImage, Grasp, Image, PointCloud, Pose, RgbdFrame
from grip_bt.runtime import Event, JournalReader, RunRecord

from .export_rerun import write_rerun

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


def _stamped(**properties: object) -> dict[str, Any]:
    return _object(timestamp=_TIME, frame_id=_STRING, **properties)


def _list_of(items: object) -> dict[str, Any]:
    return {"type": "array", "items": items}


_XYZ = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_POSE = _object(position=_XYZ, orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER))
_FIELDS = _list_of(_object(name=_STRING, offset=_COUNT, type=_COUNT))
_UINT8, _FLOAT32 = 1, 7
"""Of foxglove.PackedElementField."""
SCHEMAS: dict[str, dict[str, Any]] = {
    "foxglove.Log": _object(timestamp=_TIME, level=_COUNT, message=_STRING, name=_STRING, file=_STRING, line=_COUNT),
    "foxglove.PoseInFrame": _stamped(pose=_POSE),
    "foxglove.PosesInFrame": _stamped(poses=_list_of(_POSE)),
    "foxglove.PointCloud": _stamped(pose=_POSE, point_stride=_COUNT, fields=_FIELDS, data=_BYTES),
    "foxglove.RawImage": _stamped(width=_COUNT, height=_COUNT, encoding=_STRING, step=_COUNT, data=_BYTES),
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


def _pose_fields(pose: Pose) -> dict[str, Any]:
    position = dict(zip("xyz", map(float, pose.position), strict=True))
    return {"position": position, "orientation": dict(zip("wxyz", map(float, pose.quaternion), strict=True))}


def _cloud(cloud: PointCloud) -> dict[str, Any]:
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


COLUMNS = ("seq", "t", "wall", "path", "event", "outcome", "code", "data", "meaning")


def export_run(reader: JournalReader, run: str, file: Path, to: str) -> int:
    """Write the events of a run to a file as `jsonl`, `csv`, `mcap` or `rerun`; return how many there were.

    Raises:
        UnknownNameError: there is no such run or format.
        MissingPartError: the library for the format isn't installed.
        DocumentError: the file can't be written.
    """
    if to not in FORMATS:
        raise UnknownNameError("format", to, FORMATS)
    record, count = reader.run(run), 0
    try:
        with FORMATS[to](reader, record, file) as write:
            for event in reader.iterate(run):
                write(event)
                count += 1
    except OSError as error:
        raise DocumentError(f"can't be written: {error.strerror}", str(file)) from None
    return count


_Write = Callable[[Event], object]


@contextmanager
def _jsonl(reader: JournalReader, record: RunRecord, file: Path) -> Iterator[_Write]:
    with file.open("w", encoding="utf-8", errors="backslashreplace") as lines:
        yield lambda event: lines.write(json.dumps(asdict(event), ensure_ascii=False) + "\n")


@contextmanager
def _csv(reader: JournalReader, record: RunRecord, file: Path) -> Iterator[_Write]:
    with file.open("w", encoding="utf-8", newline="", errors="backslashreplace") as table:
        writer = csv.DictWriter(table, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        yield lambda event: writer.writerow(
            {**asdict(event), "data": json.dumps(event.data, ensure_ascii=False) if event.data else ""}
        )


_TYPES: dict[str, dict[str, Any]] = {"seq": {"type": "integer"}, "t": _NUMBER, "wall": _NUMBER, "data": _object()}
_TYPES |= dict.fromkeys(("path", "event"), _STRING)
_TYPES |= dict.fromkeys(("outcome", "code", "meaning"), {"type": ["string", "null"]})
_EVENT = _object(**{column: _TYPES[column] for column in COLUMNS})
_SCHEMAS = {**SCHEMAS, "grip.Event": _EVENT, "grip.Value": _object(preview=_STRING, value={})}
_INFO, _WARNING, _ERROR = 2, 3, 4
"""Levels of foxglove.Log."""


@contextmanager
def _mcap(reader: JournalReader, record: RunRecord, file: Path) -> Iterator[_Write]:
    """Write a run to an MCAP file.

    Topics: `/grip/events` (everything), `/grip/log` (for people), `/grip/data/VARIABLE` (what was written). Times are
    wall times, so that a recording of ROS topics made meanwhile lies beside it.
    """
    from mcap.writer import Writer  # of the extra `recording`

    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="", library="grip")
        writer.add_metadata("run", {k: "" if value is None else str(value) for k, value in asdict(record).items()})
        yield partial(_add, _Channels(writer), reader)
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
        try:
            found = messages(reader.value(event), nanoseconds)
        except GripError:
            found = {}
        kept: dict[str, Any] = {key: event.data[key] for key in ("preview", "value") if key in event.data}
        for suffix, (schema, message) in (found or {"": ("grip.Value", kept)}).items():
            channels.send(topic + suffix, schema, nanoseconds, message)


def _line(event: Event) -> tuple[str, int]:
    code = f" ({event.code})" if event.code else ""
    said = [str(event.data[key]) for key in event.data if key in ("text", "message", "variable", "preview", "status")]
    text = " ".join([event.event, *([event.outcome + code] if event.outcome else []), *said])
    poor = event.meaning == "failure" or event.event == "interrupted"
    level = _ERROR if event.event == "error" else _WARNING if poor else _INFO
    return text, level


FORMATS: dict[str, Callable[[JournalReader, RunRecord, Path], AbstractContextManager[_Write]]] = {
    "jsonl": _jsonl,
    "csv": _csv,
    "mcap": _mcap,
    "rerun": write_rerun,
}
