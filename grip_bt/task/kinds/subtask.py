"""Another task as a node."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, StringConstraints

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import Value
from grip_bt.task.kinds.base import Kind
from grip_bt.task.parts import Meaning, Variable


class Subtask(Kind):
    """Another task file of the project as one node: its inputs and outputs are ports, its outcomes are the node's.

    It has variables of its own: inputs are copied in on entry, outputs are copied out when it ends, never after a halt.
    """

    rank: ClassVar[int] = 140
    sign: ClassVar[str] = "▣"
    icon: ClassVar[str] = "M1.5 2.500h13v11h-13zM4.500 6.500h7v4h-7z"
    kind: Literal["subtask"]
    task: Annotated[str, StringConstraints(min_length=1)]
    """The file, relative to the project's folder, such as `tasks/fetch.yaml`."""
    with_: FrozenDict[str, Value] = Field(default=FrozenDict(), alias="with")
    """Input -> literal."""
    in_: FrozenDict[str, str] = Field(default=FrozenDict(), alias="in")
    """Input -> variable."""
    out: FrozenDict[str, str] = FrozenDict()
    """Output -> variable."""
    meaning: FrozenDict[str, Meaning] = FrozenDict()
    """Outcome -> meaning, where it differs from the file's."""
    data: ClassVar[FrozenDict[str, Variable | str]] = FrozenDict()
    outcomes: ClassVar[FrozenDict[str, Meaning]] = FrozenDict()
    exits: ClassVar[FrozenDict[str, str]] = FrozenDict()

    def all_outcomes(self) -> Mapping[str, Meaning]:
        """Return those that the document gives a meaning; the others stand in the file."""
        return self.meaning

    def settings(self) -> str:
        return self.task

    def lines(self) -> list[str]:
        return [", ".join(f"{name}={value}" for name, value in self.with_.items())] if self.with_ else []
