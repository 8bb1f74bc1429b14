"""What attributes of the XML dialects hold: values as texts, by the type that is wanted, and keys of a blackboard.

Each sub-tree has a blackboard of its own, made once and kept for the whole run; a key of it is a variable of the task.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from grip_bt.base.types import Type
from grip_bt.formats.names import free
from grip_bt.task.catalog import parse_type

_SIMPLE = ("bool", "int", "float", "str")
_TRUTH = {"true": True, "1": True, "false": False, "0": False}
_UNWRITTEN = re.compile("[\x00-\x1f\ud800-\udfff\ufffe\uffff]")
"""What isn't a character of XML, or comes back from an attribute as a blank."""
_KEY = re.compile(r"\{([^{}]*)\}")
_WRONG = re.compile(r"[^A-Za-z0-9_]+")
_UNSET = object()


def value_of_text(text: str, type_name: str) -> Any:
    """Return the value that a text is; lists are parted by commas or semicolons. Raises ValueError: it isn't one."""
    wanted = parse_type(type_name)
    if wanted.optional and text.strip().lower() in ("null", "none"):
        return None
    return _value(text, wanted)


def _value(text: str, wanted: Type) -> Any:
    if wanted.name == "str" or (wanted.name == "Any" and not text.startswith("json:")):
        return text
    if wanted.name == "list" and wanted.item is not None and wanted.item.name in _SIMPLE and text[:5] != "json:":
        return [_value(part.strip(), wanted.item) for part in re.split("[,;]", text)] if text.strip() else []
    if wanted.name == "bool" and text.strip().lower() in _TRUTH:
        return _TRUTH[text.strip().lower()]
    if wanted.name == "int":
        return int(text)
    if wanted.name == "float" and math.isfinite(number := float(text)):
        return number
    if wanted.name in _SIMPLE:
        raise ValueError(f"{text!r} can't be read as {wanted}")
    return json.loads(text.removeprefix("json:"))


def text_of_value(value: object, type_name: str, as_json: bool = True) -> str:
    """Return the text of a value; a whole number where a float is wanted is written as one, `1.0`.

    Args:
        as_json: whether lists are JSON, and not their items with commas.

    Raises:
        ValueError: no text is read as this value.
    """
    value = _as_float(parse_type(type_name), value)
    text = _text(value, as_json)
    try:
        back = value_of_text(text, type_name)
    except ValueError:
        back = _UNSET
    if back != value or type(back) is not type(value) or key_of(text, "") is not None or _UNWRITTEN.search(text):
        raise ValueError(f"{value!r} has no text that is read as {type_name}")
    return text


def _as_float(wanted: Type, value: object) -> object:
    if wanted.name == "list" and wanted.item is not None and isinstance(value, list | tuple):
        return [_as_float(wanted.item, item) for item in value]
    if wanted.name == "float" and type(value) is int and abs(value) <= 2**53:
        return float(value)
    return value


def _text(value: Any, as_json: bool) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, str | int | float):
        return str(value)
    return f"json:{json.dumps(value)}" if as_json else ", ".join(_text(item, True) for item in value)


def key_of(text: str, port: str) -> str | None:
    """Return the key that an attribute points to; None for a literal. `{=}` is the key of the port's own name."""
    found = _KEY.fullmatch(text.strip())
    return None if found is None else port if found.group(1) == "=" else found.group(1)


@dataclass
class Variable:
    """One blackboard entry: types of what writes and of what reads it, and the text that it holds from the beginning.

    `texts`: texts are written to it, which become what its readers want. `known`: every port that it is bound to says
    whether it is read or written.
    """

    written: list[str] = field(default_factory=list)
    read: list[str] = field(default_factory=list)
    initial: Any = _UNSET
    texts: bool = False
    known: bool = True

    @property
    def constant(self) -> bool:
        """Whether it holds one text for ever."""
        return self.has_initial and not self.written and not self.texts

    @property
    def has_initial(self) -> bool:
        """Whether it holds something from the beginning."""
        return self.initial is not _UNSET

    @property
    def type(self) -> str:
        """The type that all who write it agree on, or else all who read it; `Any` where they don't."""
        for types in (self.written, self.read, ["str"] if self.has_initial or self.texts else []):
            said = {each for each in types if each != "Any"}
            if said == {"int", "float"}:
                return "float"
            if said:
                return said.pop() if len(said) == 1 else "Any"
        return "Any"


