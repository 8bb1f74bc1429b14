"""Reading runs, also while they are written: for replay, live views, tables, exports."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter, ValidationError

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.files import Closing
from grip_bt.base.value_codec import OpaqueValueError, decode

from .journal_events import Event, Name, unpacked
from .journal_rows import JournalError, Rows, is_there

_ALL = 2**62
_COLUMNS = "id, task_name, task_path, task_text, target, seed, started, ended, status, outcome"


_Time = Annotated[float, Field(ge=0, le=1e11)]


@dataclass(frozen=True)
class RunRecord:
    """One run.

    Attributes:
        id: its id; ids sort by the time of their start.
        started: wall time [s since 1970].
        ended: wall time, None while it runs or when its process died.
        status: running, success, failure, error, stopped; died: its process isn't there any more; lost: it has no end,
            and nothing is known here about its process, which was of another machine.
    """

    id: str
    task_name: str
    task_path: str
    task_text: str
    target: str
    seed: int | None
    started: _Time
    ended: _Time | None
    status: str
    outcome: str | None


_RECORD, _NAMES = TypeAdapter(RunRecord), TypeAdapter(dict[int, Name])


class JournalReader(Closing):
    """Reads a journal; may be used from several threads.

    Raises:
        JournalError: there is no such file, or it isn't a journal.
    """

    def __init__(self, file: Path | str):
        self.file = Path(file)
        self._rows = Rows(self.file)
        self._names: dict[str, dict[int, Name]] = {}
        self._meanings: dict[str, dict[str, Any]] = {}

    def runs(self) -> list[RunRecord]:
        found = map(self._record, self._rows.query(f"SELECT {_COLUMNS} FROM runs"))
        return sorted(found, key=lambda record: (record.started, record.id), reverse=True)

    def run(self, id: str) -> RunRecord:
        """Return a run; UnknownNameError where there is none of this id."""
        for row in self._rows.query(f"SELECT {_COLUMNS} FROM runs WHERE id=?", id):
            return self._record(row)
        raise UnknownNameError("run", id, [r.id for r in self.runs()[:20]], str(self.file))

    def lives(self, run: str) -> bool:
        """Tell whether the process that executes a run, or has done so last, is there, as far as this machine knows."""
        return bool(self._process(run))

    def count(self, run: str) -> int:
        return int(self._rows.query("SELECT max(last) FROM blocks WHERE run=?", run)[0][0] or 0)

    def events(self, run: str, after_seq: int = 0, limit: int | None = None) -> list[Event]:
        """Return the events of a run that come after `after_seq`, in order.

        Args:
            limit: how many at most; None for all, which for a long run is a lot of memory: see `iterate`.

        Raises:
            JournalError: some of them are damaged.
        """
        return list(chain.from_iterable(self._blocks(run, after_seq, _ALL if limit is None else limit)))

    def iterate(self, run: str, after_seq: int = 0) -> Iterator[Event]:
        """Yield the events of a run in order, those written meanwhile too, up to one that is damaged: JournalError."""
        return chain.from_iterable(self._blocks(run, after_seq, _ALL))

    def value(self, event: Event) -> Any:
        """Return the value that a `write` event tells of, as it was.

        Raises:
            JournalError: it wasn't kept, or is damaged, or the event isn't a write.
            OpaqueValueError: it is of a class that can't be restored.
        """
        if "value" in event.data:
            content = json.dumps(event.data["value"]).encode() + b"\n"
        elif "hash" in event.data:
            content = self.content(event.data["hash"])
        else:
            why = event.data.get("dropped", "it was not kept")
            raise JournalError(f"{self.file}: event {event.seq} ({event.event} at {event.path}) has no value: {why}")
        try:
            return decode(content)
        except OpaqueValueError:
            raise
        except Exception as error:
            where = f"event {event.seq} ({event.event} at {event.path})"
            raise JournalError(f"{self.file}: the value of {where} is damaged: {error}") from error

    def content(self, hash: str) -> bytes:
        """Return the bytes of a big value; see `docs/journal.md`.

        Raises:
            UnknownNameError: there is none of this hash.
            JournalError: it is damaged.
        """
        rows = self._rows.query("SELECT size, content FROM big_values WHERE hash=?", hash)
        if not rows:
            raise UnknownNameError("value", str(hash), [], str(self.file))
        try:
            content = zlib.decompressobj().decompress(rows[0][1], int(rows[0][0]) + 1)
        except (zlib.error, TypeError, ValueError, OverflowError, MemoryError):
            content = b""
        if hashlib.blake2b(content, digest_size=16).hexdigest() != hash:
            raise JournalError(f"{self.file}: the value {hash} is damaged: its bytes aren't those that were written")
        return content

    def variables(self, run: str) -> dict[str, Event]:
        """Return the last write of each variable."""
        return {str(event.data.get("variable")): event for event in self._writes(run)}

    def history(self, run: str, variable: str, limit: int = 20) -> list[Event]:
        """Return the last writes of one variable, the newest last."""
        return [event for event in self._writes(run) if event.data.get("variable") == variable][-limit:]

    def close(self) -> None:
        self._rows.close()

    def _process(self, run: str) -> bool | None:
        """Tell whether the process that executes a run is there; None where that isn't known."""
        rows = self._rows.query("SELECT pid, since, host FROM processes WHERE run=?", run)
        return is_there(dict(zip(("pid", "since", "host"), rows[0], strict=True)) if rows else {})

    def _record(self, row: tuple[Any, ...]) -> RunRecord:
        try:
            record = _RECORD.validate_python(dict(zip(_COLUMNS.split(", "), row, strict=True)))
        except ValidationError as error:
            raise JournalError(f"{self.file}: run {row[0]!r:.80} is damaged: {error.errors()[0]['loc'][0]}") from error
        if record.status != "running":
            return record
        return replace(record, status={True: "running", False: "died", None: "lost"}[self._process(record.id)])

    def _writes(self, run: str) -> Iterator[Event]:
        sql = "SELECT first, last FROM blocks WHERE run=? AND instr(data, '\"variable\"') ORDER BY first"
        for first, last in self._rows.query(sql, run):
            yield from (event for event in self.events(run, first - 1, last - first + 1) if event.event == "write")

    def _blocks(self, run: str, after: int, left: int) -> Iterator[list[Event]]:
        """Yield the events of a run after one, up to a number, block by block; also of those written meanwhile."""
        after = max(after, 0)
        sql = "SELECT first, last, content, data, sum FROM blocks WHERE run=? AND last>? ORDER BY first LIMIT 64"
        while left > 0 and (rows := self._rows.query(sql, run, after)):
            for row in rows if left > 0 else ():
                events = self._unpacked(run, row, after, left)
                after, left = row[1], left - len(events)
                yield events

    def _unpacked(self, run: str, row: tuple[Any, ...], after: int, most: int) -> list[Event]:
        first, last = row[:2]
        part = slice(max(0, after + 1 - first), max(0, after + 1 - first) + most)
        try:
            try:
                found = unpacked(row, self._names.get(run, {}), part)
            except LookupError:  # there are more by now
                rows = self._rows.query("SELECT id, path, event, outcome, code FROM names WHERE run=?", run)
                self._names[run] = _NAMES.validate_python({number: tuple(name) for number, *name in rows})
                found = unpacked(row, self._names[run], part)
        except (ValueError, LookupError) as error:
            raise JournalError(f"{self.file}: events {first} to {last} of run {run} can't be read: {error}") from error
        return [
            Event(first + i, t, wall, *name, data, self._meaning(run, *name) if name[2] is not None else None)
            for i, t, wall, name, data in found
        ]

    def _meaning(self, run: str, path: str, event: str, outcome: str | None, code: str | None) -> Any:
        """Return what an end means; labels that say so themselves, and codes of failures, need no table."""
        if event != "exit":
            return None
        if run not in self._meanings:
            self._meanings[run] = {}  # while it is being looked for
            first = self.events(run, 0, 1)
            self._meanings[run] = first[0].data.get("outcomes", {}) if first else {}
        said = self._meanings[run].get(path, {})
        meaning = said.get(outcome) if isinstance(said, dict) else None
        if meaning in ("success", "failure"):
            return meaning
        return "failure" if code is not None else outcome if outcome in ("success", "failure") else None
