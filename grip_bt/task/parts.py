"""The small parts of a task document: words and variables."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, StringConstraints

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


def type_of(declared: Variable | str) -> str:
    """Return the name of a variable's type."""
    return declared if isinstance(declared, str) else declared.type
