"""A behaviour of py_trees that the project brings; trees hold it as it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, StringConstraints

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import Value
from grip_bt.task.kinds.base import ChildEnds, Kind, Node
from grip_bt.task.parts import Meaning, Name, Variable

ImportPath = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_.]*:[A-Za-z_][A-Za-z0-9_.]*$")]


class Foreign(Kind):
    """Somebody's own behaviour of py_trees; it ends with `success` or `failure`.

    A decorator or composite has children, which it ticks as it likes. What behaviours have on py_trees' blackboard is
    in variables where `in` and `out` say so.
    """

    rank: ClassVar[int] = 130
    title: ClassVar[str] = "py_trees behaviour"
    sign: ClassVar[str] = "⇲"
    icon: ClassVar[str] = "M13.500 8.500v5h-11v-11h5M9.500 2.500h4v4M13.500 2.500L7.500 8.500"
    example: ClassVar[Mapping[str, object]] = {"behaviour": "py_trees.behaviours:Success"}
    codes: ClassVar[tuple[str, ...]] = ("foreign",)
    kind: Literal["foreign"]
    behaviour: ImportPath
    """Where it is imported from when the task is compiled: `package.module:Class`, or a function that makes one."""
    args: FrozenDict[str, Value] = FrozenDict()
    """Literal arguments by name."""
    built_by: ImportPath | Literal[""] = ""
    """A function, `package.module:name`, that builds the tree in which it is found at `at`, or a program that ticks it,
    `package.module:__main__`; it isn't made of `args`."""
    at: str = ""
    """Its path in that tree, `/` for the root."""
    in_: FrozenDict[str, str] = Field(default=FrozenDict(), alias="in")
    """Key of the blackboard -> variable whose value it has before the behaviour is ticked."""
    out: FrozenDict[str, str] = FrozenDict()
    """Key of the blackboard -> variable that gets its value when the behaviour was ticked."""
    children: FrozenDict[Name, Node] = FrozenDict()
    data: ClassVar[FrozenDict[str, Variable | str]] = FrozenDict()
    outcomes: ClassVar[FrozenDict[str, Meaning]] = FrozenDict()
    exits: ClassVar[FrozenDict[str, str]] = FrozenDict()

    @property
    def below(self) -> FrozenDict[Name, Node]:
        return self.children

    @property
    def imported(self) -> str:
        """What is imported: the function that builds the tree, or the behaviour itself."""
        return self.built_by or self.behaviour

    def explorable(self, ends: ChildEnds) -> bool:
        """Tell that nobody knows what it does with its children."""
        return False

    def possible(self, ends: ChildEnds) -> tuple[set[str], int]:
        """Return both ends; any child may be run."""
        return {"success", "failure"}, len(ends)

    def flow(self, ends: ChildEnds, after: Callable[[int, int], Mapping[str, int]], state: int) -> dict[str, int]:
        """Return what was written before: a child may not be run."""
        for i in range(len(ends)):
            after(i, state)
        return {"success": state, "failure": state}

    def settings(self) -> str:
        return self.behaviour

    def lines(self) -> list[str]:
        found = [", ".join(f"{name}={value}" for name, value in self.args.items())]
        found += [f"{way} {', '.join(keys)}" for way, keys in (("reads", self.in_), ("writes", self.out)) if keys]
        return [line for line in found if line]
