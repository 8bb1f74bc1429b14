"""Reading runs, also while they are written, and of files that are damaged: for replay, live views, tables, exports."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.files import Closing

from .journal_events import DAMAGED, MOST, Event, Name, is_name, is_time, unpacked
from .journal_rows import JournalError, Rows, is_there
from .value_codec import OpaqueValueError, decode

PAGE = 10_000
"""Events that `iterate` holds at a time."""
_GOOD = f"typeof(first)='integer' AND typeof(last)='integer' AND last BETWEEN first AND first+{MOST - 1} AND first>0"
"""Blocks whose place among the events is known."""
_BLOCKS = "SELECT first, last, content, data, sum FROM blocks"
_COLUMNS = "id, task_name, task_path, task_text, target, seed, started, ended, status, outcome"


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
    started: float
    ended: float | None
    status: str
    outcome: str | None


class JournalReader(Closing):
    """Reads a journal; may be used from several threads.

    What is damaged in it is left out: an event `damaged` stands in its place and says what that was, and so does
    `damage`.

    Raises:
        JournalError: there is no such file, or it isn't a journal.
    """

    def __init__(self, file: Path | str):
        self.file = Path(file)
        self._rows = Rows(self.file)
        self._names: dict[str, dict[int, Name]] = {}
        self._meanings: dict[str, dict[str, Any]] = {}

    @property
    def damage(self) -> list[str]:
        return list(self._rows.damage)

    def raise_if_damaged(self) -> None:
        """Say what of the things that were read until now was left out.

        Raises:
            JournalError: something was.
        """
        if self._rows.damage:
            raise JournalError(f"{self.file}: is damaged, and not all of it could be read: {'; '.join(self.damage)}")

    def runs(self) -> list[RunRecord]:
        found = filter(None, map(self._record, self._rows.query(f"SELECT {_COLUMNS} FROM runs")))
        return sorted(found, key=lambda record: (record.started, record.id), reverse=True)

    def run(self, id: str) -> RunRecord:
        """Return a run; UnknownNameError where there is none of this id."""
        for record in filter(None, map(self._record, self._rows.query(f"SELECT {_COLUMNS} FROM runs WHERE id=?", id))):
            return record
        raise UnknownNameError("run", id, [r.id for r in self.runs()[:20]], str(self.file))

    def lives(self, run: str) -> bool:
        """Tell whether the process that executes a run, or has done so last, is there, as far as this machine knows."""
        return bool(self._process(run))

    def count(self, run: str) -> int:
        sql = f"SELECT last FROM blocks WHERE run=? AND {_GOOD} ORDER BY first DESC LIMIT 1"
        return max((row[0] or 0 for row in self._rows.query(sql, run)), default=0)

    def events(self, run: str, after_seq: int = 0, limit: int | None = None) -> list[Event]:
        """Return the events of a run that come after `after_seq`, in order.

        Args:
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

    def _record(self, row: tuple[Any, ...]) -> RunRecord | None:
        id, name, path, text, target, seed, started, ended, status, outcome = row
        if not isinstance(id, str) or not id:
            self._rows.note(f"a run of {self.file} has no id ({id!r:.80}), and is left out")
            return None
        fits = {  # whether it can be that, and what stands for it otherwise
            "task_name": (isinstance(name, str), ""),
            "task_path": (isinstance(path, str) and "\0" not in path, ""),
            "task_text": (isinstance(text, str), ""),
            "target": (target in ("bt", "sm"), "bt"),
            "seed": (isinstance(seed, int | None), None),
            "started": (is_time(started) and started >= 0, 0.0),
            "ended": (ended is None or (is_time(ended) and ended >= 0), None),
            "status": (isinstance(status, str), "lost"),
            "outcome": (isinstance(outcome, str | None), None),
        }
        known: dict[str, Any] = dict(zip(fits, row[1:], strict=True))
        for field, (good, instead) in fits.items():
            if not good:
                self._rows.note(f"{field} of run {id} is no such thing")
                known[field] = instead
        if known["status"] == "running":
            known["status"] = {True: "running", False: "died", None: "lost"}[self._process(id)]
        return RunRecord(id, **known)

    def _writes(self, run: str) -> Iterator[Event]:
        done = 0
        sql = f"SELECT first, last FROM blocks WHERE run=? AND instr(data, '\"variable\"') AND {_GOOD} ORDER BY first"
        pages = (self.events(run, first - 1, last - first + 1) for first, last in self._rows.query(sql, run))
        for event in chain.from_iterable(pages):
            if event.event == "write" and done < event.seq:  # pages overlap where blocks are damaged
                done = event.seq
                yield event

    def _blocks(self, run: str, after: int, limit: int | None) -> Iterator[list[Event]]:
        left, after = 2**62 if limit is None else limit, max(after, 0)
        t = 0.0
        for row in self._stored(run, after) if left > 0 else ():
            first, last = row[:2]
            if last <= after:
                continue  # of a damaged file: the events of another block
            events: list[Event] = []
            if first > after + 1:
                events.append(self._hole(run, after + 1, first - 1, t, "they aren't there"))
            try:
                events += self._unpacked(run, row, after, left)
            except ValueError as error:
                last = self._end_of(run, row)
                if last <= after:
                    self._rows.note(
                        f"a block of run {run} can't be read that claims events {first} to {row[1]}: {error}"
                    )
                    continue
                events.append(self._hole(run, max(first, after + 1), last, t, str(error)))
            after, t = last, events[-1].t if events else t
            left -= len(events)
            yield events
            if left <= 0:
                return

    def _stored(self, run: str, after: int) -> Iterator[tuple[Any, ...]]:
        since = 0
        while rows := self._page(run, after, since):
            yield from rows
            since = rows[-1][0]

    def _page(self, run: str, after: int, since: int) -> list[tuple[Any, ...]]:
        if after == since == 0 and self._rows.query(f"SELECT 1 FROM blocks WHERE run=? AND NOT ({_GOOD}) LIMIT 1", run):
            self._rows.note(f"blocks of run {run} whose place among its events isn't known are left out")
        condition = f"run=? AND first>? AND last>? AND {_GOOD} ORDER BY first LIMIT 64"
        return self._rows.query(f"{_BLOCKS} WHERE {condition}", run, since, after)

    def _end_of(self, run: str, row: tuple[Any, ...]) -> int:
        """Return where a block ends that is damaged: at the latest where the next one begins, whatever it says."""
        first, last = row[:2]
        sql = f"SELECT min(?, first - 1) FROM blocks WHERE run=? AND first>? AND {_GOOD} ORDER BY first LIMIT 1"
        return int(next((end for (end,) in self._rows.query(sql, last, run, first)), last))

    def _hole(self, run: str, first: int, last: int, t: float, why: str) -> Event:
        which = f"event {first}" if first == last else f"events {first} to {last}"
        message = f"{which} of run {run} can't be read: {why}"
        self._rows.note(message)
        return Event(last, t, 0.0, "/", DAMAGED, None, None, {"message": message})

    def _unpacked(self, run: str, row: tuple[Any, ...], after: int, most: int) -> list[Event]:
        first = row[0]
        since = max(0, after + 1 - first)
        names = self._names.get(run, {})
        try:
            found = unpacked(row, names, slice(since, since + most))
        except ValueError:
            names = self._names_of(run)  # there are more by now
            found = unpacked(row, names, slice(since, since + most))
        return [
            Event(first + i, t, wall, *name, data, self._meaning(run, *name) if name[2] is not None else None)
            for i, t, wall, name, data in found
        ]

    def _names_of(self, run: str) -> dict[int, Name]:
        """Return what the numbers of a run's events stand for; names are only ever added."""
        rows = self._rows.query("SELECT id, path, event, outcome, code FROM names WHERE run=?", run)
        self._names[run] = {number: tuple(name) for number, *name in rows if isinstance(number, int) and is_name(*name)}
        return self._names[run]

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
