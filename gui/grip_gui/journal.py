"""Reads runs and events from the journal, for the live view and the replay alike."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any, Protocol

from .messages import RunEvent, RunRecord


class RunSource(Protocol):
    """Where the page's runs come from."""

    def runs(self, limit: int = 100) -> list[RunRecord]:
        """Return the latest runs, newest first."""
        ...

    def run(self, run: str) -> RunRecord | None:
        """Return one run, None when it isn't there."""
        ...

    def task_text(self, run: str) -> str:
        """Return the task file as it was when the run started; empty when the run isn't there."""
        ...

    def events(self, run: str, from_seq: int, limit: int) -> list[RunEvent]:
        """Return at most `limit` events from `from_seq` on, in order."""
        ...

    def last_seq(self, run: str) -> int:
        """Return the number of the last event, -1 when there is none."""
        ...


_RUN = "SELECT id, task_name, task_path, target, seed, started, ended, status, outcome FROM runs"
_EVENT = "SELECT seq, t, path, event, outcome, code, data FROM events WHERE run = ? AND seq >= ? ORDER BY seq LIMIT ?"


class SqliteRuns:
    """The journal file of a project, opened read-only for each question; a missing file has no runs."""

    def __init__(self, file: Path):
        self.file = file

    def runs(self, limit: int = 100) -> list[RunRecord]:
        """Return the latest runs, newest first."""
        return [_record(row) for row in self._ask(f"{_RUN} ORDER BY started DESC LIMIT ?", (limit,))]

    def run(self, run: str) -> RunRecord | None:
        """Return one run, None when it isn't there."""
        rows = self._ask(f"{_RUN} WHERE id = ?", (run,))
        return _record(rows[0]) if rows else None

    def task_text(self, run: str) -> str:
        """Return the task file as it was when the run started."""
        rows = self._ask("SELECT task_text FROM runs WHERE id = ?", (run,))
        return str(rows[0]["task_text"]) if rows else ""

    def events(self, run: str, from_seq: int, limit: int) -> list[RunEvent]:
        """Return at most `limit` events from `from_seq` on, in order."""
        return [_event(row) for row in self._ask(_EVENT, (run, from_seq, limit))]

    def last_seq(self, run: str) -> int:
        """Return the number of the last event, -1 when there is none."""
        rows = self._ask("SELECT MAX(seq) AS last FROM events WHERE run = ?", (run,))
        return -1 if not rows or rows[0]["last"] is None else int(rows[0]["last"])

    def _ask(self, query: str, values: tuple[Any, ...]) -> list[sqlite3.Row]:
        if not self.file.is_file():
            return []
        with closing(sqlite3.connect(f"{self.file.as_uri()}?mode=ro", uri=True, timeout=2.0)) as connection:
            connection.row_factory = sqlite3.Row
            try:
                return connection.execute(query, values).fetchall()
            except sqlite3.OperationalError as error:
                if "no such table" in str(error):
                    return []  # the run's process has made the file and not yet its tables
                raise


def _record(row: sqlite3.Row) -> RunRecord:
    return RunRecord(**dict(row))


def _event(row: sqlite3.Row) -> RunEvent:
    data = json.loads(row["data"]) if row["data"] else {}
    return RunEvent(**{**dict(row), "path": row["path"] or "/", "data": data})
