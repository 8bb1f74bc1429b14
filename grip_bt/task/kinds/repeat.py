"""The child again: until it succeeds, or until it fails."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Ended, Next, Questions, Run, State, Step


class _Again(Decorator):
    final: ClassVar[str]
    """The meaning of an end after which the child isn't run again."""
    times: int | None = Field(default=None, ge=1)

    def begin(self, state: State, q: Questions) -> Step:
        """Run the child; the state is the number of times that it has ended otherwise."""
        return Run((0,), 0 if state is None else state)

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        if end.meaning == self.final:
            return End(self.final)
        if self.times is None:
            return Next(0)
        done = q.up(state)
        return End(end.meaning) if q.reached(done, self.times) else Next(done)


class Retry(_Again):
    """The child again, `times` times in all or until it succeeds; without `times`, for ever. One attempt a tick."""

    rank: ClassVar[int] = 50
    sign: ClassVar[str] = "↻"
    icon: ClassVar[str] = "M13.5 8a5.5 5.5 0 1 1-2-4.2M11.5 .8v3.200h-3.2"
    example: ClassVar[Mapping[str, object]] = {"times": 3}
    final: ClassVar[str] = "success"
    kind: Literal["retry"]

    def settings(self) -> str:
        return "until it succeeds" if self.times is None else f"at most {self.times} attempts"


class Repeat(_Again):
    """The child again, `times` times in all or until it fails; without `times`, for ever. One attempt a tick."""

    rank: ClassVar[int] = 60
    sign: ClassVar[str] = "↻"
    icon: ClassVar[str] = "M13.5 8a5.5 5.5 0 1 1-2-4.2M11.5 .8v3.200h-3.200M8 7.500v1"
    final: ClassVar[str] = "failure"
    kind: Literal["repeat"]

    def settings(self) -> str:
        return "for ever" if self.times is None else f"{self.times} times"
