"""A library behind the port `Messages`: what tasks and scripts use where no server of messages runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ExpectedError, NoEntryError
from grip_bt.base.operation import Operation

from .library import MessageLibrary
from .store import Change, Entry


class LocalMessages:
    """Implements `grip_bt.base.ports.Messages` within this process.

    Args:
        library: the stores.
        saved: called after each `save`, which writes them somewhere; None when there is nowhere.
    """

    def __init__(self, library: MessageLibrary, saved: Callable[[], int] | None = None):
        self.library, self._save = library, saved

    def put(self, store: str, name: str, value: Any, provenance: str = "") -> Operation[None]:
        """Add or replace a value; without a name it goes to the end of the store's queue."""

        def work() -> None:
            there = self.library.store(store, make=True)
            if name:
                there.put(name, value, provenance)
            else:
                there.push(value, provenance)

        return _at_once(work)

    def get(self, store: str, name: str) -> Operation[Entry[Any]]:
        """Return an entry; without a name the oldest of the store's queue, which is removed."""
        return _at_once(lambda: self.library.store(store).entry(name) if name else self.library.store(store).take())

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store."""
        return _at_once(lambda: self.library.store(store).names())

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry."""
        return _at_once(lambda: self.library.store(store).delete(name))

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and read the project's files again."""
        return _at_once(lambda: self.library.reset(store))

    def save(self) -> Operation[int]:
        """Keep everything for later runs; return how many entries there are."""
        if self._save is None:
            return Operation.failed(NoEntryError("these messages are kept nowhere: they belong to no project"))
        return _at_once(self._save)

    def watch(self, callback: Callable[[str, Change[Any]], None]) -> Callable[[], None]:
        """Call `callback(store, change)` for each change, from the thread that makes it; return what ends that."""
        return self.library.watch(callback)


def _at_once(work: Callable[[], Any]) -> Operation[Any]:
    try:
        return Operation.finished(work())
    except UnknownNameError as error:
        return Operation.failed(NoEntryError(str(error), names=list(error.allowed)))
    except ExpectedError as error:
        return Operation.failed(error)
