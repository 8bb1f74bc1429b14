"""Decorators that run their child again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from grip_bt.task.kinds.base import Decorator, End, Ended, Next, Questions, Reason, Run, Step
from grip_bt.task.parts import Name


class Retry(Decorator):
    """The child again, at most `times` times in all, until it succeeds; one attempt a tick."""

    rank: ClassVar[int] = 50
    sign: ClassVar[str] = "↻"
    icon: ClassVar[str] = "M13.5 8a5.5 5.5 0 1 1-2-4.2M11.5 .8v3.200h-3.2"
    example: ClassVar[Mapping[str, Any]] = {"times": 3}
    kind: Literal["retry"]
    times: int = Field(ge=1)

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child; the state is the number of attempts that have failed."""
        return Run((0,), 0 if state is None else state)

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """Count a failure, and try again."""
        if end.meaning == "success":
            return End("success")
        done = q.up(state)
        return End("failure") if q.reached(done, self.times) else Next(done)

    def settings(self) -> str:
        """Return how often it tries."""
        return f"at most {self.times} attempts"


class Repeat(Decorator):
    """The child again, `times` times in all or until it fails; without `times`, for ever. One attempt a tick."""

    rank: ClassVar[int] = 60
    sign: ClassVar[str] = "↻"
    icon: ClassVar[str] = "M13.5 8a5.5 5.5 0 1 1-2-4.2M11.5 .8v3.200h-3.200M8 7.500v1"
    kind: Literal["repeat"]
    times: int | None = Field(default=None, ge=1)

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child; the state is the number of times that it has succeeded."""
        return Run((0,), 0 if state is None else state)

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """Count a success, and run the child again."""
        if end.meaning == "failure":
            return End("failure")
        if self.times is None:
            return Next(0)
        done = q.up(state)
        return End("success") if q.reached(done, self.times) else Next(done)

    def settings(self) -> str:
        """Return how often it repeats."""
        return "for ever" if self.times is None else f"{self.times} times"


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

    def begin(self, state: Any, q: Questions) -> Step:
        """Look at the condition, then at the number of passes, which is the state."""
        if self.while_ and not q.holds("while_"):
            return End("success")
        if self.times is None:
            return Run((0,))
        if state is not None and q.reached(state, self.times):
            return End("failure", Reason("loop_limit", f"it reached the limit of {self.times} passes"))
        return Run((0,), q.up(0 if state is None else state))

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """Another pass, until one fails."""
        return Next(state) if end.meaning == "success" else End("failure")

    def settings(self) -> str:
        """Return the condition and the limit."""
        limit = f"at most {self.times} passes" if self.times else ""
        return ", ".join(part for part in (f"while {self.while_}" if self.while_ else "", limit) if part)


class ForEach(Decorator):
    """The child once for each item of a list, one a tick, until it fails; an empty list runs nothing and succeeds."""

    rank: ClassVar[int] = 100
    sign: ClassVar[str] = "∀"
    icon: ClassVar[str] = "M2 3.500h3M2 8h3M2 12.500h3M7.500 3.500h6.500M7.500 8h6.500M7.500 12.500h6.500"
    example: ClassVar[Mapping[str, Any]] = {"items": "items", "item": "item"}
    reads: ClassVar[tuple[str, ...]] = ("items",)
    puts: ClassVar[tuple[str, ...]] = ("item",)
    kind: Literal["for_each"]
    items: str
    """The variable that holds the list, as it is on entry."""
    item: Name
    """The variable that holds the item for the child; it is this container's own."""

    @model_validator(mode="after")
    def _item_is_new(self) -> ForEach:
        if self.item in self.data:
            raise ValueError(f"`item` declares {self.item!r}; remove it from `data`")
        return self

    def begin(self, state: Any, q: Questions) -> Step:
        """Run the child for the next item; the state is what is left of the list."""
        left = q.items("items") if state is None else state
        if q.empty(left):
            return End("success")
        item, left = q.take(left)
        q.put("item", item)
        return Run((0,), left)

    def ended(self, state: Any, child: int, end: Ended, q: Questions) -> Step:
        """Go on with the next item until one fails."""
        return Next(state) if end.meaning == "success" else End("failure")

    def settings(self) -> str:
        """Return the variables."""
        return f"{self.item} of {self.items}"
