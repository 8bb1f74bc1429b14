"""Named values that outlive a node."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from grip_bt.base.operation import Operation


@runtime_checkable
class Messages(Protocol):
    """Named values that outlive a task: stores of joint states, poses, grasps, anything."""

    def put(self, store: str, name: str, value: Any, provenance: str = "") -> Operation[None]:
        """Add or replace a value; without a name it goes to the end of the store's queue.

        Raises:
            WrongTypeError: the store holds another type.
        """

    def get(self, store: str, name: str) -> Operation[Any]:
        """Return an entry, with `value`, `time` [s of the Unix epoch] and `provenance`.

        Without a name: the oldest of the store's queue, which is removed. Ends with NoEntryError or EmptyQueueError.
        """

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store. Ends with NoEntryError."""

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry. Ends with NoEntryError."""

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and read the project's files again. Ends with NoEntryError."""

    def save(self) -> Operation[int]:
        """Keep everything for later runs; the result is the number of entries."""
