"""Decorators that run their child once: within a time, under a condition, with another end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Ended, Questions, Reason, Run, Stay, Step
from grip_bt.task.parts import Meaning


class Timeout(Decorator):
    """Fails with the reason `time_out` when the child is still running after `seconds` of the run's clock.

    The clock is looked at once a tick, before the child: from the deadline on nothing in it begins or goes on.
    """

    rank: ClassVar[int] = 70
    sign: ClassVar[str] = "◔"
    icon: ClassVar[str] = "M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0zM8 4.500V8l2.5 1.8"
    example: ClassVar[Mapping[str, Any]] = {"seconds": 10.0}
    codes: ClassVar[tuple[str, ...]] = ("time_out",)
    kind: Literal["timeout"]
    seconds: float = Field(gt=0)
    child_first: bool = False
    """The child is ticked before the clock is looked at, as by py_trees: what ends at the deadline has ended."""

    @property
    def reactive(self) -> bool:
        """The clock is looked at before the child, on every tick."""
        return not self.child_first

    @property
    def settles(self) -> bool:
        """Or after it."""
        return self.child_first

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child; the state is the deadline, which isn't reached yet."""
        return Run((0,), q.deadline(self.seconds))

    def again(self, state: Any, running: tuple[int, ...], q: Questions) -> Step | None:
        """Look at the clock before the child."""
        return self._late(q) if q.passed(state) else None

    def settle(self, state: Any, q: Questions) -> Step:
        """Look at the clock after the child."""
        return self._late(q) if q.passed(state) else Stay(state)

    def _late(self, q: Questions) -> Step:
        return End("failure", Reason("time_out", f"{q.names[0]} was still running after {self.seconds:g} s"))

    def settings(self) -> str:
        """Return the limit."""
        return f"at most {self.seconds:g} s"


class Guard(Decorator):
    """Fails with the reason `guard` when `if` is false; looked at on every tick, before the child."""

    rank: ClassVar[int] = 80
    sign: ClassVar[str] = "⊨"
    icon: ClassVar[str] = "M8 1.500l5.500 2v4.200q0 4.600-5.500 6.800q-5.500-2.200-5.500-6.800V3.500z"
    example: ClassVar[Mapping[str, Any]] = {"if": "true"}
    codes: ClassVar[tuple[str, ...]] = ("guard",)
    conditions: ClassVar[tuple[str, ...]] = ("if_",)
    kind: Literal["guard"]
    if_: str = Field(alias="if")
    """An expression over variables."""

    @property
    def reactive(self) -> bool:
        """Always."""
        return True

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child where the condition holds."""
        return self.again(state, (), q) or Run((0,))

    def again(self, state: Any, running: tuple[int, ...], q: Questions) -> Step | None:
        """Look at the condition again."""
        return None if q.holds("if_") else End("failure", Reason("guard", f"`{self.if_}` is false"))

    def settings(self) -> str:
        """Return the condition."""
        return f"only while {self.if_}"


class Cooldown(Decorator):
    """After the child has ended or was halted it isn't run for `seconds`: until then the container fails at once."""

    rank: ClassVar[int] = 120
    sign: ClassVar[str] = "◔"
    icon: ClassVar[str] = "M8 1.500v13M2.400 4.700l11.200 6.600M13.600 4.700L2.400 11.300"
    example: ClassVar[Mapping[str, Any]] = {"seconds": 1.0}
    codes: ClassVar[tuple[str, ...]] = ("cooldown",)
    kind: Literal["cooldown"]
    seconds: float = Field(gt=0)

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child where it may run again: `q.kept` says from when on."""
        ready = q.kept
        if ready is None or q.passed(ready):
            return Run((0,), "ran")
        return End("failure", Reason("cooldown", f"{q.names[0]} is cooling down for another {ready - q.now():g} s"))

    def over(self, state: Any, q: Questions) -> None:
        """Begin to rest, when the child has run."""
        if state == "ran":
            q.kept = q.now() + self.seconds

    def settings(self) -> str:
        """Return the time."""
        return f"not again for {self.seconds:g} s"


class Force(Decorator):
    """Ends with `as`, whatever the child ended with."""

    rank: ClassVar[int] = 160
    sign: ClassVar[str] = "="
    icon: ClassVar[str] = "M2 5.500h12M2 10.500h12"
    example: ClassVar[Mapping[str, Any]] = {"as": "success"}
    kind: Literal["force"]
    as_: Meaning = Field(alias="as")

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """End with `as`."""
        return End(self.as_)

    def settings(self) -> str:
        """Return the end."""
        return f"always {self.as_}"


class Invert(Decorator):
    """Success becomes failure and failure becomes success."""

    rank: ClassVar[int] = 150
    sign: ClassVar[str] = "!"
    icon: ClassVar[str] = "M2 5.500h12M2 10.500h12M11 2L5 14"
    keeps_codes: ClassVar[bool] = False
    kind: Literal["invert"]

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """End with the opposite; where it fails there is no reason, since the child succeeded."""
        return End("failure" if end.meaning == "success" else "success")
