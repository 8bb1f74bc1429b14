"""Attributes of py_trees' XML: values as text, by the type that is wanted, and the variable that a `{key}` is."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from grip_bt.base.types import Type
from grip_bt.formats.names import node_name
from grip_bt.task.catalog import parse_type

_SIMPLE = ("bool", "int", "float", "str")
_HIDDEN = "__DOT__"
"""What py_trees writes for a dot in a constant; a text that holds it would come back changed."""

_NOT_WRITTEN = re.compile("[{}]|[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Braces would make it a key; the others are no characters of XML."""


def to_text(value: object, type_name: str) -> str:
    """Return the text of a value; a whole number where a float is wanted is written as one, `1.0`.

    Raises:
        ValueError: no text is read as this value.
    """
    value = _as_float(parse_type(type_name), value)
    text = _text_of(value)
    try:
        back = from_text(text, type_name)
    except ValueError:
        back = _text_of
    if back != value or type(back) is not type(value) or _NOT_WRITTEN.search(text) or _HIDDEN in text:
        raise ValueError(f"{value!r} has no text that is read as {type_name}")
    return text


def _as_float(wanted: Type, value: object) -> object:
    if wanted.name == "list" and wanted.item is not None and isinstance(value, list | tuple):
        return [_as_float(wanted.item, item) for item in value]
    if wanted.name == "float" and type(value) is int and abs(value) <= 2**53:
        return float(value)
    return value


def _text_of(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "none"
    if isinstance(value, list | tuple):
        return ", ".join(map(_text_of, value))
    return str(value)


def from_text(text: str, type_name: str) -> object:
    """Return the value that a text is, where a type is wanted.

    Raises:
        ValueError: it isn't one; the message says what is allowed.
    """
    wanted = parse_type(type_name)
    if wanted.optional and text.strip().lower() in ("", "none", "null"):
        return None
    return _value(text, wanted)


def _value(text: str, wanted: Type) -> object:
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


_KEY = re.compile(r"\{([^{}]+)\}")


@dataclass(frozen=True)
class Constant:
    """A value that a sub-tree was given in place of a variable."""

    text: str


@dataclass
class Variables:
    """The variables of a whole file: name -> types that its ports want, who writes it first."""

    types: dict[str, list[str]] = field(default_factory=dict)
    constants: dict[str, tuple[str, object]] = field(default_factory=dict)

    def use(self, name: str, type_name: str, *, written: bool) -> None:
        """Note that a port of this type is bound to a variable; a writer's type counts before a reader's."""
        types = self.types.setdefault(name, [])
        types.insert(0 if written else len(types), type_name)

    def constant(self, name: str, type_name: str, value: object) -> str:
        """Declare a variable for a value that is given to an input port; return its name."""
        number, unique = 2, name
        while unique in self.types or self.constants.get(unique, (type_name, value)) != (type_name, value):
            unique, number = f"{name}_{number}", number + 1
        self.constants[unique] = (type_name, value)
        return unique

    def declared(self) -> dict[str, object]:
        """Return the task's `data`."""
        known: dict[str, object] = {name: types[0] for name, types in self.types.items()}
        return known | {name: {"type": type_, "value": value} for name, (type_, value) in self.constants.items()}


@dataclass
class Names:
    """What keys of a sub-tree mean: variables of the file, or constants; `space`: sub-trees around, outermost first."""

    space: tuple[str, ...] = ()
    given: dict[str, str | Constant] = field(default_factory=dict)

    def meaning(self, text: str) -> str | Constant:
        """Return the variable that an attribute names, or the constant that it is.

        Raises:
            ValueError: braces don't stand around the whole of it.
        """
        found = _KEY.fullmatch(text)
        if found is None:
            if "{" in text or "}" in text:
                raise ValueError(f"{text!r} isn't a key; write {{key}} and nothing else")
            return Constant(text)
        key = found.group(1)
        if key not in self.given:
            self.given[key] = node_name("_".join((*self.space, key)))
        return self.given[key]
