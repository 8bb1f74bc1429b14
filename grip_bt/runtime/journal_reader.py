"""Reading runs, also while they are written: for replay, live views, tables, exports."""

from __future__ import annotations

import json
import sqlite3
import threading
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grip_bt.errors import UnknownNameError

from .blocks import unpack_numbers, unpack_times
from .journal import JournalError
from .journal_schema import has_table, refuse_newer
from .value_codec import decode

PAGE = 10_000
"""Events that `iterate` holds at a time."""

_Names = tuple[str, str, str | None, str | None]  # of an event: path, kind, outcome and code


@dataclass(frozen=True)
class RunRecord:
    """One run.

    Attributes:
        id: its id; ids sort by the time of their start.
        task_name: name of the task.
        task_path: the file that it came from.
        task_text: the document as it was run.
        target: `bt` or `sm`.
        seed: of the simulation, if any.
        started: wall time [s since 1970].
        ended: wall time, None while it runs or when its process died.
        status: running, success, failure, error or stopped.
        outcome: the task's outcome.
    """

    id: str
    task_name: str
    task_path: str
    task_text: str
    target: str
    seed: int | None
    started: float
    ended: float | None
    status: str
    outcome: str | None


@dataclass(frozen=True)
class Event:
    """One event of a run.

    Attributes:
        seq: 1, 2, 3 ... without a gap.
        t: the run's clock [s].
        wall: wall time [s since 1970].
        path: the node; `/` for the root and for the run itself.
        event: its kind.
        outcome: of an end.
        code: of a failure.
        data: anything else.
    """

    seq: int
    t: float
    wall: float
    path: str
    event: str
    outcome: str | None
    code: str | None
    data: dict[str, Any]


