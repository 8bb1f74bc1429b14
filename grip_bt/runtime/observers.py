"""Observers of a run beside its journal: one that keeps state beside the task, one that waits for the disk."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Protocol

from grip_bt.base.values import Failure
from grip_bt.nodes.node import Silent
from grip_bt.runtime.journal import Journal
from grip_bt.runtime.journal_rows import JournalError

KEPT = "kept"
"""The event; its data has `part` and, as a write has, the state."""


class Kept(Protocol):
    """A part of a run whose state is kept."""

    def changed(self) -> Any:
        """Return its state as a value that the journal can restore; None where it is what it was at the last call.

        Called in the thread that ticks: it takes microseconds, or a few milliseconds for what has just moved.
        """

    def restore(self, state: object) -> None:
        """Bring it into a state that `changed` has returned, in another process.

        Raises:
            GripError: it can't be brought there; it says why.
        """


class Keeper(Silent):
    """An observer that notes the states of parts; told before the journal's.

    Args:
        note: `note(path, part, state)` enters one into the journal.
        parts: by name.
        leaves: leaf -> names of the parts that its work may change.
    """

    def __init__(
        self, note: Callable[[str, str, Any], None], parts: Mapping[str, Kept], leaves: Mapping[str, tuple[str, ...]]
    ):
        self._note, self._parts, self._leaves = note, parts, leaves

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Note what has changed."""
        self.interrupted(path)

    def interrupted(self, path: str) -> None:
        """Likewise."""
        for name in self._leaves.get(path, ()):
            state = self._parts[name].changed()
            if state is not None:
                self._note(path, name, state)


class Durable:
    """An observer that waits, as some leaves begin, until that is on the disk; told after the recorder.

    Args:
        journal: where the run is written.
        leaves: paths of those leaves.
    """

    def __init__(self, journal: Journal, leaves: Collection[str]):
        self._journal, self._leaves = journal, frozenset(leaves)

    def entered(self, path: str) -> None:
        """Wait for the disk; a journal that can't be written has said so in the log, and the run goes on without."""
        if path in self._leaves:
            try:
                self._journal.flush()
            except JournalError:
                self._leaves = frozenset()

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Wait for the disk too: what has been done isn't asked about."""
        self.entered(path)

    def interrupted(self, path: str) -> None:
        """Do nothing: it may have been stopped, which nobody waits for."""

    def message(self, path: str, text: str) -> None:
        """Do nothing."""

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """Do nothing."""
