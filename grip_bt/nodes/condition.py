"""Conditions: expressions bound to a run's variables; and nodes that look at one before they begin."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure

from .node import Node


@dataclass(frozen=True)
class Condition:
    """An expression that is true or false.

    Attributes:
        watch: has a function called after each write of a variable that it reads.
    """

    text: str
    holds: Callable[[], bool]
    watch: Callable[[Callable[[], None]], None]

    def refusal(self, code: str) -> Failure:
        return Failure(code, f"`{self.text}` is false")


class Conditional(Node):
    """Mixed in before a leaf or container: where the condition is false on entry, it fails without having begun."""

    precondition: Condition

    def tick(self) -> Iterator[Behaviour]:
        if self.status != Status.RUNNING:
            try:
                holds = self.precondition.holds()
            except Exception as error:
                self.begin()
                self.stop(Status.INVALID)
                raise NodeError(self.path, error) from error
            if not holds:
                self.begin()
                self._refuse()
                yield self
                return
        yield from super().tick()

    def _refuse(self) -> None:
        """End without `terminate`, since nothing was initialised."""
        self.outcome, self.failure = "failure", self.precondition.refusal("precondition")
        self.feedback_message = str(self.failure)
        self.status, self.active = Status.FAILURE, False
        self.observer.ended(self.path, self.outcome, self.failure)


def conditional(node: Node, condition: Condition, meaning: Mapping[str, str]) -> None:
    """Give a node, in place, a precondition; `meaning` holds its outcomes, with `failure` among them."""
    node.__class__ = _conditional(type(node))  # type: ignore[arg-type]  # classes can be hashed
    assert isinstance(node, Conditional)
    node.precondition, node.meaning = condition, dict(meaning)


@cache
def _conditional(cls: type[Node]) -> Any:
    return type(cls.__name__, (Conditional, cls), {"__module__": cls.__module__, "__doc__": cls.__doc__})
