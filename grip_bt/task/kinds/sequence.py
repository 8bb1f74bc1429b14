"""Children one after the other: until one fails, or until one succeeds."""

from __future__ import annotations

from typing import ClassVar, Literal

from grip_bt.task.kinds.base import Composite, End, Ended, Questions, Run, Shown, State, Step


class _InOrder(Composite):
    onward: ClassVar[str]
    """The meaning of an end after which the next child is run."""
    memory: bool = True

    @property
    def reactive(self) -> bool:
        return not self.memory

    def begin(self, state: State, q: Questions) -> Step:
        return Run((0,)) if q.names else End(self.onward)

    def again(self, state: State, running: tuple[int, ...], q: Questions) -> Step:
        return Run((0,))

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        if end.meaning == self.onward and child + 1 < len(q.names):
            return Run((child + 1,))
        return End(end.meaning)

    def settings(self) -> str:
        return "" if self.memory else "asks again on every tick"


class Sequence(_InOrder):
    """Children in order until one fails. With `memory: false` the first child is asked again on every tick."""

    rank: ClassVar[int] = 10
    sign: ClassVar[str] = "→"
    icon: ClassVar[str] = "M1.5 8h12M9.5 4l4 4-4 4"
    shown: ClassVar[Shown] = "Sequence"
    resets: ClassVar[bool] = True
    onward: ClassVar[str] = "success"
    kind: Literal["sequence"]


class Fallback(_InOrder):
    """Children in order until one succeeds. With `memory: false` the first child is asked again on every tick."""

    rank: ClassVar[int] = 20
    sign: ClassVar[str] = "?"
    icon: ClassVar[str] = "M5 5.500a3 3 0 1 1 4.3 2.700q-1.3.6-1.3 2M8 12.800v.4"
    shown: ClassVar[Shown] = "Selector"
    onward: ClassVar[str] = "failure"
    kind: Literal["fallback"]