class JournalReader:
    """Reads a journal; may be used from several threads.

    Raises:
        JournalError: there is no such file, or it isn't a journal.
    """

    def __init__(self, file: Path | str):
        self.file = Path(file)
        if not self.file.is_file():
            raise JournalError(f"{self.file}: there is no journal; runs are written to it as soon as there is one")
        self._lock = threading.Lock()
        self._names: dict[str, list[_Names]] = {}
        try:
            self._database = sqlite3.connect(self.file, timeout=30, check_same_thread=False)
        except sqlite3.OperationalError as error:
            raise JournalError(f"{self.file}: can't be read: {error}; mend its rights, or name another file") from error
        try:
            self._database.execute("PRAGMA query_only=ON")
            refuse_newer(self._database)
            self._packed = has_table(self._database, "blocks")
            self._in_rows = has_table(self._database, "events")
            if not self._packed and not self._in_rows:
                raise sqlite3.DatabaseError("no such table: blocks")
        except sqlite3.DatabaseError as error:
            self._database.close()
            raise JournalError(f"{self.file}: isn't a journal: {error}") from error

    def runs(self) -> list[RunRecord]:
        """Return all runs, the newest first."""
        return [RunRecord(*row) for row in self._query("SELECT * FROM runs ORDER BY started DESC, id DESC")]

    def run(self, id: str) -> RunRecord:
        """Return a run.

        Raises:
            UnknownNameError: there is none of this id.
        """
        rows = self._query("SELECT * FROM runs WHERE id=?", id)
        if not rows:
            raise UnknownNameError("run", id, [r.id for r in self.runs()[:20]], str(self.file))
        return RunRecord(*rows[0])

    def count(self, run: str) -> int:
        """Return how many events of a run there are so far."""
        return max(self._last(table, run) for table in self._tables())

    def events(self, run: str, after_seq: int = 0, limit: int | None = None) -> list[Event]:
        """Return the events of a run that come after `after_seq`, in order.

        Args:
            run: its id.
            after_seq: the last event that isn't wanted.
            limit: how many at most; None for all, which for a long run is a lot of memory: see `iterate`.
        """
        found: list[Event] = []
        for block in self._blocks(run, after_seq, limit):
            found += block if limit is None else block[: limit - len(found)]
        return found

    def iterate(self, run: str, after_seq: int = 0) -> Iterator[Event]:
        """Yield the events of a run in order, those written meanwhile too; holds a few thousand at a time."""
        while page := self.events(run, after_seq, PAGE):
            yield from page
            after_seq = page[-1].seq

    def value(self, event: Event) -> Any:
        """Return the value that a `write` event tells of, as it was.

        Raises:
            JournalError: it wasn't kept, or the event isn't a write.
            OpaqueValueError: it is of a class that can't be restored.
        """
        if "value" in event.data:
            return decode(json.dumps(event.data["value"]).encode() + b"\n")
        if "hash" in event.data:
            return decode(self.content(event.data["hash"]))
        why = event.data.get("dropped", "the journal was written before values were kept")
        raise JournalError(f"{self.file}: event {event.seq} ({event.event} at {event.path}) has no value: {why}")

    def content(self, hash: str) -> bytes:
        """Return the bytes of a big value; see `docs/journal.md`.

        Raises:
            UnknownNameError: there is none of this hash.
        """
        rows = self._query("SELECT content FROM big_values WHERE hash=?", hash) if self._packed else []
        if not rows:
            raise UnknownNameError("value", hash, [], str(self.file))
        return zlib.decompress(rows[0][0])

    def variables(self, run: str, until_seq: int | None = None) -> dict[str, Event]:
        """Return the last write of each variable, up to and including the event `until_seq`."""
        return {str(event.data.get("variable")): event for event in self._writes(run, until_seq)}

    def history(self, run: str, variable: str, limit: int = 20) -> list[Event]:
        """Return the last writes of one variable, the newest last."""
        return [event for event in self._writes(run, None) if event.data.get("variable") == variable][-limit:]

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()

    def __enter__(self) -> JournalReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- rows ---

    def _tables(self) -> list[str]:
        return ["blocks"] * self._packed + ["events"] * self._in_rows

    def _last(self, table: str, run: str) -> int:
        column = "last" if table == "blocks" else "seq"
        return int(self._query(f"SELECT max({column}) FROM {table} WHERE run=?", run)[0][0] or 0)

    def _writes(self, run: str, until_seq: int | None) -> Iterator[Event]:
        """Yield the writes in order, of blocks that have any."""
        until = 2**62 if until_seq is None else until_seq
        firsts: list[Any] = [None]
        if self._packed and not self._old(run):
            sql = "SELECT first, last FROM blocks WHERE run=? AND writes>0 AND first<=? ORDER BY first"
            firsts = self._query(sql, run, until)
        for bounds in firsts:
            page = self.iterate(run) if bounds is None else self.events(run, bounds[0] - 1, bounds[1] - bounds[0] + 1)
            yield from (event for event in page if event.event == "write" and event.seq <= until)

    def _old(self, run: str) -> bool:
        """Tell whether a run was written by an earlier version, a row per event."""
        return self._in_rows and bool(self._query("SELECT 1 FROM events WHERE run=? LIMIT 1", run))

    def _blocks(self, run: str, after: int, limit: int | None) -> Iterator[list[Event]]:
        if self._old(run):
            yield self._rows(run, after, limit)
            return
        left = 2**62 if limit is None else limit
        columns = "first, last, name, t, wall, wall_offset, data"
        sql = f"SELECT {columns} FROM blocks WHERE run=? AND last>? ORDER BY first LIMIT ?"
        while left > 0 and self._packed:
            rows = self._query(sql, run, after, 64)
            for row in rows:
                events = self._unpacked(run, row, after, left)
                left -= len(events)
                yield events
                if left <= 0:
                    return
            if not rows:
                return
            after = rows[-1][1]

    def _unpacked(self, run: str, row: tuple[Any, ...], after: int, most: int) -> list[Event]:
        first, last, packed, t, wall, offset, text = row
        since = max(0, after + 1 - first)
        part = slice(since, min(last - first + 1, since + most))
        numbers, times = unpack_numbers(packed)[part], unpack_times(t)[part]
        walls = times + offset if wall is None else unpack_times(wall)[part]
        data = {int(i): more for i, more in json.loads(text).items()} if text else {}
        names = self._names_of(run, int(numbers.max(initial=0)))
        rest = zip(numbers.tolist(), times.tolist(), walls.tolist(), strict=True)
        events = []
        for i, (number, at, wall_at) in enumerate(rest, since):
            path, event, outcome, code = names[number]
            events.append(Event(first + i, at, wall_at, path, event, outcome, code, data.get(i, {})))
        return events

    def _names_of(self, run: str, largest: int) -> list[_Names]:
        """Return what the numbers of a run's events stand for; names are only ever added."""
        names = self._names.get(run, [])
        if len(names) <= largest:
            names = self._query("SELECT path, event, outcome, code FROM names WHERE run=? ORDER BY id", run)
            self._names[run] = names
        return names

    def _rows(self, run: str, after: int, limit: int | None) -> list[Event]:
        columns = "seq, t, wall, path, event, outcome, code, data"
        sql = f"SELECT {columns} FROM events WHERE run=? AND seq>? ORDER BY seq LIMIT ?"
        rows = self._query(sql, run, after, -1 if limit is None else limit)
        return [
            Event(seq, t, wall, path, event, outcome, code, json.loads(data) if data else {})
            for seq, t, wall, path, event, outcome, code, data in rows
        ]

    def _query(self, statement: str, *values: Any) -> list[tuple[Any, ...]]:
        with self._lock:
            return self._database.execute(statement, values).fetchall()
