"""What the readers of single elements share: where they are, what they refuse, which numbers they read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NoReturn, TypeVar

from grip_bt.base.errors import ExpressionError
from grip_bt.formats.btcpp.drafts import Board, key_of
from grip_bt.formats.imported import Issues
from grip_bt.formats.xml_trees import Element

from .drafts import SUCCEED, NodeDraft
from .expressions import Scripts

Value = TypeVar("Value")


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


class Refused(Exception):
    """Ends the reading of one element; the refusal is noted already."""


Child = Callable[["ElementReader"], NodeDraft]


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

    def attempt(self, element: Element, where: ReadContext) -> NodeDraft:
        """Read an element; a refusal is noted, and something stands in for it so that the others are found too."""
        self.seen.add(id(element))
        try:
            return self.child(ElementReader(self, element, where))
        except Refused:
            for below in element.children:
                if id(below) not in self.seen:
                    self.attempt(below, where)
            return NodeDraft(dict(SUCCEED), name=element.tag)


@dataclass(frozen=True)
class ElementReader:
    """One element as its reader sees it.

    Attributes:
        reading: of the file.
        element: what is read.
        where: where it stands.
    """

    reading: Reading
    element: Element
    where: ReadContext

    @property
    def attributes(self) -> dict[str, str]:
        """The element's attributes by name."""
        return self.element.attributes

    @property
    def board(self) -> Board:
        """Its blackboard."""
        return self.where.board

    @property
    def meaning(self) -> str:
        """What `skipped` means to the node around."""
        return self.where.meaning

    @property
    def scripts(self) -> Scripts:
        """What reads scripts on its blackboard."""
        return Scripts(self.board, lambda text: self.note("changed", text))

    def refuse(self, why: str) -> NoReturn:
        """Note a refusal, and end the reading of this element.

        Raises:
            Refused: always.
        """
        self.reading.refuse(self.element, why)

    def note(self, code: str, text: str) -> None:
        """Note what to know about it."""
        self.reading.note(code, self.element, text)

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
        where = self.where if meaning is None else replace(self.where, meaning=meaning)
        return [self.reading.attempt(below, where) for below in self.element.children]

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
        self.refuse(f"`{port}` comes from the blackboard ({text}); write the value itself")

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
