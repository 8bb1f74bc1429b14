"""The child again until it fails."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Ended, Next, Questions, Run, State, Step


class Repeat(Decorator):
    """The child again, `times` times in all or until it fails; without `times`, for ever. One attempt a tick."""

    rank: ClassVar[int] = 60
    sign: ClassVar[str] = "↻"
    icon: ClassVar[str] = "M13.5 8a5.5 5.5 0 1 1-2-4.2M11.5 .8v3.200h-3.200M8 7.500v1"
    kind: Literal["repeat"]
    times: int | None = Field(default=None, ge=1)

    def begin(self, state: State, q: Questions) -> Step:
        """Run the child; the state is the number of times that it has succeeded."""
        return Run((0,), 0 if state is None else state)

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        if end.meaning == "failure":
            return End("failure")
        if self.times is None:
            return Next(0)
        done = q.up(state)
        return End("success") if q.reached(done, self.times) else Next(done)

    def settings(self) -> str:
        return "for ever" if self.times is None else f"{self.times} times"
