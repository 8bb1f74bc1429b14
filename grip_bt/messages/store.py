"""One generic store of named values of one type. It knows no ROS and no task: adapters serve it by name."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, Literal, TypeVar

from grip_bt.catalog.types import check_value, parse_type
from grip_bt.errors import UnknownNameError, WrongTypeError

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Change(Generic[T]):
    """What happened to a name.

    Attributes:
        kind: `put` or `deleted`.
        name: of the entry.
        value: the new value; None when it was deleted.
        revision: counts the changes of the store, from 1.
    """

    kind: Literal["put", "deleted"]
    name: str
    value: T | None
    revision: int


class MessageStore(Generic[T]):
    """Named values of one type; safe to use from any thread.

    Values are frozen or treated as such: what was put is what is got, not a copy.

    Args:
        name: of the store, for messages.
        type_name: as in a manifest: `Grasp`, `list[Pose]`, `Any`.
    """

    def __init__(self, name: str, type_name: str):
        self.name, self.type_name = name, type_name
        self._type = parse_type(type_name)
        self._lock = threading.RLock()
        self._values: dict[str, T] = {}
        self._watchers: dict[object, Callable[[Change[T]], None]] = {}
        self._revision = 0

    @property
    def revision(self) -> int:
        """How often the store has changed."""
        return self._revision

    def put(self, name: str, value: T) -> None:
        """Add or replace a value.

        Raises:
            WrongTypeError: it isn't of the store's type.
            ValueError: the name is empty.
        """
        if not name:
            raise ValueError(f"store {self.name!r}: an entry needs a name")
        reason = check_value(self._type, value)
        if reason is not None:
            raise WrongTypeError(self.name, name, self.type_name, reason)
        with self._lock:
            self._values[name] = value
            self._tell("put", name, value)

    def get(self, name: str) -> T:
        """Return a value.

        Raises:
            UnknownNameError: there is none of this name.
        """
        with self._lock:
            if name not in self._values:
                raise UnknownNameError("entry", name, self._values, where=f"store {self.name!r}")
            return self._values[name]

    def names(self) -> tuple[str, ...]:
        """Return all names, in the order in which they were first put."""
        with self._lock:
            return tuple(self._values)

    def delete(self, name: str) -> None:
        """Remove an entry.

        Raises:
            UnknownNameError: there is none of this name.
        """
        with self._lock:
            self.get(name)
            del self._values[name]
            self._tell("deleted", name, None)

    def clear(self) -> None:
        """Remove all entries."""
        with self._lock:
            for name in list(self._values):
                self.delete(name)

    def watch(self, callback: Callable[[Change[T]], None], *, replay: bool = False) -> Callable[[], None]:
        """Call `callback` for each change, in order, from the thread that makes it; it must return quickly.

        Args:
            callback: told of changes.
            replay: whether it is first told of every entry that is there, as if it had just been put.

        Returns:
            A function that ends the watching.
        """
        key = object()
        with self._lock:
            if replay:
                for name, value in self._values.items():
                    callback(Change("put", name, value, self._revision))
            self._watchers[key] = callback
        return lambda: self._unwatch(key)

    def _unwatch(self, key: object) -> None:
        with self._lock:
            self._watchers.pop(key, None)

    def _tell(self, kind: Literal["put", "deleted"], name: str, value: Any) -> None:
        self._revision += 1
        change: Change[T] = Change(kind, name, value, self._revision)
        for callback in list(self._watchers.values()):
            callback(change)

    def __contains__(self, name: object) -> bool:
        with self._lock:
            return name in self._values

    def __len__(self) -> int:
        return len(self._values)
