"""The child, unless it ran a short time ago."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Questions, Reason, Run, State, Step


class Cooldown(Decorator):
    """After the child has ended or was halted it isn't run for `seconds`: until then the container fails at once."""

    rank: ClassVar[int] = 120
    sign: ClassVar[str] = "◔"
    icon: ClassVar[str] = "M8 1.500v13M2.400 4.700l11.200 6.600M13.600 4.700L2.400 11.300"
    example: ClassVar[Mapping[str, object]] = {"seconds": 1.0}
    codes: ClassVar[tuple[str, ...]] = ("cooldown",)
    kind: Literal["cooldown"]
    seconds: float = Field(gt=0)

    def begin(self, state: State, q: Questions) -> Step:
        """Run the child where it may run again: `q.kept` says from when on."""
        ready = q.kept
        if ready is None or q.passed(ready):
            return Run((0,), "ran")
        return End("failure", Reason("cooldown", f"{q.names[0]} is cooling down for another {ready - q.now():g} s"))

    def over(self, state: State, q: Questions) -> None:
        if state == "ran":
            q.kept = q.now() + self.seconds

    def settings(self) -> str:
        return f"not again for {self.seconds:g} s"
