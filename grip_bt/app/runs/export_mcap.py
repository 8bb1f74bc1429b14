"""A run of the journal as an MCAP file for Foxglove: events, values, and the robot and the scene as they moved."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.runtime import Event, JournalReader, RunRecord

from .foxglove import SCHEMAS, entity, messages, stamp, transform
from .motion_record import moments, motion_file

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
            moved = [transform(link, pose, at) for link, pose in moment.links.items()]
            channels.send("/tf", "foxglove.FrameTransforms", at, {"transforms": moved})
        if moment.scene is not None:
            before, there = there, dict(moment.scene)
            gone = [{"timestamp": stamp(at), "type": 0, "id": name} for name in before if name not in there]
            new = [entity(name, it, moment.bodies, at) for name, it in there.items() if it != before.get(name)]
            channels.send("/grip/scene", "foxglove.SceneUpdate", at, {"deletions": gone, "entities": new})
