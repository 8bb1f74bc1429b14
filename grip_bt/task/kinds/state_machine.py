"""One child at a time; each child's `on` says which is next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.kinds.base import Declaring, End, Ended, Next, Node, Questions, Run, State, Step
from grip_bt.task.parts import Meaning, Name


class StateMachine(Declaring):
    """One child at a time; each child's `on` says who is next."""

    rank: ClassVar[int] = 40
    sign: ClassVar[str] = "◎"
    icon: ClassVar[str] = (
        "M5 4.5a2.3 2.3 0 1 1-4.6 0a2.3 2.3 0 1 1 4.6 0zM15.6 11.5a2."
        "3 2.3 0 1 1-4.6 0a2.3 2.3 0 1 1 4.6 0zM5 4.5h8.3v4M11.3 6.6l2 2l2-2"
    )
    example: ClassVar[Mapping[str, object]] = {"initial": "", "outcomes": {"success": "success", "failure": "failure"}}
    by_edges: ClassVar[bool] = True
    kind: Literal["state_machine"]
    initial: str
    outcomes: FrozenDict[Name, Meaning] = Field(min_length=1)
    children: FrozenDict[Name, Node] = Field(min_length=1)
    exits: ClassVar[FrozenDict[str, str]] = FrozenDict()

    @property
    def below(self) -> FrozenDict[Name, Node]:
        return self.children

    def begin(self, state: State, q: Questions) -> Step:
        return Run((q.at(self.initial if state is None else state),))

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        """Go where the end leads; a child's name wins over an outcome that is called the same."""
        target = q.edge(end)
        return Next(target) if target in q.names else End(target)

    def all_outcomes(self) -> Mapping[str, Meaning]:
        return self.outcomes
