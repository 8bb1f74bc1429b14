"""Leaves that wait for a condition, count, and select."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from py_trees.common import Status

from .expressions import ExpressionLeaf
from .leaf import Leaf


class WaitUntil(ExpressionLeaf):
    """Wait until an expression over the inputs is true; each write of a variable has it looked at again."""

    _until: float | None = None

    def initialise(self) -> None:
        """Note when to give up."""
        timeout: float | None = self.params["timeout"]
        self._until = None if timeout is None else self.context.clock.now() + timeout
        if self._until is not None:
            self.context.wake_at(self._until)

    def update(self) -> Status:
        """Look."""
        holds = self.compute()
        if not isinstance(holds, bool):
            raise TypeError(f"`{self.params['expression']}` comes to {holds!r}, which is neither true nor false")
        if holds:
            return self.end()
        if self._until is not None and self.context.clock.now() >= self._until:
            return self.fail("timed_out", f"`{self.params['expression']}` didn't become true")
        return self.running(f"until {self.params['expression']}")


class Count(Leaf):
    """Count up, and say when the limit is reached."""

    def update(self) -> Status:
        """Add the step to the bound variable."""
        count: int = (self.read("count") or 0) + self.params["step"]
        limit: int | None = self.params["limit"]
        outcome = "reached" if limit is not None and count >= limit else "success"
        outputs = {"count": count}
        return self.end(outcome, **outputs)


class Select(Leaf):
    """Take one item of a list."""

    def update(self) -> Status:
        """Take it; negative numbers count from the end."""
        items: Sequence[Any] = self.read("items")
        bound: int | None = self.read("index")
        index: int = self.params["index"] if bound is None else bound
        if not -len(items) <= index < len(items):
            return self.fail("no_item", f"there is no item {index} among {len(items)}", count=len(items))
        return self.end(item=items[index])
