"""Leaves that only steer a task: they wait, count, select, log."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from typing import Any

from py_trees.common import Status

from grip_bt.nodes.leaf import Leaf

_POLL = 0.05
"""How long [s] after a tick that wakes nobody the next one is asked for."""


class Wait(Leaf):
    """Wait for some seconds of the run's clock, without polling."""

    _until: float = 0.0

    def initialise(self) -> None:
        self._until = self.context.clock.now() + self.params["seconds"]
        self.context.wake_at(self._until)

    def resume(self, began: float) -> None:
        self._until = began + self.params["seconds"]
        self.context.wake_at(self._until)

    def update(self) -> Status:
        left = self._until - self.context.clock.now()
        return self.end() if left <= 0 else self.running(f"{left:.1f} s left")


class Succeed(Leaf):
    """Succeed at once."""

    def update(self) -> Status:
        return self.end()


class Fail(Leaf):
    """Fail at once with a reason."""

    def update(self) -> Status:
        return self.fail(self.params["code"], self.params["message"])


class PlayStatuses(Leaf):
    """Answer ticks by a list of statuses."""

    _at = 0

    def prepare(self) -> None:
        """Read the list; ValueError where it is empty, or holds something else than statuses."""
        rows = [each.partition("*") for each in self.params["statuses"]]
        self._list = [word for word, _, count in rows for _ in range(int(count or 1))]
        then = self.params["then"]
        wrong = {*self._list, *([then] if then is not None else [])} - {"running", "success", "failure"}
        if wrong or not (self._list or then):
            raise ValueError(f"statuses are `running`, `success` and `failure`, not {sorted(wrong) or 'none'}")

    def initialise(self) -> None:
        self._at = 0 if self.params["anew"] else self._at

    def update(self) -> Status:
        then: str | None = self.params["then"]
        if self._at >= len(self._list) and then is None:
            self._at = 0
        word = self._list[self._at] if self._at < len(self._list) else str(then)
        self._at += 1
        if word == "running":
            self.context.wake_at(self.context.clock.now() + _POLL)
            return self.running()
        return self.end() if word == "success" else self.fail("played")


class Log(Leaf):
    """Put a sentence into the journal."""

    def update(self) -> Status:
        value = self.read("value")
        text: str = self.params["message"]
        self.feedback_message = text if value is None else f"{text}: {value!r}"
        self.observer.message(self.path, self.feedback_message)
        return self.end()


class Set(Leaf):
    """Give a variable a value."""

    def update(self) -> Status:
        """Write a copy, since the value may be a list that somebody changes."""
        return self.end(value=deepcopy(self.params["value"]))


class Count(Leaf):
    """Count up, and say when the limit is reached."""

    def update(self) -> Status:
        count: int = (self.read("count") or 0) + self.params["step"]
        limit: int | None = self.params["limit"]
        outcome = "reached" if limit is not None and count >= limit else "success"
        return self.end(outcome, count=count)


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
