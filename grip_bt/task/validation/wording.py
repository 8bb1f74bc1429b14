"""Words that several rules share."""

from __future__ import annotations

from grip_bt.base.types import BUILTINS
from grip_bt.task.catalog import Catalog, Type

_WRITTEN = frozenset({*BUILTINS, "list", "dict", "Any", "None"}) - {"bytes"}
"""Types of which a task file can write a value."""


def has_literals(type_: Type) -> bool:
    """Tell whether a task file can write a value of a type; what it can't is made by nodes."""
    return type_.name in _WRITTEN


def made_by(catalog: Catalog, type_: Type) -> str:
    """Return some of the nodes that give a value of a type, as the end of a sentence; empty when none does."""
    makers = catalog.makers_of(type_)[:2]
    return f", for instance by {' or '.join(makers)}" if makers else ""


def take_hint(hint: str, otherwise: str) -> str:
    """Return a fix: the word that `grip_bt.base.errors.nearest` has found, or `otherwise` when it found none."""
    return f"write {hint.split(chr(39))[1]!r}" if hint else otherwise
