"""Somebody's own behaviour of py_trees as a node of a task: it keeps its life cycle and gets a path and an outcome."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure

from .container import Container, Face


class _Wrapped(decorators.Decorator):
    """How the behaviour is ticked; what it raises is named."""

    path: str

    def tick(self) -> Iterator[Behaviour]:
        """Tick as py_trees does."""
        try:
            yield from super().tick()
        except Exception as error:
            raise NodeError(self.path, error) from error


class Foreign(Container, _Wrapped):
    """Ends as the behaviour that it holds; when that has failed, its feedback message is the reason."""

    def __init__(self, face: Face, behaviour: Behaviour):
        decorators.Decorator.__init__(self, face.name, behaviour)
        self.take(face)

    def update(self) -> Status:
        """Pass on what the behaviour ended with."""
        return self.decorated.status

    def reason(self) -> Failure | None:
        """Return the behaviour's message."""
        return Failure("foreign", str(self.decorated.feedback_message))
