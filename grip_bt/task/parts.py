"""The small parts of a task document: words, variables, and where labels lead."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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


def has_value(declared: Variable | str) -> bool:
    """Tell whether a variable has an initial value."""
    return isinstance(declared, Variable) and declared.has_value


Key = tuple[str, str, str | None]


class Edges:
    """A table from a child's end to a target: a sibling's name or one of the container's outcomes.

    Args:
        table: (child, outcome, code) -> target; code None stands for every code and for none.
    """

    def __init__(self, table: Mapping[Key, str] | None = None):
        self.table = dict(table or {})

    @classmethod
    def of_exits(cls, exits: Mapping[str, str]) -> Edges:
        """Read `child.outcome` and `child.outcome.code`."""
        return cls({_key(*label.split(".", 2)): target for label, target in exits.items()})

    @classmethod
    def of_children(cls, on: Mapping[str, Mapping[str, str]]) -> Edges:
        """Read each child's own `outcome` and `outcome.code`."""
        return cls(
            {
                _key(child, *label.split(".", 1)): target
                for child, labels in on.items()
                for label, target in labels.items()
            }
        )

    def target(self, child: str, outcome: str, code: str | None = None) -> str | None:
        """Return where this end leads, or None where no edge leaves."""
        if code is not None:
            found = self.table.get((child, outcome, code))
            if found is not None:
                return found
        return self.table.get((child, outcome, None))

    def codes(self, child: str, outcome: str) -> Iterator[str]:
        """Yield the codes that refine this outcome of the child."""
        return (code for c, o, code in self.table if (c, o) == (child, outcome) and code)

    def __iter__(self) -> Iterator[tuple[Key, str]]:
        return iter(self.table.items())

    def __bool__(self) -> bool:
        return bool(self.table)


def _key(child: str, outcome: str = "", code: str | None = None) -> Key:
    return child, outcome, code
