"""How large a journal may become: the oldest runs make room for new ones."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterable
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from grip_bt.runtime.journal_rows import JournalError, refuse_other_versions

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
