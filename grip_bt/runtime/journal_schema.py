"""Tables of a journal's file; `docs/journal.md` describes them for those who query it themselves."""

from __future__ import annotations

import sqlite3

VERSION = 2
"""Of the tables, kept in `PRAGMA user_version`. Journals of version 1 (a row per event) are read and continued."""

TABLES = """
CREATE TABLE IF NOT EXISTS runs(
  id TEXT PRIMARY KEY, task_name TEXT, task_path TEXT, task_text TEXT, target TEXT, seed INTEGER,
  started REAL, ended REAL, status TEXT, outcome TEXT);
CREATE TABLE IF NOT EXISTS names(
  run TEXT, id INTEGER, path TEXT, event TEXT, outcome TEXT, code TEXT,
  PRIMARY KEY(run, id)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS blocks(
  run TEXT, first INTEGER, last INTEGER, name BLOB, t BLOB, wall BLOB, wall_offset REAL, data TEXT, writes INTEGER,
  sum INTEGER,
  PRIMARY KEY(run, first));
CREATE TABLE IF NOT EXISTS processes(
  run TEXT PRIMARY KEY, pid INTEGER, since INTEGER, host TEXT);
CREATE TABLE IF NOT EXISTS big_values(
  hash TEXT PRIMARY KEY, type TEXT, size INTEGER, content BLOB);
"""


def has_table(database: sqlite3.Connection, name: str) -> bool:
    """Tell whether there is such a table."""
    found = database.execute("SELECT 1 FROM sqlite_master WHERE type='table' AND name=?", (name,)).fetchone()
    return found is not None


def prepare_to_write(database: sqlite3.Connection) -> None:
    """Make what is missing; a journal written before keeps its rows.

    Raises:
        sqlite3.DatabaseError: it is no database, or of a version that this one doesn't know.
    """
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("PRAGMA synchronous=FULL")  # a power cut loses nothing that was acknowledged
    refuse_newer(database)
    database.executescript(TABLES)
    if all(row[1] != "sum" for row in database.execute("PRAGMA table_info(blocks)")):
        database.execute("ALTER TABLE blocks ADD COLUMN sum INTEGER")
    database.execute(f"PRAGMA user_version={VERSION}")


def refuse_newer(database: sqlite3.Connection) -> None:
    """Raise where the journal was written by a later version.

    Raises:
        sqlite3.DatabaseError: so it is.
    """
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if version > VERSION:
        raise sqlite3.DatabaseError(f"it is of version {version}, this GRIP reads up to {VERSION}: use a newer one")
