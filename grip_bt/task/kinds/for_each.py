"""The child once for each item of a list."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import model_validator

from grip_bt.task.kinds.base import Decorator, End, Ended, Next, Questions, Run, State, Step
from grip_bt.task.parts import Name


class ForEach(Decorator):
    """The child once for each item of a list, one a tick, until it fails; an empty list runs nothing and succeeds."""

    rank: ClassVar[int] = 100
    sign: ClassVar[str] = "∀"
    icon: ClassVar[str] = "M2 3.500h3M2 8h3M2 12.500h3M7.500 3.500h6.500M7.500 8h6.500M7.500 12.500h6.500"
    example: ClassVar[Mapping[str, object]] = {"items": "items", "item": "item"}
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

    def begin(self, state: State, q: Questions) -> Step:
        """Run the child for the next item; the state is what is left of the list."""
        left = q.items("items") if state is None else state
        if q.empty(left):
            return End("success")
        item, left = q.take(left)
        q.put("item", item)
        return Run((0,), left)

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        return Next(state) if end.meaning == "success" else End("failure")

    def settings(self) -> str:
        return f"{self.item} of {self.items}"
