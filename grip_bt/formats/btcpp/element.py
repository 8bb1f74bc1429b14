"""What the readers of single elements share: where they are, what they refuse, which numbers they read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import NoReturn

from grip_bt.base.errors import ExpressionError
from grip_bt.formats.imported import Issues
from grip_bt.formats.xml_trees import Element

from .blackboard import Board, key_of
from .drafts import SUCCEED, NodeDraft
from .expressions import Scripts

RESERVED = ("name", "ID")


@dataclass(frozen=True)
class ReadContext:
    """Where an element is read.

    Attributes:
        board: its keys.
        inside: the sub-trees around, the outermost first.
        meaning: what `skipped` means to the node around.
    """

    board: Board
    inside: tuple[str, ...]
    meaning: str = "success"

    def as_(self, meaning: str) -> ReadContext:
        """Return the place of a child to whose container `skipped` means this."""
        return replace(self, meaning=meaning)


class Refused(Exception):
    """Ends the reading of one element; the refusal is noted already."""


Child = Callable[[Element, ReadContext], NodeDraft]


class Reading:
    """One reading of a file.

    Args:
        child: reads an element below.

    Attributes:
        issues: what was found.
        nodes: how many elements were read.
    """

    def __init__(self, child: Child):
        self.child = child
        self.issues = Issues()
        self.nodes = 0
        self.seen: set[int] = set()

    @contextmanager
    def refusing(self, element: Element) -> Iterator[None]:
        """Note what can't be read exactly as a refusal of this element."""
        try:
            yield
        except (ValueError, ExpressionError) as error:
            self.refuse(element, str(error))

    def refuse(self, element: Element, why: str) -> NoReturn:
        """Note a refusal, and end the reading of this element.

        Raises:
            Refused: always.
        """
        self.issues.add("no-equivalent", str(element), why, element.source, element.line)
        raise Refused

    def note(self, code: str, element: Element, text: str) -> None:
        """Note what to know about an element."""
        self.issues.add(code, str(element), text, element.source, element.line)

    def scripts(self, element: Element, where: ReadContext) -> Scripts:
        """Return what reads scripts on this element's blackboard."""
        return Scripts(where.board, lambda text: self.note("changed", element, text))

    def children(self, element: Element, where: ReadContext, least: int = 1, most: int = 10_000) -> list[NodeDraft]:
        """Return the children of an element, whose number has to lie within bounds."""
        count = len(element.children)
        if not least <= count <= most:
            wanted = f"{least}" if least == most else f"{least} to {most}" if most < 10_000 else f"at least {least}"
            self.refuse(element, f"has {count} children and needs {wanted}")
        return [self.attempt(below, where) for below in element.children]

    def attempt(self, element: Element, where: ReadContext) -> NodeDraft:
        """Read an element; a refusal is noted, and something stands in for it so that the others are found too."""
        self.seen.add(id(element))
        try:
            return self.child(element, where)
        except Refused:
            for below in element.children:
                if id(below) not in self.seen:
                    self.attempt(below, where)
            return NodeDraft(dict(SUCCEED), name=element.tag)

    def only(self, element: Element, where: ReadContext) -> NodeDraft:
        """Return the one child of a decorator."""
        return self.children(element, where, 1, 1)[0]

    def said(self, element: Element, where: ReadContext, port: str, default: str | None = None) -> str:
        """Return a port's literal; a key is as good where its entry holds a literal and is never written."""
        text = element.attributes.get(port, default)
        if text is None:
            self.refuse(element, f"needs `{port}`")
        key = key_of(text, port)
        if key is None:
            return text
        entry = where.board.variables.every[where.board.variable(key)]
        if entry.constant:
            return str(entry.initial)
        self.refuse(element, f"`{port}` comes from the blackboard ({text}); write the value itself")

    def number(self, element: Element, where: ReadContext, port: str, default: str | None = None) -> int:
        """Return a whole number."""
        text = self.said(element, where, port, default)
        try:
            return int(text)
        except ValueError:
            self.refuse(element, f"`{port}` is {text!r} and has to be a whole number")

    def seconds(self, element: Element, where: ReadContext, port: str) -> float:
        """Return a time [s] that is written in milliseconds."""
        milliseconds = self.number(element, where, port)
        if milliseconds < 0:
            self.refuse(element, f"`{port}` is {milliseconds} and can't be less than 0")
        return milliseconds / 1000

    def variable(self, wanted: str, where: ReadContext, type_name: str, value: object) -> str:
        """Return a new variable of the task for the state of a node."""
        name = where.board.variables.new(wanted)
        entry = where.board.variables.every[name]
        entry.initial, entry.written = value, [type_name]
        return name


def reads_only(element: Element, allowed: tuple[str, ...]) -> list[str]:
    """Return the attributes that an element's node type doesn't have; those that any node may have begin with `_`."""
    return [a for a in element.attributes if a not in allowed and a not in RESERVED and not a.startswith("_")]
