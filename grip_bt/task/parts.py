"""The small parts of a task document: words, variables, rules of parallels."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from grip_bt.base.frozen import FrozenDict

FORMAT_VERSION = 1

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_ -]*$")]
"""Name of a node, a variable or an outcome: no dot and no slash, since these separate names."""

Meaning = Literal["success", "failure"]
Case = bool | int | float | str | None
"""A literal that a value is compared with."""


class Shape(BaseModel):
    """What every part of a document is: frozen, with the keys that it has and no others."""

    # built on first use: every node's model holds the union of all of them, and few programs need each
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True, defer_build=True)


class Variable(Shape):
    """A variable that nodes below the declaring container may read and write."""

    type: str
    """Name of a value type, a builtin, `list[T]`, `dict[str, T]`, `T | None`, a ROS type or `Any`."""
    value: Any = None
    """Initial value; a literal. Absent means that the variable must be written before it is read."""
    doc: str = ""

    @property
    def has_value(self) -> bool:
        """Whether an initial value was given."""
        return "value" in self.model_fields_set


class ParallelRule(Shape):
    """A way in which a parallel ends, from how its children have ended; all of its conditions have to hold.

    Without conditions it is for the rest: it holds when everybody whom the parallel waits for has ended.
    """

    when: FrozenDict[Name, str | list[str]] = FrozenDict()
    """Child -> its outcome, or `outcome.code`, or a list of these."""
    at_least: int | None = Field(default=None, ge=1)
    """How many children have ended with the meaning `ends`."""
    ends: Meaning = "success"
    then: str
    """The outcome of the parallel."""


def type_of(declared: Variable | str) -> str:
    """Return the name of a variable's type."""
    return declared if isinstance(declared, str) else declared.type
