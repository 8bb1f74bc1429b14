"""Another end than the child's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.task.kinds.base import Decorator, End, Ended, Questions, State, Step
from grip_bt.task.parts import Meaning


class Force(Decorator):
    """Ends with `as`, whatever the child ended with."""

    rank: ClassVar[int] = 160
    sign: ClassVar[str] = "="
    icon: ClassVar[str] = "M2 5.500h12M2 10.500h12"
    example: ClassVar[Mapping[str, object]] = {"as": "success"}
    kind: Literal["force"]
    as_: Meaning = Field(alias="as")

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        return End(self.as_)

    def settings(self) -> str:
        return f"always {self.as_}"
