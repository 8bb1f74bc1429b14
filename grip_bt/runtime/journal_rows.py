"""Tables and rows of a journal's file, and the processes that execute its runs."""

from __future__ import annotations

import os
import socket
import sqlite3
import threading
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError


def process_facts() -> dict[str, object]:
    """Return who this process is, for whoever wants to know later whether it lives."""
    return {"pid": os.getpid(), "since": _begun(os.getpid()), "host": socket.gethostname()}


def is_there(facts: Mapping[str, object]) -> bool | None:
    """Tell whether a process is there; None where that isn't known, such as of another machine."""
    pid, since = facts.get("pid"), facts.get("since")
    if facts.get("host") != socket.gethostname() or type(pid) is not int or type(since) is not int:
        return None
    return _begun(pid) == since


def _begun(pid: int) -> int | None:
    """Return when a process began [ticks since boot]; None when there is none.

    One that has ended and whose parent hasn't taken note of it doesn't count: in a container nobody may ever.
    """
    try:
        facts = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return None if facts[0] in "ZX" else int(facts[19])
    except (OSError, ValueError, IndexError):
        return None


VERSION = 3
"""Of the tables, kept in `PRAGMA user_version`; 0 where there are none yet."""


class JournalError(GripError):
    """The journal can't be written or read."""


def prepare_to_write(database: sqlite3.Connection) -> None:
    """Make the tables that are missing.

    Raises:
        sqlite3.DatabaseError: it is no database, or of another version.
    """
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("PRAGMA synchronous=FULL")  # a power cut loses nothing that was acknowledged
    refuse_other_versions(database)
    database.executescript(Path(__file__).with_name("journal.sql").read_text(encoding="utf-8"))
    database.execute(f"PRAGMA user_version={VERSION}")


def refuse_other_versions(database: sqlite3.Connection) -> None:
    """Raise where the journal was written by another version.

    Raises:
        sqlite3.DatabaseError: so it is.
    """
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if version not in (0, VERSION):
        advice = "move it away, and the next run begins a new one"
        raise sqlite3.DatabaseError(f"it is of version {version}, this GRIP reads version {VERSION}: {advice}")


def take_over(file: Path, other: Path) -> None:
    """Copy the runs of another journal, which nobody writes meanwhile; JournalError where that can't be done."""
    try:
        with closing(sqlite3.connect(file, timeout=30, isolation_level=None)) as database:
            prepare_to_write(database)
            database.execute("ATTACH ? AS other", (str(other),))
            database.execute("BEGIN IMMEDIATE")
            for table in ("runs", "names", "blocks", "processes", "big_values", "uses"):
                database.execute(f"INSERT OR IGNORE INTO main.{table} SELECT * FROM other.{table}")
            database.execute("COMMIT")
    except sqlite3.Error as error:
        raise JournalError(f"{file}: the runs of {other} can't be copied into it: {error}") from error


_BUSY = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)
BAD = (sqlite3.Error, UnicodeError, OverflowError, MemoryError, ValueError, TypeError)
"""What sqlite3 raises for files that are damaged; their names of tables are in its words, decoded."""


class Rows:
    """Reads a journal's file; may be used from several threads.

    Raises:
        JournalError: there is no such file, or it isn't a journal.
    """

    def __init__(self, file: Path):
        self._file, self._lock = file, threading.Lock()
        if not file.is_file():
            raise JournalError(f"{file}: there is no journal; runs are written to it as soon as there is one")
        try:
            self._database = sqlite3.connect(file, timeout=30, check_same_thread=False)
            self._database.text_factory = lambda text: text.decode(errors="replace")
        except sqlite3.OperationalError as error:
            raise JournalError(f"{file}: can't be read: {error}; fix its permissions, or name another file") from error
        try:
            self._database.execute("PRAGMA query_only=ON")
            refuse_other_versions(self._database)
            self._database.execute("SELECT 1 FROM blocks LIMIT 0")
        except BAD as error:
            self._database.close()
            raise JournalError(f"{file}: isn't a journal: {error}") from error

    def close(self) -> None:
        self._database.close()

    def query(self, statement: str, *values: object) -> list[tuple[Any, ...]]:
        """Return rows; JournalError where they can't be read, now or since the file is damaged."""
        try:
            with self._lock:
                return self._database.execute(statement, values).fetchall()
        except BAD as error:
            busy = getattr(error, "sqlite_errorcode", None) in _BUSY
            advice = "" if busy else f"; `sqlite3 {self._file} .recover` writes what is still whole of a damaged file"
            raise JournalError(f"{self._file}: can't be read: {error}{advice}") from error
