"""A task under construction: its nodes, what SKIPPED becomes, and which variable a blackboard key is.

A node that BT.CPP may skip has the outcome `skipped`. It means success in a sequence and failure in a fallback, so that
both go on to the next child; every other container hands it up by `exits`. Each sub-tree has a blackboard of its own,
made once and kept for the whole run.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from grip_bt.formats.names import distinct, free
from grip_bt.task.catalog import Catalog

Keys = dict[str, Any]
SKIPPED = "skipped"
SUCCEED: Keys = {"node": "flow/succeed"}
FAIL: Keys = {"node": "flow/fail"}


@dataclass
class NodeDraft:
    """A node; `skips`: it has the outcome `skipped`, or what `label` calls it; `instant`: it ends in its first tick."""

    keys: Keys
    skips: bool = False
    name: str = ""
    instant: bool = False
    label: str = SKIPPED

    @property
    def can_fail(self) -> bool:
        """Whether it has the outcome `failure`."""
        return self.may("failure")

    def may(self, outcome: str) -> bool:
        """Tell whether it has an outcome of BT.CPP's: each does but for some leaves of GRIP's own."""
        node = str(self.keys.get("node", ""))
        return (outcome == "failure" and "precondition" in self.keys) or outcome not in _lacking(node)


@cache
def _lacking(node: str) -> frozenset[str]:
    builtin = Catalog.builtin()
    return frozenset({"success", "failure"} - builtin.get(node).outcomes.keys() if node in builtin else ())


def _handing_up(keys: Keys, children: Mapping[str, NodeDraft], meaning: str) -> NodeDraft:
    ends = [f"{name}.{child.label}" for name, child in children.items() if child.skips and meaning]
    if ends:
        keys |= {"outcomes": {SKIPPED: meaning}, "exits": dict.fromkeys(ends, SKIPPED)}
    return NodeDraft(keys, bool(ends), instant=all(child.instant for child in children.values()))


def decorator(kind: str, child: NodeDraft, meaning: str, **more: Any) -> NodeDraft:
    """Return a decorator that hands up `skipped`."""
    name = distinct([child.name])[0]
    made = _handing_up({"kind": kind, **more, "child": {name: child.keys}}, {name: child}, meaning)
    made.name = child.name
    return made


def container(kind: str, children: Mapping[str, NodeDraft], meaning: str = "", **more: Any) -> NodeDraft:
    """Return a composite that hands up `skipped`, which means `meaning`; without one its children's own counts."""
    keys = {"kind": kind, **more, "children": {name: child.keys for name, child in children.items()}}
    return _handing_up(keys, children, meaning)


def controlled(decider: NodeDraft, children: list[NodeDraft], meaning: str) -> NodeDraft:
    """Return a control node; the leaf that decides is skipped where a child may be, or where it may be anyway."""
    parts = [NodeDraft(child.keys, False, child.name) for child in children]
    skips = decider.skips or any(child.skips for child in children)
    decides = NodeDraft(decider.keys, skips, "decide")
    return container("control", named([decides, *parts]), meaning or "success")


def failing(name: str, child: NodeDraft) -> NodeDraft:
    """Return a node that fails when its child has ended."""
    return NodeDraft({"kind": "force", "as": "failure", "child": {name: child.keys}}, instant=child.instant)


def named(children: list[NodeDraft]) -> dict[str, NodeDraft]:
    """Return siblings by names that a task may have."""
    return dict(zip(distinct([child.name for child in children]), children, strict=True))


def switch(
    on_value: str, cases: Mapping[str, object], children: Mapping[str, NodeDraft], meaning: str, **more: object
) -> NodeDraft:
    """Return a switch that hands up `skipped` of every child that has it."""
    return container("switch", children, meaning, on_value=on_value, cases=dict(cases), **more)


def skip() -> NodeDraft:
    """Return a node whose success is the container's being skipped."""
    return NodeDraft(dict(SUCCEED), True, "skip", True, "success")


def set_variable(variable: str, value: object) -> NodeDraft:
    """Return a node that gives a variable a literal value."""
    return NodeDraft(
        {"node": "flow/set", "with": {"value": value}, "out": {"value": variable}}, name=f"set {variable}", instant=True
    )


def sequence_of(children: list[NodeDraft], name: str) -> NodeDraft:
    """Return nodes one after the other; one needs no sequence."""
    if len(children) == 1:
        return children[0]
    made = container("sequence", named(children))
    made.name = name
    return made


_WRONG = re.compile(r"[^A-Za-z0-9_]+")
_KEY = re.compile(r"\{([^{}]*)\}")
_UNSET = object()
_INTEGERS = (
    *("int", "unsigned", "unsigned int", "long", "short", "int8_t", "int16_t", "int32_t", "int64_t", "uint8_t"),
    *("uint16_t", "uint32_t", "uint64_t", "size_t", "unsigned short", "unsigned long", "long long", "unsigned char"),
    "signed char",
)
_TYPES = {
    **dict.fromkeys(_INTEGERS, "int"),
    **dict.fromkeys(("double", "float"), "float"),
    "bool": "bool",
    **dict.fromkeys(("string", "std::string", "BT::StringView", "std::string_view"), "str"),
}


def type_named(cpp: str) -> str:
    """Return the type that a port's C++ type is here; `Any` for every other."""
    text = cpp.strip().removeprefix("const ").rstrip("& ").removeprefix("std::__cxx11::")
    text = "std::string" if text.startswith(("basic_string", "std::basic_string")) else text
    text = text if text in _TYPES else text.removeprefix("std::")
    return _TYPES.get(text, "Any")


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
