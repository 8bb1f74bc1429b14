"""State beside the task that a run changes and that its process takes along when it dies, kept in the journal.

The planning scene, named messages, a simulated world: where a leaf may have changed one, its state is noted in the
journal just before the leaf's end, so that whoever goes on with the run brings it back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from grip_bt.base.values import Failure
from grip_bt.nodes.node import Silent

KEPT = "kept"
"""The event; its data has `part` and, as a write has, the state."""


class Kept(Protocol):
    """A part of a run whose state is kept."""

    def changed(self) -> Any:
        """Return its state as a value that the journal can restore; None where it is what it was at the last call.

        Called in the thread that ticks: it takes microseconds, or a few milliseconds for what has just moved.
        """

    def restore(self, state: Any) -> None:
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
