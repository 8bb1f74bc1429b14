"""Children that the code of a node of the project ticks and halts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from operator import and_
from typing import ClassVar, Literal

from pydantic import model_validator

from .base import ChildEnds, Composite, End, Ended, Leaf, Questions, State, Step


class Control(Composite):
    """The first child, a leaf, decides: its code ticks and halts the others, and its end is the container's.

    Status in, status out, as of a control node or a decorator of BehaviorTree.CPP. What the leaf writes with every
    outcome is taken to be written before it ticks anybody.
    """

    rank: ClassVar[int] = 125
    title: ClassVar[str] = "control node"
    sign: ClassVar[str] = "⌥"
    icon: ClassVar[str] = "M3 2.500h10v4H3zM8 6.500v3M3 13.500v-4h10v4M8 9.500v4"
    concurrent: ClassVar[bool] = True
    late_exits: ClassVar[bool] = True
    kind: Literal["control"]

    @model_validator(mode="after")
    def _a_leaf_decides(self) -> Control:
        first = next(iter(self.children.values()), None)
        if not isinstance(first, Leaf):
            raise ValueError("the first child decides over the others, and has to be a leaf")
        return self

    @property
    def reactive(self) -> bool:
        """Always: the leaf is ticked on every tick."""
        return True

    def explorable(self, ends: ChildEnds) -> bool:
        """Tell that only its code knows its ways."""
        return False

    def possible(self, ends: ChildEnds) -> tuple[set[str], int]:
        """Return the ends of the leaf; it may run all others."""
        return {target or end.meaning for end, target in ends[0]}, len(ends)

    def flow(self, ends: ChildEnds, after: Callable[[int, int], Mapping[str, int]], state: int) -> dict[str, int]:
        """Return what the leaf has written; of the others nobody knows who has run."""
        written, found = after(0, state), dict[str, int]()
        for child in range(1, len(ends)):
            after(child, reduce(and_, written.values(), -1))
        for end, target in ends[0]:
            label = target or end.meaning
            found[label] = found.get(label, -1) & written.get(end.outcome, state)
        return found

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        """End as the leaf did; the ends of the others are for its code."""
        return End(q.exit(end) or end.meaning)
