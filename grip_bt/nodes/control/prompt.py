"""A switch that looks at its value on every tick, and a parallel that is decided after each child.

Their ticks are their own, so that a plan runs them by these generators; everything else is their base classes'.
"""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError

from ..node import LABEL
from .chooser import Chooser
from .parallel import Parallel, _Rounds


class ReactiveSwitch(Chooser):
    """The child whose case equals the value, on every tick."""

    def tick(self) -> Iterator[Behaviour]:
        """Halt the running child when the value leads elsewhere, then tick as every container that chooses."""
        running = self.current_child
        if self.status == Status.RUNNING and running is not None and self._elsewhere(running):
            running.stop(Status.INVALID)
            self.current_child = None
        yield from super().tick()

    def _elsewhere(self, running: Behaviour) -> bool:
        try:
            return bool(self.rule.choose().child != running.name)
        except Exception as error:
            raise NodeError(self.path, error) from error


class _PromptRounds(_Rounds):
    """How the children are ticked: the rule is read after each that has ended."""

    def tick(self) -> Iterator[Behaviour]:
        """Tick the unfinished children, in order, until it is decided."""
        if self.status != Status.RUNNING:
            for child in self.children:
                if child.status != Status.INVALID:
                    child.stop(Status.INVALID)
            self.current_child = None
            self.initialise()
        status = Status.RUNNING if self.children else self.settle()
        for child in self.children:
            if child.status not in LABEL:
                yield from child.tick()
                status = self.settle()
                if status != Status.RUNNING:
                    break
        if status != Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self


class PromptParallel(Parallel, _PromptRounds):
    """Ticks its unfinished children in order, and none after the one that decides."""