@dataclass
class Variables:
    """The variables of a task in the order in which they were met; `before`: what an earlier reading has found out."""

    before: dict[str, Variable] = field(default_factory=dict)
    every: dict[str, Variable] = field(default_factory=dict)
    constants: dict[tuple[str, str, str], str] = field(default_factory=dict)

    def constant(self, wanted: str, type_name: str, text: str) -> str:
        """Return the name of a variable that holds a literal and is never written."""
        said = (wanted, type_name, text)
        if said not in self.constants:
            name = self.constants[said] = self.new(wanted)
            self.every[name].initial, self.every[name].read = text, [type_name]
        return self.constants[said]

    def new(self, wanted: str) -> str:
        """Declare a variable; return its name, which is free."""
        text = _WRONG.sub("_", wanted).strip("_") or "value"
        base = text if re.match(r"[A-Za-z_]", text) else f"v_{text}"
        name = free(base, {*self.every, "true", "false", "null", "None", "True", "False"})
        self.every[name] = self.before.get(name) or Variable()
        return name

    def declared(self, mentioned: Collection[str]) -> tuple[dict[str, object], dict[str, object]]:
        """Return inputs and data of a task that mentions these. Raises ValueError: a text isn't what readers want."""
        inputs, data = dict[str, object](), dict[str, object]()
        for name, entry in self.every.items():
            if name not in mentioned:
                continue  # a literal of a sub-tree that became part of a node
            if entry.has_initial:
                value, kind = entry.initial, entry.type
                if isinstance(value, str):
                    kind = "str" if kind == "Any" else kind
                    try:
                        value = value_of_text(value, kind)
                    except ValueError as error:
                        raise ValueError(f"the entry {name!r} holds {value!r}: {error}") from error
                data[name] = {"type": kind, "value": value}
            elif not entry.known:
                data[name] = {"type": "Any", "value": None}
            else:
                (data if entry.written or entry.texts else inputs)[name] = entry.type
        return inputs, data


class Board:
    """The blackboard of one sub-tree, whose name is its `space`; `auto`: keys that aren't remapped are the parent's."""

    def __init__(self, variables: Variables, space: str = "", parent: Board | None = None, auto: bool = False):
        self.variables, self.space, self.parent, self.auto = variables, space, parent, auto
        self.names: dict[str, str] = {}

    @property
    def root(self) -> Board:
        """The main tree's board."""
        return self if self.parent is None else self.parent.root

    def variable(self, key: str) -> str:
        """Return the name of a key's variable; `@key` is the main tree's."""
        if key.startswith("@"):
            return self.root.variable(key[1:])
        if key not in self.names:
            if self.auto and self.parent is not None and not key.startswith("_"):
                self.names[key] = self.parent.variable(key)
            else:
                self.names[key] = self.variables.new(f"{self.space}_{key}" if self.space else key)
        return self.names[key]

    def entry(self, key: str) -> Variable:
        """Return what is known of a key's variable."""
        return self.variables.every[self.variable(key)]

    def inner(self, name: str, given: Mapping[str, str], auto: bool = False) -> Board:
        """Return the board of a sub-tree; `given`: its keys -> what they are remapped to, or literals."""
        board = Board(self.variables, name, self, auto)
        for key, text in given.items():
            outer = key_of(text, key)
            if outer is not None:
                board.names[key] = self.variable(outer)
            else:
                board.names[key] = self.variables.new(f"{name}_{key}")
                board.entry(key).initial = text
        return board
