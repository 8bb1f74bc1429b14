"""Somebody's own behaviour of py_trees as a node of a task: it keeps its life cycle and gets a path and an outcome."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure

from .node import Node


class Foreign(Node, decorators.Decorator):
    """Ends as the behaviour that it holds; when that has failed, its feedback message is the reason."""

    def __init__(self, name: str, path: str, meaning: Mapping[str, str], behaviour: Behaviour):
        decorators.Decorator.__init__(self, name, behaviour)
        self.path, self.meaning = path, dict(meaning)

    def tick(self) -> Iterator[Behaviour]:
        """Tick as py_trees does; what the behaviour raises is named."""
        if self.status != Status.RUNNING:
            self.begin()
        try:
            yield from super().tick()
        except Exception as error:
            raise NodeError(self.path, error) from error

    def update(self) -> Status:
        return self.decorated.status

    def conclude(self, status: Status) -> None:
        super().conclude(status)
        message = str(self.decorated.feedback_message)
        self.failure = Failure("foreign", message) if status == Status.FAILURE else None
