"""Declared port types as Python types: `list[Grasp]` -> `list[grip_bt.base.values.Grasp]`."""

from __future__ import annotations

from functools import cache
from typing import Any

from grip_bt.base import values
from grip_bt.base.types import BUILTINS, VALUES, Type, parse_type

_KNOWN: dict[str, Any] = {"Any": Any, "None": None, "bool": bool, "int": int, "float": float, "str": str}
_KNOWN |= {"bytes": bytes, **{name: getattr(values, name) for name in VALUES}}
assert set(BUILTINS) <= _KNOWN.keys()


@cache
def python_type(text: str) -> Any:
    """Return the Python type that a declared type names; `Any` for a ROS type, which stays a message.

    Raises:
        ValueError: it isn't a type.
    """
    return _build(parse_type(text))


def _build(declared: Type) -> Any:
    inner = Any if declared.item is None else _build(declared.item)
    if declared.name == "list":
        made: Any = list[inner]  # type: ignore[valid-type]
    elif declared.name == "dict":
        made = dict[str, inner]  # type: ignore[valid-type]
    else:
        made = _KNOWN.get(declared.name, Any)
    return made | None if declared.optional and made is not Any else made
