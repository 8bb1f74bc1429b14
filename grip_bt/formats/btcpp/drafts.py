"""A task under construction, and how an element becomes a node of it: where it is, what it refuses, its numbers.

A node that BT.CPP may skip has the outcome `skipped`. It means success in a sequence and failure in a fallback, so that
both go on to the next child; every other container hands it up by `exits`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NoReturn, TypeVar

from grip_bt.base.errors import ExpressionError
from grip_bt.formats.blackboard import Board, key_of
from grip_bt.formats.imported import Issues
from grip_bt.formats.names import distinct
from grip_bt.formats.xml_trees import Element
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


_TYPES = {"bool": "bool", "double": "float", "float": "float", "string": "str"}
_TYPES |= {"BT::StringView": "str", "string_view": "str"}
_INTEGER = re.compile("((un)?signed )?(int|long|short|char|long int|long long)|unsigned|u?int(8|16|32|64)_t|size_t")


def type_named(cpp: str) -> str:
    """Return the type that a port's C++ type is here; `Any` for every other."""
    text = cpp.strip().removeprefix("const ").rstrip("& ").removeprefix("std::").removeprefix("__cxx11::")
    if _INTEGER.fullmatch(text) and text != "char":
        return "int"
    return _TYPES.get("string" if text.startswith("basic_string") else text, "Any")


Value = TypeVar("Value")


class Refused(Exception):
    """Ends the reading of one element, about which or below which something is said."""

    def __init__(self, why: str, element: Element):
        super().__init__(why)
        self.element = element


class Unequal(Refused):
    """No kind is equal to a node of BehaviorTree.CPP's own; a control node that follows its rules may be there."""


@dataclass
class Reading:
    """One reading of a file: what reads an element, what was found, how many elements were read, and which."""

    child: Callable[[ElementReader], NodeDraft]
    issues: Issues = field(default_factory=Issues)
    nodes: int = 0
    seen: set[int] = field(default_factory=set)


@dataclass(frozen=True)
class ElementReader:
    """One element as its reader sees it; `meaning`: of `skipped` around it; `again`: what asks it on every tick."""

    reading: Reading
    element: Element
    board: Board
    inside: tuple[str, ...]
    meaning: str = "success"
    again: Element | None = None
    read: list[NodeDraft] = field(default_factory=list, compare=False)

    @property
    def attributes(self) -> dict[str, str]:
        """The element's attributes by name."""
        return self.element.attributes

    def attempt(self) -> NodeDraft:
        """Read it; a refusal is noted, and something stands in for it so that the others are found too."""
        self.reading.seen.add(id(self.element))
        try:
            return self.reading.child(self)
        except Refused as refused:
            self.note("no-equivalent", str(refused), refused.element)
            for below in self.element.children:
                if id(below) not in self.reading.seen:
                    self.at(below).attempt()
            return NodeDraft(dict(SUCCEED), name=self.element.tag)

    def at(self, element: Element, **more: Any) -> ElementReader:
        """Return the reader of another element in the same place."""
        return replace(self, element=element, read=[], **more)

    def refuse(self, why: str) -> NoReturn:
        """Refuse this element, and end the reading of it."""
        raise Refused(why, self.element)

    def unequal(self, why: str) -> NoReturn:
        """Say that no kind is equal to this element."""
        raise Unequal(why, self.element)

    def note(self, code: str, text: str, element: Element | None = None) -> None:
        """Note what to know about it, or about one below."""
        found = element or self.element
        self.reading.issues.add(code, str(found), text, found.source, found.line)

    def exact(self, read: Callable[[], Value]) -> Value:
        """Return what is read; what can't be read exactly is a refusal of this element."""
        try:
            return read()
        except (ValueError, ExpressionError) as error:
            self.refuse(str(error))

    def children(self, least: int = 1, most: int = 10_000, meaning: str | None = None) -> list[NodeDraft]:
        """Return the children, whose number has to lie within bounds; `meaning` is that of `skipped` to this node."""
        count = len(self.element.children)
        if not least <= count <= most:
            wanted = f"{least}" if least == most else f"{least} to {most}" if most < 10_000 else f"at least {least}"
            self.refuse(f"has {count} children and needs {wanted}")
        more = {} if meaning is None else {"meaning": meaning}
        self.read[:] = [self.at(below, **more).attempt() for below in self.element.children]
        return list(self.read)

    def only(self) -> NodeDraft:
        """Return the one child of a decorator."""
        return self.children(1, 1)[0]

    def literal(self, port: str, default: str | None = None) -> str:
        """Return a port's literal; a key is as good where its entry holds a literal and is never written."""
        text = self.attributes.get(port, default)
        if text is None:
            self.refuse(f"needs `{port}`")
        key = key_of(text, port)
        if key is None:
            return text
        entry = self.board.variables.every[self.board.variable(key)]
        if entry.constant:
            return str(entry.initial)
        self.unequal(f"`{port}` comes from the blackboard ({text}); write the value itself")

    def number(self, port: str, default: str | None = None) -> int:
        """Return a whole number."""
        text = self.literal(port, default)
        try:
            return int(text)
        except ValueError:
            self.refuse(f"`{port}` is {text!r} and has to be a whole number")

    def seconds(self, port: str) -> float:
        """Return a time [s] that is written in milliseconds."""
        milliseconds = self.number(port)
        if milliseconds < 0:
            self.refuse(f"`{port}` is {milliseconds} and can't be less than 0")
        return milliseconds / 1000

    def variable(self, wanted: str, type_name: str, value: object) -> str:
        """Return a new variable of the task for the state of a node."""
        name = self.board.variables.new(wanted)
        entry = self.board.variables.every[name]
        entry.initial, entry.written = value, [type_name]
        return name
