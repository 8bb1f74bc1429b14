"""The event log of runs: append-only, in SQLite with a write-ahead log, readable while it is written.

The thread that ticks only extends a list; a writer thread packs what has gathered into a block and commits it. What
was committed survives the death of the process and of the machine. Whoever shows events waits for `on_commit` first, so
that nothing is seen that could be lost. The tables are described in `docs/journal.md`.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import secrets
import sqlite3
import threading
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np

from grip_bt.base.files import Closing
from grip_bt.base.value_codec import encode, preview

from .journal_events import MOST, checksum, packed
from .journal_rows import JournalError, prepare_to_write, process_facts

_log = logging.getLogger(__name__)

_GATHER = 0.01
"""How long [s] events gather before they are committed together; nobody waits for it who calls `flush`."""
IDLE = 0.04
"""How long [s] at most between two looks at runs in which nothing happens."""
LARGEST = 16 * 2**20
"""Values of more bytes aren't kept unless the journal is told to."""
_Job = tuple[str, tuple[Any, ...]]
ENTER, INTERRUPTED = 0, 1
"""What a transition is that isn't an end; an end is its outcome."""

_DIED = "died"
"""Status of a run that was cut off: nobody has stopped it, and it can be resumed."""

ENTRIES = 4
"""Entries of `RunLog.buffer` for an event."""
LIMIT = 2_000_000
"""Events that may wait for the writer; beyond that, whoever appends waits for it."""
_INLINE = 512
"""Values of at most this many bytes stand in the event itself."""
_Key = tuple[str, str, str | None, str | None]


@dataclass(slots=True, eq=False)
class DetailedEvent:
    """An event that says more than that a node began or ended.

    Attributes:
        written: a variable's value, to be encoded by the writer; whoever appends it promises not to change it.
    """

    event: str
    outcome: str | None = None
    code: str | None = None
    data: dict[str, Any] | None = None
    written: tuple[object] | None = None


class RunLog:
    """The log of one run.

    Attributes:
        buffer: four entries an event: path, what (`ENTER`, `INTERRUPTED`, an outcome, or a `DetailedEvent`), the moment
            [s, monotonic] and the time on the run's clock [s]. It is extended by whole events, at once, and only the
            writer takes from its front.
        last: the event after which nothing is written any more; None as long as the run isn't cut off.
        over: whether the writer has written that one; kept here, since a log that has ended may be followed again.
    """

    def __init__(self, journal: Journal, run: str):
        self.journal, self.id = journal, run
        self.buffer: list[Any] = []
        self.ended = False
        self.last: DetailedEvent | None = None
        self.over = False
        self._cutting = threading.RLock()
        journal.follow(self)

    def append(
        self,
        t: float,
        path: str,
        event: str,
        outcome: str | None = None,
        code: str | None = None,
        data: dict[str, Any] | None = None,
    ) -> None:
        """Add an event, see `DetailedEvent`, at the time `t` on the run's clock [s]; returns before it is committed."""
        self.note(t, path, DetailedEvent(event, outcome, code, data))

    def note(self, t: float, path: str, what: DetailedEvent) -> None:
        self.buffer.extend((path, what, time.monotonic(), t))
        if self.ended:
            self.journal.follow(self)
        if len(self.buffer) > ENTRIES * LIMIT:
            self.wait_for_room()

    def wait_for_room(self) -> None:
        """Return when the writer has caught up; memory is bounded by that."""
        while len(self.buffer) > ENTRIES * LIMIT // 2 and self.journal.writing:
            time.sleep(0.001)

    def end(self, status: str, outcome: str | None) -> None:
        """Enter how the run has ended; nothing where it was cut off."""
        if self.last is not None and status != _DIED:
            return
        statement = "UPDATE runs SET ended=?, status=?, outcome=? WHERE id=?"
        self.journal.execute(statement, (time.time(), status, outcome, self.id))
        self.ended = True

    def cut(self, t: float, why: str) -> None:
        """End the journal of the run here, as if its process had died: it can be resumed from here.

        What happens after this, such as that everything is interrupted, isn't written: whoever has the run stopped
        because of it, from whichever thread, does so when this has returned.
        """
        with self._cutting:
            if self.ended or self.last is not None:
                return
            self.last = DetailedEvent("run_ended", data={"status": _DIED, "message": why})
            self.note(t, "/", self.last)
            self.end(_DIED, None)


