"""A run of the journal as a file for other tools: lines of JSON, a table, or a recording that Foxglove opens."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError, GripError, MissingPartError, UnknownNameError
from grip_bt.runtime import Event, JournalReader

from .foxglove import SCHEMAS, messages, stamp

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
