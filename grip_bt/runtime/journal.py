"""The event log of runs: append-only, in SQLite with a write-ahead log, readable while it is written.

The thread that ticks only extends a list; a writer thread packs what has gathered into a block and commits it. What
was committed survives the death of the process and of the machine. Whoever shows events waits for `on_commit` first, so
that nothing is seen that could be lost. The tables are described in `docs/journal.md`.
"""

from __future__ import annotations

import logging
import os
import secrets
import sqlite3
import threading
import time
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from grip_bt.runtime.journal_rows import JournalError, prepare_to_write, process_facts

from .journal_writer import RunWriter
from .run_log import ENTRIES, RunLog

_log = logging.getLogger(__name__)

_GATHER = 0.01
"""How long [s] events gather before they are committed together; nobody waits for it who calls `flush`."""
IDLE = 0.04
"""How long [s] at most between two looks at runs in which nothing happens."""
LARGEST = 16 * 2**20
"""Values of more bytes aren't kept unless the journal is told to."""
_Job = tuple[str, tuple[Any, ...]]


class Journal:
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
        opened: list[BaseException | None] = []
        started = threading.Event()
        self._thread = threading.Thread(target=self._write, args=(opened, started), name="grip_journal", daemon=True)
        self._thread.start()
        started.wait()
        if opened and opened[0] is not None:
            raise JournalError(f"{self.file}: can't be opened as a journal: {opened[0]}") from opened[0]

    def begin(
        self,
        task_name: str,
        task_path: str = "",
        task_text: str = "",
        target: str = "bt",
        seed: int | None = None,
    ) -> RunLog:
        """Enter a new run and return its log.

        Args:
            task_name: name of the task.
            task_path: the file that it came from.
            task_text: the document as it is run.
            target: `bt` or `sm`.
            seed: of the simulation, if any.
        """
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
        """Wait until everything appended so far is committed.

        Raises:
            JournalError: it couldn't be written.
        """
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

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- the writer's thread ---

    def _write(self, opened: list[BaseException | None], started: threading.Event) -> None:
        try:
            database = sqlite3.connect(self.file, timeout=30, isolation_level=None)
            prepare_to_write(database)
        except (sqlite3.Error, UnicodeError) as error:
            opened.append(error)
            return
        finally:
            started.set()
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
        writers: dict[str, RunWriter] = {}
        wait = _GATHER
        while True:
            closing = self._closing
            jobs = self._gather(wait)
            logs = self._logs
            busy = bool(jobs) or any(log.buffer for log in logs.values())
            if busy:
                self._commit(database, jobs, logs, writers)
                self._part_with(writers)
            elif closing:
                return
            wait = _GATHER if busy else min(IDLE, wait * 1.2)

    def _part_with(self, writers: dict[str, RunWriter]) -> None:
        with self._lock:
            over = {run for run, log in self._logs.items() if log.ended and not log.buffer}
            if over:
                self._logs = {run: log for run, log in self._logs.items() if run not in over}
        for run in over:
            writers.pop(run, None)

    def _gather(self, wait: float) -> list[_Job | threading.Event]:
        """Return the jobs there are; where none comes, after `wait` [s] at most. Without a run, wait for one."""
        timeout = 0.0 if self._closing else wait if self._logs else None
        try:
            jobs = [self._jobs.get(timeout=timeout)]
        except Empty:
            return []
        for _ in range(self._jobs.qsize()):
            jobs.append(self._jobs.get())
        return jobs

    def _commit(
        self,
        database: sqlite3.Connection,
        jobs: list[_Job | threading.Event],
        logs: dict[str, RunLog],
        writers: dict[str, RunWriter],
    ) -> None:
        database.execute("BEGIN IMMEDIATE")
        for job in jobs:
            if not isinstance(job, threading.Event):
                database.execute(*job)
        grown: dict[str, int] = {}
        for run, log in logs.items():
            if log.buffer:
                if run not in writers:
                    writers[run] = RunWriter(database, log, self._largest)
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
