"""A behaviour of py_trees that the project brings; trees hold it as it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import StringConstraints

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import Value
from grip_bt.task.kinds.base import Kind
from grip_bt.task.parts import Meaning, Variable


class Foreign(Kind):
    """Somebody's own behaviour of py_trees; it ends with `success` or `failure`, and knows no variables."""

    rank: ClassVar[int] = 130
    title: ClassVar[str] = "py_trees behaviour"
    sign: ClassVar[str] = "⇲"
    icon: ClassVar[str] = "M13.500 8.500v5h-11v-11h5M9.500 2.500h4v4M13.500 2.500L7.500 8.500"
    example: ClassVar[Mapping[str, object]] = {"behaviour": "py_trees.behaviours:Success"}
    codes: ClassVar[tuple[str, ...]] = ("foreign",)
    kind: Literal["foreign"]
    behaviour: Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_.]*:[A-Za-z_][A-Za-z0-9_.]*$")]
    """Where it is imported from when the task is compiled: `package.module:Class`, or a function that makes one."""
    args: FrozenDict[str, Value] = FrozenDict()
    """Literal arguments by name."""
    data: ClassVar[FrozenDict[str, Variable | str]] = FrozenDict()
    outcomes: ClassVar[FrozenDict[str, Meaning]] = FrozenDict()
    exits: ClassVar[FrozenDict[str, str]] = FrozenDict()

    def settings(self) -> str:
        """Return where it comes from."""
        return self.behaviour

    def lines(self) -> list[str]:
        """Return its arguments."""
        return [", ".join(f"{name}={value}" for name, value in self.args.items())] if self.args else []
