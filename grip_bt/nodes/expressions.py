"""What leaves have in common that compute an expression over their inputs."""

from __future__ import annotations

from typing import Any

from grip_bt.base.errors import DataError
from grip_bt.base.evaluation import Thunk, value_of
from grip_bt.base.expression import parse_expression

from .leaf import Leaf


class ExpressionLeaf(Leaf):
    """A leaf with a parameter `expression`, which names the inputs `a` to `h`."""

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
        self._value = value_of(expression, self._inputs())

    def compute(self) -> Any:
        """Return what the expression comes to now."""
        return self._value()

    def _inputs(self) -> dict[str, Thunk]:
        first: dict[str, Thunk] = {"a": lambda: self.read("a"), "b": lambda: self.read("b")}
        first |= {"c": lambda: self.read("c"), "d": lambda: self.read("d"), "e": lambda: self.read("e")}
        return first | {"f": lambda: self.read("f"), "g": lambda: self.read("g"), "h": lambda: self.read("h")}
