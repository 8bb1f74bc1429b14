"""The event log of runs: append-only, in SQLite with a write-ahead log, readable while it is written.

The thread that ticks only appends to a queue; a writer thread commits whatever has gathered, in one transaction. What
was committed survives the death of the process and of the machine. Whoever shows events waits for `on_commit` first, so
that nothing is seen that could be lost.
"""

from __future__ import annotations

import json
import secrets
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from grip_bt.errors import GripError

SCHEMA = """
CREATE TABLE IF NOT EXISTS runs(
  id TEXT PRIMARY KEY, task_name TEXT, task_path TEXT, task_text TEXT, target TEXT, seed INTEGER,
  started REAL, ended REAL, status TEXT, outcome TEXT);
CREATE TABLE IF NOT EXISTS events(
  run TEXT, seq INTEGER, t REAL, wall REAL, path TEXT, event TEXT, outcome TEXT, code TEXT, data TEXT,
  PRIMARY KEY(run, seq)) WITHOUT ROWID;
"""
_GATHER = 0.01
"""How long [s] events gather before they are committed together; nobody waits for it who calls `flush`."""
_INSERT = "INSERT INTO events VALUES(?,?,?,?,?,?,?,?,?)"
_Job = tuple[str, tuple[Any, ...]]


class JournalError(GripError):
    """The journal can't be written or read."""


class Journal:
    """Writes runs to a file; one process at a time writes a run, several may write the file.

    Args:
        file: created with its folder when it isn't there.
    """

    def __init__(self, file: Path | str):
        self.file = Path(file)
        self.file.parent.mkdir(parents=True, exist_ok=True)
        # Its put() is re-entrant, so that a signal handler may stop a run, which is an event too.
        self._jobs: SimpleQueue[_Job | threading.Event] = SimpleQueue()
        self._hurry = threading.Event()
        self._closing = False
        self._error: BaseException | None = None
        self._listeners: list[Callable[[str, int], None]] = []
        opened: list[BaseException | None] = []
        started = threading.Event()
        self._thread = threading.Thread(target=self._write, args=(opened, started), name="grip_journal", daemon=True)
        self._thread.start()
        started.wait()
        if opened and opened[0] is not None:
            raise JournalError(f"{self.file}: can't be opened as a journal: {opened[0]}") from opened[0]

    def begin(
        self, task_name: str, task_path: str = "", task_text: str = "", target: str = "bt", seed: int | None = None
    ) -> RunLog:
        """Enter a new run and return its log."""
        run = time.strftime("%Y%m%d-%H%M%S-") + secrets.token_hex(3)
        row = (run, task_name, task_path, task_text, target, seed, time.time(), None, "running", None)
        self._put(("INSERT INTO runs VALUES(?,?,?,?,?,?,?,?,?,?)", row))
        return RunLog(self, run)

    def on_commit(self, listener: Callable[[str, int], None]) -> None:
        """Call `listener(run, seq)`, in the writer's thread, once the events of a run up to `seq` can't be lost."""
        self._listeners.append(listener)

    def flush(self) -> None:
        """Wait until everything appended so far is committed.

        Raises:
            JournalError: it couldn't be written.
        """
        mark = threading.Event()
        self._hurry.set()
        self._put(mark)
        while not mark.wait(0.2) and self._thread.is_alive():
            pass
        if self._error is not None:
            raise JournalError(f"{self.file}: couldn't be written: {self._error}") from self._error

    def close(self) -> None:
        """Commit the rest and end the writer; harmless when it was closed before."""
        self._closing = True
        self._hurry.set()
        self._jobs.put(threading.Event())
        self._thread.join()
        if self._error is not None:
            raise JournalError(f"{self.file}: couldn't be written: {self._error}") from self._error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _put(self, job: _Job | threading.Event) -> None:
        self._jobs.put(job)  # the order in this queue is the order of the log

    # --- the writer's thread ---

    def _write(self, opened: list[BaseException | None], started: threading.Event) -> None:
        try:
            database = sqlite3.connect(self.file, timeout=30, isolation_level=None)
            database.execute("PRAGMA journal_mode=WAL")
            database.execute("PRAGMA synchronous=FULL")  # a power cut loses nothing that was acknowledged
            database.executescript(SCHEMA)
        except sqlite3.Error as error:
            opened.append(error)
            started.set()
            return
        started.set()
        last: dict[str, int] = {}
        try:
            while not (self._closing and self._jobs.empty()):
                first = self._jobs.get()
                self._hurry.wait(_GATHER)
                self._hurry.clear()
                self._commit(database, [first, *self._gathered()], last)
        except sqlite3.Error as error:
            self._error = error
        finally:
            database.close()

    def _gathered(self) -> Iterator[_Job | threading.Event]:
        for _ in range(self._jobs.qsize()):
            yield self._jobs.get()

    def _commit(self, database: sqlite3.Connection, jobs: list[_Job | threading.Event], last: dict[str, int]) -> None:
        marks: list[threading.Event] = []
        grown: dict[str, int] = {}
        database.execute("BEGIN IMMEDIATE")
        for job in jobs:
            if isinstance(job, threading.Event):
                marks.append(job)
                continue
            statement, values = job
            if statement is _INSERT:
                run, data = values[0], values[-1]
                grown[run] = last[run] = last.get(run, 0) + 1
                text = json.dumps(data, default=str) if data else None
                values = (run, last[run], *values[1:-1], text)
            database.execute(statement, values)
        database.execute("COMMIT")
        for run, seq in grown.items():
            for listener in list(self._listeners):
                listener(run, seq)
        for mark in marks:
            mark.set()


class RunLog:
    """The log of one run.

    Attributes:
        id: the run's id.
    """

    def __init__(self, journal: Journal, run: str):
        self.journal, self.id = journal, run

    def append(
        self,
        t: float,
        path: str,
        event: str,
        outcome: str | None = None,
        code: str | None = None,
        data: dict[str, Any] | None = None,
    ) -> None:
        """Add an event; returns before it is committed.

        Args:
            t: time on the run's clock [s].
            path: the node; `/` for the root and for the run itself.
            event: its kind.
            outcome: of an end.
            code: of a failure.
            data: anything else, as JSON.
        """
        self.journal._put((_INSERT, (self.id, t, time.time(), path, event, outcome, code, data)))

    def end(self, status: str, outcome: str | None) -> None:
        """Enter how the run has ended."""
        statement = "UPDATE runs SET ended=?, status=?, outcome=? WHERE id=?"
        self.journal._put((statement, (time.time(), status, outcome, self.id)))