class _RunWriter:
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
        for i in np.flatnonzero(names < 0).tolist():
            names[i] = self._name(paths[i], whats[i])
            if isinstance(whats[i], DetailedEvent) and (more := self._data(whats[i])):
                data[i] = more
        text = json.dumps(data, default=str) if data else None
        content = packed(names, t, moments + (time.time() - time.monotonic()))
        row = (self.last + 1, self.last + count, content, text)
        self._database.execute("INSERT INTO blocks VALUES(?,?,?,?,?,?)", (self._log.id, *row, checksum(*row)))
        self.last += count

    def _name(self, path: str, what: Any) -> int:
        """Return the number of a kind of event at a node; the first time it is entered in the table of names."""
        if isinstance(what, DetailedEvent):
            key: _Key = (path, what.event, what.outcome, what.code)
        elif type(what) is int:
            key = (path, "enter" if what == ENTER else "interrupted", None, None)
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
        self._database.execute("INSERT OR IGNORE INTO uses VALUES(?,?)", (self._log.id, digest))
        return {"hash": digest, "size": len(content)}


class Journal(Closing):
    """Writes runs to a file; one process at a time writes a run, several may write the file.

    Attributes:
        writing: whether the writer is there and well.

    Args:
        file: created with its folder when it isn't there.
        largest_value: what nodes write is kept up to so many bytes each, and beyond that only previewed.
    """

    def __init__(self, file: Path | str, *, largest_value: int = LARGEST):
        self.file, self._largest = Path(file), largest_value
        self.file.parent.mkdir(parents=True, exist_ok=True)
        # Its put() is re-entrant, so that a signal handler may stop a run, which is an event too.
        self._jobs: SimpleQueue[_Job | threading.Event] = SimpleQueue()
        self._logs: dict[str, RunLog] = {}
        self._lock = threading.RLock()
        self._closing, self.writing = False, True
        self._error: BaseException | None = None
        self._listeners: list[Callable[[str, int], None]] = []
        try:
            database = sqlite3.connect(self.file, timeout=30, isolation_level=None, check_same_thread=False)
            prepare_to_write(database)
        except (sqlite3.Error, UnicodeError) as error:
            raise JournalError(f"{self.file}: can't be opened as a journal: {error}") from error
        self._thread = threading.Thread(target=self._write, args=(database,), name="grip_journal", daemon=True)
        self._thread.start()

    def begin(
        self, task_name: str, task_path: str = "", task_text: str = "", target: str = "bt", seed: int | None = None
    ) -> RunLog:
        """Enter a new run and return its log; see `RunRecord`."""
        run = time.strftime("%Y%m%d-%H%M%S-") + secrets.token_hex(3)
        path = os.fsencode(task_path).decode(errors="backslashreplace")  # a name of bytes that are no text
        row = (run, task_name, path, task_text, target, seed, time.time(), None, "running", None)
        self._executed_here(run)  # first: no run is seen without its process
        self.execute("INSERT INTO runs VALUES(?,?,?,?,?,?,?,?,?,?)", row)
        return RunLog(self, run)

    def go_on(self, run: str) -> RunLog:
        """Return the log of a run whose process has died, to go on with it."""
        self._executed_here(run)
        self.execute("UPDATE runs SET ended=NULL, status='running', outcome=NULL WHERE id=?", (run,))
        return RunLog(self, run)

    def _executed_here(self, run: str) -> None:
        who = process_facts()
        self.execute("INSERT OR REPLACE INTO processes VALUES(?,?,?,?)", (run, who["pid"], who["since"], who["host"]))

    def follow(self, log: RunLog) -> None:
        """Have the writer empty this log; called by it."""
        with self._lock:
            self._logs = {**self._logs, log.id: log}

    def execute(self, statement: str, values: tuple[object, ...]) -> None:
        """Have a statement executed with the events appended so far, in one transaction."""
        self._jobs.put((statement, values))

    def on_commit(self, listener: Callable[[str, int], None]) -> None:
        """Call `listener(run, seq)`, in the writer's thread, once the events of a run up to `seq` can't be lost."""
        self._listeners.append(listener)

    def flush(self) -> None:
        """Wait until everything appended so far is committed; JournalError where it couldn't be written."""
        mark = threading.Event()
        self._jobs.put(mark)
        while not mark.wait(0.2) and self.writing:
            pass
        self._complain()

    def close(self) -> None:
        """Commit the rest and end the writer; harmless when it was closed before."""
        self._closing = True
        self._jobs.put(threading.Event())
        self._thread.join()
        self._complain()

    def _complain(self) -> None:
        if self._error is not None:
            raise JournalError(f"{self.file}: couldn't be written: {self._error}") from self._error

    # --- the writer's thread ---

    def _write(self, database: sqlite3.Connection) -> None:
        try:
            self._serve(database)
        except Exception as error:  # noqa: BLE001 - whoever flushes or closes is told
            self._error = error
            _log.error("%s: couldn't be written, the run continues without it: %s", self.file, error)
        finally:
            self.writing = False
            database.close()
        if self._error is not None:
            self._discard()

    def _serve(self, database: sqlite3.Connection) -> None:
        writers: dict[str, _RunWriter] = {}
        wait = _GATHER
        while True:
            closing = self._closing
            jobs = self._gather(wait)
            logs = self._logs
            busy = bool(jobs) or any(log.buffer for log in logs.values())
            if busy:
                self._commit(database, jobs, logs, writers)
                over = {run for run, log in logs.items() if log.ended and not log.buffer}
                if over:
                    with self._lock:
                        self._logs = {run: log for run, log in self._logs.items() if run not in over or log.buffer}
                    for run in over - self._logs.keys():
                        writers.pop(run, None)
            elif closing:
                return
            wait = _GATHER if busy else min(IDLE, wait * 1.2)

    def _gather(self, wait: float) -> list[_Job | threading.Event]:
        """Return the jobs there are; where none comes, after `wait` [s] at most. Without a run, wait for one."""
        timeout = 0.0 if self._closing else wait if self._logs else None
        try:
            return [self._jobs.get(timeout=timeout), *(self._jobs.get() for _ in range(self._jobs.qsize()))]
        except Empty:
            return []

    def _commit(
        self,
        database: sqlite3.Connection,
        jobs: list[_Job | threading.Event],
        logs: dict[str, RunLog],
        writers: dict[str, _RunWriter],
    ) -> None:
        database.execute("BEGIN IMMEDIATE")
        for job in jobs:
            if not isinstance(job, threading.Event):
                database.execute(*job)
        grown: dict[str, int] = {}
        for run, log in logs.items():
            if log.buffer:
                if run not in writers:
                    writers[run] = _RunWriter(database, log, self._largest)
                if writers[run].write():
                    grown[run] = writers[run].last
        database.execute("COMMIT")
        for run, seq in grown.items():
            for listener in list(self._listeners):
                listener(run, seq)
        for job in jobs:
            if isinstance(job, threading.Event):
                job.set()

    def _discard(self) -> None:
        """The journal can't be written: keep what waits from growing until it is closed."""
        while not self._closing:
            for log in self._logs.values():
                del log.buffer[: len(log.buffer) // ENTRIES * ENTRIES]
            for job in self._gather(IDLE):
                if isinstance(job, threading.Event):
                    job.set()
