"""The small parts of a task document: words and variables."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, model_validator

from grip_bt.base.frozen import FrozenDict

FORMAT_VERSION = 1
FREE_PREFIX = "x-"
"""What free keys begin with; the loader keeps them and never reads them."""

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_ -]*$")]
"""Name of a node, a variable or an outcome: no dot and no slash, since these separate names."""

Meaning = Literal["success", "failure"]
Case = bool | int | float | str | None
"""A literal that a value is compared with."""


class Shape(BaseModel):
    """What every part of a document is: frozen, with the keys that it has and no others."""

    # built on first use: every node's model holds the union of all of them, and few programs need each
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True, defer_build=True)


_FREE_KEYS = "*"
"""What the free keys are called while they are read; no file has such a key."""


class WithFreeKeys(Shape):
    """A task or a node: besides its own keys it may have any that begin with `x-`."""

    x: FrozenDict[str, object] = Field(
        FrozenDict(), alias=_FREE_KEYS, description="free data, preserved and never read"
    )

    @model_validator(mode="before")
    @classmethod
    def _gather_free_keys(cls, data: object) -> object:
        if not isinstance(data, dict) or not any(str(key).startswith(FREE_PREFIX) for key in data):
            return data
        free = {key: value for key, value in data.items() if str(key).startswith(FREE_PREFIX)}
        return {**{key: value for key, value in data.items() if key not in free}, _FREE_KEYS: free}


class Variable(Shape):
    """A variable that nodes below the declaring container may read and write."""

    type: str
    """Name of a value type, a builtin, `list[T]`, `dict[str, T]`, `T | None`, a ROS type or `Any`."""
    value: object = None
    """Initial value; a literal. Absent means that the variable must be written before it is read."""
    doc: str = ""

    @property
    def has_value(self) -> bool:
        """Whether an initial value was given."""
        return "value" in self.model_fields_set


def type_of(declared: Variable | str) -> str:
    """Return the name of a variable's type."""
    return declared if isinstance(declared, str) else declared.type
