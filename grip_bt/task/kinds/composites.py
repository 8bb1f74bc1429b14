"""Composites whose children run one at a time: in order, by a value, in turn, along edges."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.kinds.base import Composite, Declaring, End, Ended, Next, Node, Questions, Reason, Run, Shown, Step
from grip_bt.task.parts import Case, Meaning, Name


class _InOrder(Composite):
    onward: ClassVar[str]
    """The meaning of an end after which the next child is run."""
    memory: bool = True

    @property
    def reactive(self) -> bool:
        """Without memory."""
        return not self.memory

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the first child."""
        return Run((0,)) if q.names else End(self.onward)

    def again(self, state: Any, running: tuple[int, ...], q: Questions) -> Step:
        """Begin with the first child again."""
        return Run((0,))

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """Go on with the next child, or end with the meaning of this one."""
        if end.meaning == self.onward and child + 1 < len(q.names):
            return Run((child + 1,))
        return End(end.meaning)

    def settings(self) -> str:
        """Return whether it is reactive."""
        return "" if self.memory else "asks again on every tick"


class Sequence(_InOrder):
    """Children in order until one fails. With `memory: false` the first child is asked again on every tick."""

    rank: ClassVar[int] = 10
    sign: ClassVar[str] = "→"
    icon: ClassVar[str] = "M1.5 8h12M9.5 4l4 4-4 4"
    shown: ClassVar[Shown] = "sequence"
    resets: ClassVar[bool] = True
    onward: ClassVar[str] = "success"
    kind: Literal["sequence"]


class Fallback(_InOrder):
    """Children in order until one succeeds. With `memory: false` the first child is asked again on every tick."""

    rank: ClassVar[int] = 20
    sign: ClassVar[str] = "?"
    icon: ClassVar[str] = "M5 5.500a3 3 0 1 1 4.3 2.700q-1.3.6-1.3 2M8 12.800v.4"
    shown: ClassVar[Shown] = "selector"
    onward: ClassVar[str] = "failure"
    kind: Literal["fallback"]


class Switch(Composite):
    """The one child whose case equals the value on entry; else `default`, or a failure with the reason `no_case`.

    With `memory: false` the value is looked at on every tick; where it leads to another child, the running one is
    halted first.
    """

    rank: ClassVar[int] = 90
    sign: ClassVar[str] = "⑂"
    icon: ClassVar[str] = "M1.5 8h4l4-4.500h4M5.500 8l4 4.500h4"
    example: ClassVar[Mapping[str, Any]] = {"on_value": "0", "cases": {}}
    codes: ClassVar[tuple[str, ...]] = ("no_case",)
    values: ClassVar[tuple[str, ...]] = ("on_value",)
    kind: Literal["switch"]
    on_value: str
    """An expression over variables."""
    cases: FrozenDict[str, Case | list[Case]]
    """Child -> the literal, or one of the literals, for which it is taken."""
    default: str = ""
    """The child that is taken for every other value."""
    memory: bool = True
    children: FrozenDict[Name, Node] = Field(min_length=1)

    @property
    def reactive(self) -> bool:
        """Without memory."""
        return not self.memory

    def literals(self) -> Iterator[tuple[str, Case]]:
        """Yield each child with each literal for which it is taken, in order."""
        for child, said in self.cases.items():
            for literal in said if isinstance(said, list) else [said]:
                yield child, literal

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child whose literal equals the value."""
        child = q.match("on_value", list(self.literals()), self.default)
        if not child:
            return End("failure", Reason("no_case", f"no case matches {q.value('on_value')!r}"))
        return Run((q.at(child),), 0, True)

    def again(self, state: Any, running: tuple[int, ...], q: Questions) -> Step:
        """Look at the value again."""
        return self.begin(state, q)

    def settings(self) -> str:
        """Return the value."""
        return f"on {self.on_value}"


class RoundRobin(Composite):
    """One child each time it is entered, as that ends: the first one at first, then the next, after the last the first.

    Whose turn it is lasts through a run; a child that was halted has had its turn.
    """

    rank: ClassVar[int] = 95
    sign: ClassVar[str] = "⟳"
    icon: ClassVar[str] = "M2.5 8a5.5 5.5 0 0 1 9.5-3.8M13.5 8a5.5 5.5 0 0 1-9.5 3.8M12 1v3.2h-3.2M4 15v-3.2h3.2"
    kind: Literal["round_robin"]
    children: FrozenDict[Name, Node] = Field(min_length=1)

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child whose turn it is; `q.kept` is the number of turns that there were."""
        turns = 0 if q.kept is None else q.kept
        return Run((q.pick(turns, len(q.names)),), turns)

    def over(self, state: Any, q: Questions) -> None:
        """Count the turn of a child that was run."""
        if state is not None:
            q.kept = q.up(state)


class StateMachine(Declaring):
    """One child at a time; each child's `on` says who is next."""

    rank: ClassVar[int] = 40
    sign: ClassVar[str] = "◎"
    icon: ClassVar[str] = (
        "M5 4.5a2.3 2.3 0 1 1-4.6 0a2.3 2.3 0 1 1 4.6 0zM15.6 11.5a2."
        "3 2.3 0 1 1-4.6 0a2.3 2.3 0 1 1 4.6 0zM5 4.5h8.3v4M11.3 6.6l2 2l2-2"
    )
    example: ClassVar[Mapping[str, Any]] = {"initial": "", "outcomes": {"success": "success", "failure": "failure"}}
    by_edges: ClassVar[bool] = True
    kind: Literal["state_machine"]
    initial: str
    outcomes: FrozenDict[Name, Meaning] = Field(min_length=1)
    children: FrozenDict[Name, Node] = Field(min_length=1)
    exits: ClassVar[FrozenDict[str, str]] = FrozenDict()

    @property
    def below(self) -> FrozenDict[Name, Node]:
        """The children by name."""
        return self.children

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the initial child, or the one to which the last transition leads."""
        return Run((q.at(self.initial if state is None else state),))

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """Go where the end leads; a child's name wins over an outcome that is called the same."""
        target = q.edge(end)
        return Next(target) if target in q.names else End(target)

    def all_outcomes(self) -> Mapping[str, Meaning]:
        """Return the outcomes that it declares, and no others."""
        return self.outcomes
