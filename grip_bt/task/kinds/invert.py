"""The opposite of the child's end."""

from __future__ import annotations

from typing import ClassVar, Literal

from grip_bt.task.kinds.base import Decorator, End, Ended, Questions, State, Step


class Invert(Decorator):
    """Success becomes failure and failure becomes success."""

    rank: ClassVar[int] = 150
    sign: ClassVar[str] = "!"
    icon: ClassVar[str] = "M2 5.500h12M2 10.500h12M11 2L5 14"
    keeps_codes: ClassVar[bool] = False
    kind: Literal["invert"]

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        """End with the opposite; where it fails there is no reason, since the child succeeded."""
        return End("failure" if end.meaning == "success" else "success")
