"""One child an activation, in turn."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.kinds.base import Composite, Node, Questions, Run, State, Step
from grip_bt.task.parts import Name


class RoundRobin(Composite):
    """One child each time it is entered, as that ends: the first one at first, then the next, after the last the first.

    Whose turn it is lasts through a run; a child that was halted has had its turn.
    """

    rank: ClassVar[int] = 95
    sign: ClassVar[str] = "⟳"
    icon: ClassVar[str] = "M2.5 8a5.5 5.5 0 0 1 9.5-3.8M13.5 8a5.5 5.5 0 0 1-9.5 3.8M12 1v3.2h-3.2M4 15v-3.2h3.2"
    kind: Literal["round_robin"]
    children: FrozenDict[Name, Node] = Field(min_length=1)

    def begin(self, state: State, q: Questions) -> Step:
        """Run the child whose turn it is; `q.kept` is the number of turns that there were."""
        turns = 0 if q.kept is None else q.kept
        return Run((q.pick(turns, len(q.names)),), turns)

    def over(self, state: State, q: Questions) -> None:
        if state is not None:
            q.kept = q.up(state)
