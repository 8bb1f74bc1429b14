"""Values as the text of attributes, the way py_trees reads them: by the type that is wanted."""

from __future__ import annotations

import math
import re
from typing import Any

from grip_bt.base.types import Type
from grip_bt.task.catalog import parse_type

_SIMPLE = ("bool", "int", "float", "str")
_HIDDEN = "__DOT__"
"""What py_trees writes for a dot in a constant; a text that holds it would come back changed."""

_WRONG = re.compile("[{}]|[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Braces would make it a key; the others are no characters of XML."""


def to_text(value: Any, type_name: str) -> str:
    """Return the text of a value; a whole number where a float is wanted is written as one, `1.0`.

    Raises:
        ValueError: no text is read as this value.
    """
    value = _as_float(parse_type(type_name), value)
    text = _text(value)
    try:
        back = from_text(text, type_name)
    except ValueError:
        back = _text
    if back != value or type(back) is not type(value) or _WRONG.search(text) or _HIDDEN in text:
        raise ValueError(f"{value!r} has no text that is read as {type_name}")
    return text


def _as_float(wanted: Type, value: Any) -> Any:
    if wanted.name == "list" and wanted.item is not None and isinstance(value, list | tuple):
        return [_as_float(wanted.item, item) for item in value]
    if wanted.name == "float" and type(value) is int and abs(value) <= 2**53:
        return float(value)
    return value


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "none"
    if isinstance(value, list | tuple):
        return ", ".join(map(_text, value))
    return str(value)


def from_text(text: str, type_name: str) -> Any:
    """Return the value that a text is, where a type is wanted.

    Raises:
        ValueError: it isn't one; the message says what is allowed.
    """
    wanted = parse_type(type_name)
    if wanted.optional and text.strip().lower() in ("", "none", "null"):
        return None
    return _value(text, wanted)


def _value(text: str, wanted: Type) -> Any:
    if wanted.name == "list" and wanted.item is not None and wanted.item.name in _SIMPLE:
        return [_value(part.strip(), wanted.item) for part in re.split("[,;]", text)] if text.strip() else []
    if wanted.name in ("str", "Any"):
        return text
    if wanted.name == "bool" and text.strip().lower() in ("true", "false"):
        return text.strip().lower() == "true"
    if wanted.name in ("int", "float"):
        number = int(text) if wanted.name == "int" else float(text)
        if isinstance(number, int) or math.isfinite(number):
            return number
    raise ValueError(f"{text!r} can't be read as {wanted}")
