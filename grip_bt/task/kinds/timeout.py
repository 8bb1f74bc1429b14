"""The child for a limited time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Questions, Reason, Run, State, Stay, Step


class Timeout(Decorator):
    """Fails with the reason `time_out` when the child is still running after `seconds` of the run's clock.

    The clock is looked at once a tick, before the child: from the deadline on nothing in it begins or goes on.
    """

    rank: ClassVar[int] = 70
    sign: ClassVar[str] = "◔"
    icon: ClassVar[str] = "M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0zM8 4.500V8l2.5 1.8"
    example: ClassVar[Mapping[str, object]] = {"seconds": 10.0}
    codes: ClassVar[tuple[str, ...]] = ("time_out",)
    kind: Literal["timeout"]
    seconds: float = Field(ge=0)
    """0 only with `child_first`: the child has one tick."""
    child_first: bool = False
    """The child is ticked before the clock is looked at, as by py_trees: what ends at the deadline has ended."""

    @property
    def reactive(self) -> bool:
        return not self.child_first

    @property
    def settles(self) -> bool:
        return self.child_first

    def begin(self, state: State, q: Questions) -> Step:
        """Run the child; the state is the deadline, which isn't reached yet."""
        return Run((0,), q.deadline(self.seconds))

    def again(self, state: State, running: tuple[int, ...], q: Questions) -> Step | None:
        return self._late(q) if q.passed(state) else None

    def settle(self, state: State, q: Questions) -> Step:
        return self._late(q) if q.passed(state) else Stay(state)

    def _late(self, q: Questions) -> Step:
        return End("failure", Reason("time_out", f"{q.names[0]} was still running after {self.seconds:g} s"))

    def settings(self) -> str:
        return f"at most {self.seconds:g} s"
