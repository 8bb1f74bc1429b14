"""Leaves that only steer a task."""

from __future__ import annotations

from copy import deepcopy

from py_trees.common import Status

from .expressions import ExpressionLeaf
from .leaf import Leaf


class Wait(Leaf):
    """Wait for some seconds of the run's clock, without polling."""

    _until: float = 0.0

    def initialise(self) -> None:
        """Note when to end."""
        self._until = self.context.clock.now() + self.params["seconds"]
        self.context.wake_at(self._until)

    def resume(self, began: float) -> None:
        """Wait for the rest of the time."""
        self._until = began + self.params["seconds"]
        self.context.wake_at(self._until)

    def update(self) -> Status:
        """Look at the clock."""
        left = self._until - self.context.clock.now()
        return self.end() if left <= 0 else self.running(f"{left:.1f} s left")


class Succeed(Leaf):
    """Succeed at once."""

    def update(self) -> Status:
        """Succeed."""
        return self.end()


class Fail(Leaf):
    """Fail at once with a reason."""

    def update(self) -> Status:
        """Fail."""
        return self.fail(self.params["code"], self.params["message"])


class Log(Leaf):
    """Put a sentence into the journal."""

    def update(self) -> Status:
        """Tell the observer."""
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


class Compute(ExpressionLeaf):
    """Give a variable the value of an expression over the inputs."""

    def update(self) -> Status:
        """Compute."""
        return self.end(value=self.compute())
