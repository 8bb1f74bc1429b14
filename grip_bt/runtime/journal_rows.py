"""Tables and rows of a journal's file, how large it may become, and the processes that execute its runs."""

from __future__ import annotations

import os
import socket
import sqlite3
import threading
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
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

_TABLES = """
CREATE TABLE IF NOT EXISTS runs(
  id TEXT PRIMARY KEY, task_name TEXT, task_path TEXT, task_text TEXT, target TEXT, seed INTEGER,
  started REAL, ended REAL, status TEXT, outcome TEXT);
CREATE TABLE IF NOT EXISTS names(
  run TEXT, id INTEGER, path TEXT, event TEXT, outcome TEXT, code TEXT,
  PRIMARY KEY(run, id)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS blocks(
  run TEXT, first INTEGER, last INTEGER, content BLOB, data TEXT, sum INTEGER,
  PRIMARY KEY(run, first));
CREATE TABLE IF NOT EXISTS processes(
  run TEXT PRIMARY KEY, pid INTEGER, since INTEGER, host TEXT);
CREATE TABLE IF NOT EXISTS big_values(
  hash TEXT PRIMARY KEY, type TEXT, size INTEGER, content BLOB);
CREATE TABLE IF NOT EXISTS uses(
  run TEXT, hash TEXT,
  PRIMARY KEY(run, hash)) WITHOUT ROWID;
"""


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
    database.executescript(_TABLES)
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


ROOM = 0.9
"""Part of the limit that is left in use: a journal that has reached it isn't looked through after each run."""


@dataclass(frozen=True)
class Pruned:
    """What was removed: ids of runs, the oldest first; size in use before and afterwards [bytes]."""

    runs: tuple[str, ...]
    before: int
    after: int


def size_of(file: Path) -> int:
    """Return how much room a journal takes on the disk, what isn't in its main file yet included [bytes]."""
    return sum(part.stat().st_size for part in (file, file.with_name(file.name + "-wal")) if part.is_file())


def prune(file: Path, limit: int, keep: Callable[[str], bool] = lambda run: False, give_back: bool = False) -> Pruned:
    """Remove the oldest runs, with what only they have written, until a journal has room again; the newest stays.

    Others may write and read it meanwhile: each run goes in a transaction of its own. Room that becomes free is used
    for later runs.

    Args:
        limit: how much it may hold [bytes]; nothing happens below that, and above it `ROOM` of it is left in use.
        keep: whether a run that has no end stays: it is under way. Ended ones are never asked about.
        give_back: whether free room is given back to the disk, which rewrites the file; left out while others use it.

    Raises:
        JournalError: it is no journal, or can't be written.
    """
    try:
        with closing(sqlite3.connect(f"file:{file}?mode=rw", uri=True, timeout=30, isolation_level=None)) as database:
            refuse_other_versions(database)
            before = _in_use(database)
            removed = _make_room(database, limit, keep) if before > limit else ()
            if give_back:
                _vacuum(database)
            return Pruned(tuple(removed), before, _in_use(database))
    except (sqlite3.Error, UnicodeError, TypeError) as error:
        raise JournalError(f"{file}: runs can't be removed: {error}") from error


def _in_use(database: sqlite3.Connection) -> int:
    size, pages, free = (
        database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_size", "page_count", "freelist_count")
    )
    return int(size * (pages - free))


def _make_room(database: sqlite3.Connection, limit: int, keep: Callable[[str], bool]) -> Iterable[str]:
    removed: list[str] = []
    rows = database.execute("SELECT id, status FROM runs ORDER BY started").fetchall()
    for run, status in rows[:-1]:
        if _in_use(database) <= limit * ROOM:
            break
        if status == "running" and keep(run):
            continue
        database.execute("BEGIN IMMEDIATE")
        for table, key in (("blocks", "run"), ("names", "run"), ("processes", "run"), ("uses", "run"), ("runs", "id")):
            database.execute(f"DELETE FROM {table} WHERE {key}=?", (run,))
        database.execute("DELETE FROM big_values WHERE hash NOT IN (SELECT hash FROM uses)")
        database.execute("COMMIT")
        removed.append(run)
    return removed


def _vacuum(database: sqlite3.Connection) -> None:
    with suppress(
        sqlite3.OperationalError
    ):  # somebody reads or writes it; the room is used for later runs all the same
        database.execute("PRAGMA busy_timeout=0")
        database.execute("VACUUM")
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
