"""A parallel that is decided after each child; its tick is its own, everything else is its base class's."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ..node import LABEL
from .parallel import Parallel, _Rounds


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
