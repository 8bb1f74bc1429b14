"""From the logs of runs to rows: what the journal's thread does with a database."""

from __future__ import annotations

import hashlib
import json
import reprlib
import sqlite3
import time
import zlib
from itertools import repeat
from typing import Any

import numpy as np

from grip_bt.runtime.journal_events import pack_numbers, pack_times

from .journal_events import MOST, checksum
from .run_log import ENTER, ENTRIES, INTERRUPTED, DetailedEvent, RunLog
from .value_codec import encode

_INLINE = 512
"""Values of at most so many bytes stand in the event itself."""

_SAME = 1e-3
"""Where the run's clock and the wall's differ by a constant, to so much [s], wall times of events aren't written."""
_Key = tuple[str, str, str | None, str | None]
_repr = reprlib.Repr()
_repr.maxstring, _repr.maxother, _repr.maxlist, _repr.maxtuple = 60, 100, 3, 4


def preview(value: object) -> str:
    """Return a value in at most 120 characters, for people; big values are cut before they are formatted."""
    text = _repr.repr(value)
    return text if len(text) <= 120 else text[:117] + "..."


class RunWriter:
    """Writes the blocks of one run; goes on where another process has stopped.

    Args:
        database: in a transaction whenever `write` is called.
        log: what to write.
        largest: values of more bytes aren't kept.
    """

    def __init__(self, database: sqlite3.Connection, log: RunLog, largest: int):
        self._database, self._log, self._largest = database, log, largest
        self._ids: dict[tuple[str, Any], int] = {}
        self._keys: dict[_Key, int] = {}
        self.last = 0
        rows = database.execute("SELECT id, path, event, outcome, code FROM names WHERE run=?", (log.id,))
        for number, *key in rows.fetchall():
            self._keys[tuple(key)] = number
        (last,) = database.execute("SELECT max(last) FROM blocks WHERE run=?", (log.id,)).fetchone()
        self.last = last or 0

    def write(self) -> int:
        """Take what has gathered and write it; return how many events that were."""
        log = self._log
        buffer = log.buffer
        total = len(buffer) // ENTRIES
        for _ in range(0, total, MOST):
            taken = buffer[: ENTRIES * MOST]
            del buffer[: len(taken)]
            if log.last is not None and log.last in taken:
                taken = taken[: ENTRIES * (taken[1::ENTRIES].index(log.last) + 1)]
                log.over = True
            elif log.over:
                continue
            self._write_block(taken)
        return total

    def _write_block(self, taken: list[Any]) -> None:
        paths, whats = taken[0::ENTRIES], taken[1::ENTRIES]
        moments, t = np.array(taken[2::ENTRIES], float), np.array(taken[3::ENTRIES], float)
        count = len(paths)
        names = np.fromiter(map(self._ids.get, zip(paths, whats, strict=True), repeat(-1)), np.int64, count)
        data: dict[int, Any] = {}
        writes = 0
        for i in np.flatnonzero(names < 0).tolist():
            names[i] = self._name(paths[i], whats[i])
            if isinstance(whats[i], DetailedEvent) and (more := self._data(whats[i])):
                data[i] = more
                writes += whats[i].event == "write"
        since_epoch = time.time() - time.monotonic()
        apart = moments - t + since_epoch
        together = bool(np.ptp(apart) < _SAME)  # the run's clock went as the wall's
        wall, offset = (None, float(apart[0])) if together else (pack_times(moments + since_epoch), None)
        text = json.dumps(data, default=str) if data else None
        row = (self.last + 1, self.last + count, pack_numbers(names), pack_times(t), wall, offset, text)
        values = (self._log.id, *row, writes, checksum(row))
        self._database.execute("INSERT INTO blocks VALUES(?,?,?,?,?,?,?,?,?,?)", values)
        self.last += count

    def _name(self, path: str, what: Any) -> int:
        """Return the number of a kind of event at a node; the first time it is entered in the table of names."""
        if isinstance(what, DetailedEvent):
            key: _Key = (path, what.event, what.outcome, what.code)
        elif what == ENTER and type(what) is int:
            key = (path, "enter", None, None)
        elif what == INTERRUPTED and type(what) is int:
            key = (path, "interrupted", None, None)
        else:
            key = (path, "exit", what, None)
        number = self._keys.get(key)
        if number is None:
            number = self._keys[key] = len(self._keys)
            self._database.execute("INSERT INTO names VALUES(?,?,?,?,?,?)", (self._log.id, number, *key))
        if not isinstance(what, DetailedEvent):
            self._ids[path, what] = number
        return number

    def _data(self, noted: DetailedEvent) -> dict[str, Any] | None:
        if noted.written is None:
            return noted.data
        (value,) = noted.written
        content = encode(value)
        more: dict[str, Any] = {**(noted.data or {}), "preview": preview(value)}
        if len(content) <= _INLINE and content.index(b"\n") == len(content) - 1:
            return {**more, "value": json.loads(content)}
        return {**more, **self._keep(content, noted)}

    def _keep(self, content: bytes, noted: DetailedEvent) -> dict[str, Any]:
        if len(content) > self._largest:
            return {"size": len(content), "dropped": f"larger than {self._largest} bytes"}
        digest = hashlib.blake2b(content, digest_size=16).hexdigest()
        known = self._database.execute("SELECT 1 FROM big_values WHERE hash=?", (digest,)).fetchone()
        if known is None:
            type_name = (noted.data or {}).get("type")
            row = (digest, type_name, len(content), zlib.compress(content, 1))
            self._database.execute("INSERT INTO big_values VALUES(?,?,?,?)", row)
        return {"hash": digest, "size": len(content)}
