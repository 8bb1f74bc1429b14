"""Leaves that only steer a task."""

from __future__ import annotations

from copy import deepcopy

from py_trees.common import Status

from grip_bt.errors import DataError
from grip_bt.graph.evaluation import Thunk, value_of
from grip_bt.graph.expression import parse_expression

from .leaf import Leaf


class Wait(Leaf):
    """Wait for some seconds of the run's clock, without polling."""

    _until: float = 0.0

    def initialise(self) -> None:
        """Note when to end."""
        self._until = self.context.clock.now() + self.params["seconds"]
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


class Compute(Leaf):
    """Give a variable the value of an expression over the inputs."""

    def prepare(self) -> None:
        """Read the expression.

        Raises:
            ExpressionError: it isn't one.
            DataError: it names something that no variable is bound to.
        """
        expression = parse_expression(self.params["expression"])
        for name in expression.names:
            if name not in self.readers:
                allowed = ", ".join(self.manifest.inputs)
                raise DataError(self.path, name, f"the expression names it, and no variable is bound ({allowed})")
        self._compute = value_of(expression, self._inputs())

    def update(self) -> Status:
        """Compute."""
        return self.end(value=self._compute())

    def _inputs(self) -> dict[str, Thunk]:
        first: dict[str, Thunk] = {"a": lambda: self.read("a"), "b": lambda: self.read("b")}
        first |= {"c": lambda: self.read("c"), "d": lambda: self.read("d"), "e": lambda: self.read("e")}
        return first | {"f": lambda: self.read("f"), "g": lambda: self.read("g"), "h": lambda: self.read("h")}
