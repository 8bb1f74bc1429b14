"""The child while a condition holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Questions, Reason, Run, State, Step


class Guard(Decorator):
    """Fails with the reason `guard` when `if` is false; looked at on every tick, before the child."""

    rank: ClassVar[int] = 80
    sign: ClassVar[str] = "⊨"
    icon: ClassVar[str] = "M8 1.500l5.500 2v4.200q0 4.600-5.500 6.800q-5.500-2.200-5.500-6.800V3.500z"
    example: ClassVar[Mapping[str, object]] = {"if": "true"}
    codes: ClassVar[tuple[str, ...]] = ("guard",)
    conditions: ClassVar[tuple[str, ...]] = ("if_",)
    kind: Literal["guard"]
    if_: str = Field(alias="if")
    """An expression over variables."""

    @property
    def reactive(self) -> bool:
        return True

    def begin(self, state: State, q: Questions) -> Step:
        return self.again(state, (), q) or Run((0,))

    def again(self, state: State, running: tuple[int, ...], q: Questions) -> Step | None:
        return None if q.holds("if_") else End("failure", Reason("guard", f"`{self.if_}` is false"))

    def settings(self) -> str:
        return f"only while {self.if_}"
