"""Leaves that compute an expression over their inputs, or wait until one is true."""

from __future__ import annotations

from py_trees.common import Status

from grip_bt.base.errors import DataError
from grip_bt.base.evaluation import Evaluator, value_of
from grip_bt.base.expression import parse_expression
from grip_bt.nodes.leaf import Leaf


class _ExpressionLeaf(Leaf):
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
        first: dict[str, Evaluator] = {"a": lambda: self.read("a"), "b": lambda: self.read("b")}
        first |= {"c": lambda: self.read("c"), "d": lambda: self.read("d"), "e": lambda: self.read("e")}
        first |= {"f": lambda: self.read("f"), "g": lambda: self.read("g"), "h": lambda: self.read("h")}
        self._value = value_of(expression, first)


class Compute(_ExpressionLeaf):
    """Give a variable the value of an expression over the inputs."""

    def update(self) -> Status:
        return self.end(value=self._value())


class WaitUntil(_ExpressionLeaf):
    """Wait until an expression over the inputs is true; each write of a variable has it looked at again."""

    _until: float | None = None

    def initialise(self) -> None:
        timeout: float | None = self.params["timeout"]
        self._until = None if timeout is None else self.context.clock.now() + timeout
        if self._until is not None:
            self.context.wake_at(self._until)

    def update(self) -> Status:
        holds = self._value()
        if not isinstance(holds, bool):
            raise TypeError(f"`{self.params['expression']}` evaluates to {holds!r}, not to true or false")
        if holds:
            return self.end()
        if self._until is not None and self.context.clock.now() >= self._until:
            return self.fail("timed_out", f"`{self.params['expression']}` didn't become true")
        return self.running(f"until {self.params['expression']}")
