"""Are two tasks equal to the letter, the order of what is in them included?"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel


def alike(one: Any, other: Any) -> bool:
    """Tell whether two parts of tasks are equal: their values, the types of these, and the order of entries.

    `==` of Python takes 1 for True and 1.0, and doesn't look at the order of a mapping.
    """
    if one is other:
        return True
    kind = type(one)
    if kind is str:
        return type(other) is str and bool(one == other)
    if isinstance(one, dict):
        if not isinstance(other, dict) or len(one) != len(other):
            return False
        return all(k is m or k == m for k, m in zip(one, other, strict=True)) and _each_alike(
            one.values(), other.values()
        )
    if isinstance(one, list | tuple):
        return isinstance(other, list | tuple) and len(one) == len(other) and _each_alike(one, other)
    if kind is not type(other):
        return False
    if isinstance(one, BaseModel):
        return _each_alike(vars(one).values(), vars(other).values())
    return one == other if kind is not float else repr(one) == repr(other)


def said_alike(one: Any, other: Any) -> bool:
    """Tell whether two parts that are alike also say and leave out the same keys, defaults included."""
    if one is other:
        return True
    if isinstance(one, BaseModel):
        same = one.model_fields_set == other.model_fields_set
        return same and all(said_alike(getattr(one, name), getattr(other, name)) for name in one.model_fields_set)
    if isinstance(one, dict):
        return all(said_alike(value, other[key]) for key, value in one.items())
    return not isinstance(one, list | tuple) or all(map(said_alike, one, other))


def _each_alike(some: Any, others: Any) -> bool:
    for one, other in zip(some, others, strict=True):
        if one is not other and not alike(one, other):
            return False
    return True
