"""The child again while a condition holds."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Ended, Next, Questions, Reason, Run, State, Step


class Loop(Decorator):
    """The child again and again, one pass a tick: while a condition holds, until it fails or an exit is taken.

    After `times` passes it fails with the reason `loop_limit`, unless the condition has become false.
    """

    rank: ClassVar[int] = 110
    sign: ClassVar[str] = "↻"
    icon: ClassVar[str] = "M3 7V6a2 2 0 0 1 2-2h7M10 2l2 2-2 2M13 9v1a2 2 0 0 1-2 2H4M6 14l-2-2 2-2"
    codes: ClassVar[tuple[str, ...]] = ("loop_limit",)
    conditions: ClassVar[tuple[str, ...]] = ("while_",)
    kind: Literal["loop"]
    times: int | None = Field(default=None, ge=1)
    while_: str = Field(default="", alias="while")
    """An expression over variables, looked at before each pass."""

    def begin(self, state: State, q: Questions) -> Step:
        """Look at the condition, then at the number of passes, which is the state."""
        if self.while_ and not q.holds("while_"):
            return End("success")
        if self.times is None:
            return Run((0,))
        if state is not None and q.reached(state, self.times):
            return End("failure", Reason("loop_limit", f"it reached the limit of {self.times} passes"))
        return Run((0,), q.up(0 if state is None else state))

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        return Next(state) if end.meaning == "success" else End("failure")

    def settings(self) -> str:
        limit = f"at most {self.times} passes" if self.times else ""
        return ", ".join(part for part in (f"while {self.while_}" if self.while_ else "", limit) if part)
