"""The child once, and its end ever after."""

from __future__ import annotations

from typing import ClassVar, Literal

from grip_bt.task.kinds.base import Decorator, End, Ended, Questions, Reason, Run, State, Step

_SUCCEEDED, _FAILED = 1, 2


class Once(Decorator):
    """When the child has succeeded it isn't run any more in this run: the container succeeds at once."""

    rank: ClassVar[int] = 125
    sign: ClassVar[str] = "①"
    icon: ClassVar[str] = "M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0zM6.500 6l2-1.500v7"
    codes: ClassVar[tuple[str, ...]] = ("once",)
    kind: Literal["once"]
    policy: Literal["success", "any"] = "success"
    """`any`: it isn't run any more after a failure either: the container fails at once then."""

    def begin(self, state: State, q: Questions) -> Step:
        """Run the child, unless it has ended before: `q.kept` says how."""
        if q.kept is None or not q.reached(q.kept, _SUCCEEDED):
            return Run((0,))
        if self.policy == "any" and q.reached(q.kept, _FAILED):
            return End("failure", Reason("once", f"{q.names[0]} has failed before"))
        return End("success", None)

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        if end.meaning == "success":
            q.kept = _SUCCEEDED
        elif self.policy == "any":
            q.kept = _FAILED
        return End(end.meaning)

    def settings(self) -> str:
        return "whatever its end" if self.policy == "any" else "when it has succeeded"
