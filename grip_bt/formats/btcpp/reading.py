"""How an element becomes a node: where it is, what it refuses, its numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NoReturn, TypeVar

from grip_bt.base.errors import ExpressionError
from grip_bt.formats.blackboard import Board, key_of
from grip_bt.formats.btcpp.drafts import SUCCEED, NodeDraft
from grip_bt.formats.imported import Issues
from grip_bt.formats.xml_trees import Element

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
