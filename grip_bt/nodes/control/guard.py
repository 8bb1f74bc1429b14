"""Decorators whose child runs only while a gate is open; the guard's gate is a condition."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure

from .condition import Condition
from .container import Container, Face


class _Gate(decorators.Decorator):
    """How the child is ticked; whether it is, `open` tells."""

    def tick(self) -> Iterator[Behaviour]:
        """Tick the child behind an open gate; halt it and fail behind a closed one."""
        if self.open():
            yield from super().tick()
        else:
            self.stop(Status.FAILURE)
            yield self

    def open(self) -> bool:
        """Tell whether the child may go on."""
        raise NotImplementedError


class Guard(Container, _Gate):
    """Looks at its condition on every tick, before the child; a write to a variable of the condition wakes the run."""

    def __init__(self, face: Face, child: Behaviour, condition: Condition):
        decorators.Decorator.__init__(self, face.name, child)
        self.take(face)
        self.condition, self.closed = condition, False

    def setup(self, **kwargs: Any) -> None:
        """Be told of writes."""
        super().setup(**kwargs)
        self.condition.watch(self._written)

    def open(self) -> bool:
        """Compute the condition."""
        try:
            self.closed = not self.condition.holds()
        except Exception as error:
            raise NodeError(self.path, error) from error
        return not self.closed

    def update(self) -> Status:
        """Pass on what the child ended with."""
        return self.decorated.status

    def reason(self) -> Failure | None:
        """Return `guard`, or the child's reason when it failed by itself."""
        return self.condition.refusal("guard") if self.closed else super().reason()

    def _written(self) -> None:
        if self.active:
            self.context.wake()
