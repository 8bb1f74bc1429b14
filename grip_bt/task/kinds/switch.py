"""The child that a value calls for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.kinds.base import Composite, End, Node, Questions, Reason, Run, State, Step
from grip_bt.task.parts import Case, Name


class Switch(Composite):
    """The one child whose case equals the value on entry; else `default`, or a failure with the reason `no_case`.

    With `memory: false` the value is looked at on every tick; where it leads to another child, the running one is
    halted first.
    """

    rank: ClassVar[int] = 90
    sign: ClassVar[str] = "⑂"
    icon: ClassVar[str] = "M1.5 8h4l4-4.500h4M5.500 8l4 4.500h4"
    example: ClassVar[Mapping[str, object]] = {"on_value": "0", "cases": {}}
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
        return not self.memory

    def literals(self) -> Iterator[tuple[str, Case]]:
        """Yield each child with each literal for which it is taken, in order."""
        for child, said in self.cases.items():
            for literal in said if isinstance(said, list) else [said]:
                yield child, literal

    def begin(self, state: State, q: Questions) -> Step:
        child = q.match("on_value", list(self.literals()), self.default)
        if not child:
            return End("failure", Reason("no_case", f"no case matches {q.value('on_value')!r}"))
        return Run((q.at(child),), 0, True)

    def again(self, state: State, running: tuple[int, ...], q: Questions) -> Step:
        return self.begin(state, q)

    def settings(self) -> str:
        return f"on {self.on_value}"
