"""Stores kept in a file from one run to the next: one SQLite file, values as bytes of whoever knows them."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError

from .store import Entry, MessageStore

_TABLE = """
CREATE TABLE entry (store TEXT NOT NULL, name TEXT NOT NULL, value BLOB NOT NULL, time REAL NOT NULL,
                    provenance TEXT NOT NULL)
"""


class ArchiveError(GripError):
    """A file of kept messages can't be read."""


def save(stores: Mapping[str, MessageStore[Any]], file: Path, encode: Callable[[Any], bytes]) -> int:
    """Write all entries and queues into a file, in place of what it held; return how many there are.

    Args:
        stores: by name.
        file: written beside itself first: what was there stays whole when we are killed.
        encode: makes bytes of a value.
    """
    beside = file.with_name(f"{file.name}.{os.getpid()}.new")
    beside.unlink(missing_ok=True)
    rows = [
        (name, entry.name, encode(entry.value), entry.time, entry.provenance)
        for name, store in stores.items()
        for entry in (*store.entries(), *store.queue())
    ]
    with closing(sqlite3.connect(beside)) as connection, connection:
        connection.execute(_TABLE)
        connection.executemany("INSERT INTO entry VALUES (?, ?, ?, ?, ?)", rows)
    beside.replace(file)
    return len(rows)


def names(file: Path) -> dict[str, set[str]]:
    """Return store -> names of the entries in a file; none where there is no such file, or it can't be read."""
    found: dict[str, set[str]] = {}
    try:
        with closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True)) as connection:
            for store, name in connection.execute("SELECT DISTINCT store, name FROM entry"):
                found.setdefault(store, set()).add(name)
    except sqlite3.Error:
        return {}  # whoever loads it says what is wrong
    return found


def load(store_of: Callable[[str], MessageStore[Any]], file: Path, decode: Callable[[bytes], Any]) -> int:
    """Put the entries of a file into stores, in their order; return how many there are.

    What a store has under the same name is replaced; queues are continued.

    Raises:
        ArchiveError: it isn't such a file.
    """
    if not file.is_file():
        raise ArchiveError(f"{file}: there is no such file")
    try:
        with closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True)) as connection:
            rows = connection.execute(
                "SELECT store, name, value, time, provenance FROM entry ORDER BY rowid"
            ).fetchall()
    except sqlite3.Error as error:
        raise ArchiveError(f"{file}: can't be read as kept messages: {error}") from None
    for store, name, value, time, provenance in rows:
        store_of(store).restore(Entry(name, decode(value), time, provenance))
    return len(rows)
