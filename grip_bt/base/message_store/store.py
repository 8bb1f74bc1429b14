"""One generic store of named values of one type. It knows no ROS and no task: adapters serve it by name."""

from __future__ import annotations

import os
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Literal, TypeVar

from grip_bt.base.errors import GripError, UnknownNameError, WrongTypeError
from grip_bt.base.failures import EmptyQueueError
from grip_bt.base.types import check_value, parse_type

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Entry(Generic[T]):
    """A value with what is known of it.

    Attributes:
        name: its name; empty in the queue.
        value: as it was put: not rounded, not copied.
        time: when it was put, seconds of the Unix epoch.
        provenance: who or what put it, such as a file or a node; for people.
    """

    name: str
    value: T
    time: float
    provenance: str = ""
    revision: int = 0


ChangeKind = Literal["put", "deleted", "pushed", "taken"]


@dataclass(frozen=True, slots=True)
class Change(Generic[T]):
    """What happened to a name.

    Attributes:
        kind: `put`, `deleted`; of the queue `pushed` or `taken`.
        value: the new value; None when it was deleted.
    """

    kind: ChangeKind
    name: str
    value: T | None
    revision: int


class MessageStore(Generic[T]):
    """Named values of one type, and a queue of values without a name; safe to use from any thread.

    Values are frozen or treated as such: what was put is what is got, not a copy.

    Args:
        type_name: as in a manifest: `Grasp`, `list[Pose]`, `Any`.
    """

    def __init__(self, name: str, type_name: str):
        self.name, self.type_name = name, type_name
        self._type = parse_type(type_name)
        self._lock = threading.RLock()
        self._entries: dict[str, Entry[T]] = {}
        self._queue: deque[Entry[T]] = deque()
        self._watchers: list[Callable[[Change[T]], None]] = []
        self._revision = 0

    @property
    def revision(self) -> int:
        """How often the store has changed."""
        return self._revision

    def put(self, name: str, value: T, provenance: str = "", at: float | None = None) -> Entry[T]:
        """Add or replace a value.

        Args:
            at: when it was made, seconds of the Unix epoch; now by default.

        Raises:
            WrongTypeError: it isn't of the store's type.
            ValueError: the name is empty.
        """
        if not name:
            raise ValueError(f"store {self.name!r}: an entry needs a name; without one it goes into the queue: push")
        self._check(name, value)
        with self._lock:
            entry = self._entries[name] = self._made(name, value, provenance, at)
            self._tell("put", name, value)
            return entry

    def push(self, value: T, provenance: str = "", at: float | None = None) -> Entry[T]:
        """Put a value without a name at the end of the queue. Raises WrongTypeError: it isn't of the store's type."""
        self._check("the queue", value)
        with self._lock:
            entry = self._made("", value, provenance, at)
            self._queue.append(entry)
            self._tell("pushed", "", value)
            return entry

    def take(self) -> Entry[T]:
        """Remove the oldest value of the queue and return it. Raises EmptyQueueError: there is none."""
        with self._lock:
            if not self._queue:
                raise EmptyQueueError(self.name)
            entry = self._queue.popleft()
            self._tell("taken", "", entry.value)
            return entry

    @property
    def queued(self) -> int:
        """How many values wait in the queue."""
        return len(self._queue)

    def get(self, name: str) -> T:
        """Return a value. Raises UnknownNameError: there is none of this name."""
        return self.entry(name).value

    def entry(self, name: str) -> Entry[T]:
        """Return a value with what is known of it. Raises UnknownNameError: there is none of this name."""
        with self._lock:
            if name not in self._entries:
                raise UnknownNameError("entry", name, self._entries, where=f"store {self.name!r}")
            return self._entries[name]

    def entries(self) -> tuple[Entry[T], ...]:
        """Return all entries that have a name, in the order in which they were first put."""
        with self._lock:
            return tuple(self._entries.values())

    def queue(self) -> tuple[Entry[T], ...]:
        """Return what waits in the queue, the oldest first; it stays there."""
        with self._lock:
            return tuple(self._queue)

    def names(self) -> tuple[str, ...]:
        """Return all names, in the order in which they were first put."""
        with self._lock:
            return tuple(self._entries)

    def delete(self, name: str) -> None:
        """Remove an entry. Raises UnknownNameError: there is none of this name."""
        with self._lock:
            self.get(name)
            del self._entries[name]
            self._tell("deleted", name, None)

    def restore(self, entry: Entry[T]) -> None:
        """Put an entry back as it was, with its time and provenance; without a name, into the queue."""
        if entry.name:
            self.put(entry.name, entry.value, entry.provenance, entry.time)
        else:
            self.push(entry.value, entry.provenance, entry.time)

    def clear(self) -> None:
        """Remove all entries and empty the queue."""
        with self._lock:
            while self._queue:
                self.take()
            for name in list(self._entries):
                self.delete(name)

    def watch(self, callback: Callable[[Change[T]], None]) -> Callable[[], None]:
        """Call `callback` for each change, in order, from the thread that makes it; it must return quickly.

        Returns:
            A function that ends the watching.
        """
        with self._lock:
            self._watchers.append(callback)
        return lambda: self._watchers.remove(callback) if callback in self._watchers else None

    def _check(self, name: str, value: T) -> None:
        reason = check_value(self._type, value)
        if reason is not None:
            raise WrongTypeError(self.name, name, self.type_name, reason)

    def _made(self, name: str, value: T, provenance: str, at: float | None) -> Entry[T]:
        return Entry(name, value, time.time() if at is None else at, provenance, self._revision + 1)

    def _tell(self, kind: ChangeKind, name: str, value: T | None) -> None:
        self._revision += 1
        change: Change[T] = Change(kind, name, value, self._revision)
        for callback in list(self._watchers):
            callback(change)

    def __contains__(self, name: object) -> bool:
        with self._lock:
            return name in self._entries

    def __len__(self) -> int:
        return len(self._entries)


_TABLE = """
CREATE TABLE entry (store TEXT NOT NULL, name TEXT NOT NULL, value BLOB NOT NULL, time REAL NOT NULL,
                    provenance TEXT NOT NULL)
"""


class ArchiveError(GripError):
    """A file of kept messages can't be read."""


def save(stores: Mapping[str, MessageStore[T]], file: Path, encode: Callable[[T], bytes]) -> int:
    """Write all entries and queues into a file, in place of what it held; return how many there are.

    Args:
        file: written beside itself first: what was there stays whole when we are killed.
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


def load(store_of: Callable[[str], MessageStore[T]], file: Path, decode: Callable[[bytes], T]) -> int:
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
    for store, name, value, at, provenance in rows:
        store_of(store).restore(Entry(name, decode(value), at, provenance))
    return len(rows)
