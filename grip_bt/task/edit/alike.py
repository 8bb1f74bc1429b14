"""Are two tasks equal to the letter, the order of what is in them included?"""

from __future__ import annotations

from math import isfinite
from typing import Any

from pydantic import BaseModel


def alike(one: Any, other: Any) -> bool:
    """Tell whether two parts of tasks are equal: their values, the types of these, and the order of entries.

    `==` of Python takes 1 for True and 1.0, and doesn't look at the order of a mapping. As in JSON, in which edits are
    kept, numbers without an end and those that are none count as null.
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
        return _as_json(one) is None and _as_json(other) is None
    if isinstance(one, BaseModel):
        return _each_alike(vars(one).values(), vars(other).values())
    return bool(one == other) if kind is not float else repr(_as_json(one)) == repr(_as_json(other))


def _as_json(value: Any) -> Any:
    return None if type(value) is float and not isfinite(value) else value


def said_alike(one: Any, other: Any) -> bool:
    """Tell whether two parts that are alike also say and leave out the same keys, and hold the very same numbers."""
    if one is other:
        return True
    if isinstance(one, BaseModel):
        same = one.model_fields_set == other.model_fields_set
        return same and all(said_alike(getattr(one, name), getattr(other, name)) for name in one.model_fields_set)
    if isinstance(one, dict):
        return all(said_alike(value, other[key]) for key, value in one.items())
    if isinstance(one, list | tuple):
        return all(map(said_alike, one, other))
    return type(one) is type(other) and (type(one) is not float or repr(one) == repr(other))


def _each_alike(some: Any, others: Any) -> bool:
    for one, other in zip(some, others, strict=True):
        if one is not other and not alike(one, other):
            return False
    return True
