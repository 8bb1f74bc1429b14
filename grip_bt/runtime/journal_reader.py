"""Reading runs, also while they are written: for replay, live views, tables."""

from __future__ import annotations

import json
import sqlite3
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grip_bt.errors import UnknownNameError

from .journal import JournalError


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
        self._database = sqlite3.connect(self.file, timeout=30, check_same_thread=False)
        try:
            self._database.execute("PRAGMA query_only=ON")
            self._database.execute("SELECT seq FROM events LIMIT 1")
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

    def events(self, run: str, after_seq: int = 0) -> list[Event]:
        """Return the events of a run that come after `after_seq`, in order."""
        columns = "seq, t, wall, path, event, outcome, code, data"
        rows = self._query(f"SELECT {columns} FROM events WHERE run=? AND seq>? ORDER BY seq", run, after_seq)
        return [Event(*row[:-1], json.loads(row[-1]) if row[-1] else {}) for row in rows]

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()

    def __enter__(self) -> JournalReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _query(self, statement: str, *values: Any) -> list[tuple[Any, ...]]:
        with self._lock:
            return self._database.execute(statement, values).fetchall()
