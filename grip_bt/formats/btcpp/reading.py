"""What the readers of single elements share: where they are, what they refuse, which numbers they read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import NoReturn

from grip_bt.base.errors import ExpressionError

from ..pytrees_xml.elements import Element
from .making import SUCCEED, Made
from .names import Board, key_of
from .statements import Scripts

RESERVED = ("name", "ID")
MOST_NODES = 20_000
"""Of one task; sub-trees within sub-trees could make any number of a small file."""


@dataclass(frozen=True)
class Refusal:
    """An element that has no exact equal.

    Attributes:
        source: the file.
        line: where it begins.
        what: the element, as it is called.
        why: what is wrong with it, and what to do.
    """

    source: str
    line: int
    what: str
    why: str

    def __str__(self) -> str:
        return f"{self.source}:{self.line}: {self.what}: {self.why}"


@dataclass(frozen=True)
class Where:
    """Where an element is read.

    Attributes:
        board: its keys.
        source: its file.
        inside: the sub-trees around, the outermost first.
        meaning: what `skipped` means to the node around.
    """

    board: Board
    source: str
    inside: tuple[str, ...]
    meaning: str = "success"

    def as_(self, meaning: str) -> Where:
        """Return the place of a child to whose container `skipped` means this."""
        return replace(self, meaning=meaning)


class Refused(Exception):
    """Ends the reading of one element; the refusal is noted already."""


@dataclass
class Notes:
    """What is found while a file is read.

    Attributes:
        refusals: elements without an equal.
        remarks: (line, text) to know about the rest.
        nodes: how many elements were read.
    """

    refusals: list[Refusal] = field(default_factory=list)
    remarks: dict[str, None] = field(default_factory=dict)
    nodes: int = 0


Child = Callable[[Element, Where], Made]


class Reading:
    """One reading of a file.

    Args:
        child: reads an element below.
    """

    def __init__(self, child: Child):
        self.child = child
        self.notes = Notes()
        self.seen: set[int] = set()

    @contextmanager
    def refusing(self, element: Element, where: Where) -> Iterator[None]:
        """Note what can't be read exactly as a refusal of this element."""
        try:
            yield
        except (ValueError, ExpressionError) as error:
            self.refuse(element, where, str(error))

    def refuse(self, element: Element, where: Where, why: str) -> NoReturn:
        """Note a refusal, and end the reading of this element.

        Raises:
            Refused: always.
        """
        said = element.attributes.get("name") or element.attributes.get("ID")
        what = f"<{element.tag}>" if said is None else f"<{element.tag}> {said!r}"
        refusal = Refusal(where.source, element.line, what, why)
        if refusal not in self.notes.refusals:
            self.notes.refusals.append(refusal)
        raise Refused

    def remark(self, element: Element, where: Where, text: str) -> None:
        """Note what to know about an element."""
        self.notes.remarks[f"{where.source}:{element.line}: <{element.tag}>: {text}"] = None

    def scripts(self, element: Element, where: Where) -> Scripts:
        """Return what reads scripts on this element's blackboard."""
        return Scripts(where.board, lambda text: self.remark(element, where, text))

    def children(self, element: Element, where: Where, least: int = 1, most: int = 10_000) -> list[Made]:
        """Return the children of an element, whose number has to lie within bounds."""
        count = len(element.children)
        if not least <= count <= most:
            wanted = f"{least}" if least == most else f"{least} to {most}" if most < 10_000 else f"at least {least}"
            self.refuse(element, where, f"has {count} children and needs {wanted}")
        return [self.attempt(below, where) for below in element.children]

    def attempt(self, element: Element, where: Where) -> Made:
        """Read an element; a refusal is noted, and something stands in for it so that the others are found too."""
        self.seen.add(id(element))
        try:
            return self.child(element, where)
        except Refused:
            for below in element.children:
                if id(below) not in self.seen:
                    self.attempt(below, where)
            return Made(dict(SUCCEED), name=element.tag)

    def only(self, element: Element, where: Where) -> Made:
        """Return the one child of a decorator."""
        return self.children(element, where, 1, 1)[0]

    def said(self, element: Element, where: Where, port: str, default: str | None = None) -> str:
        """Return a port's literal; a key is as good where its entry holds a literal and is never written."""
        text = element.attributes.get(port, default)
        if text is None:
            self.refuse(element, where, f"needs `{port}`")
        key = key_of(text, port)
        if key is None:
            return text
        entry = where.board.variables.every[where.board.variable(key)]
        if entry.constant:
            return str(entry.initial)
        self.refuse(element, where, f"`{port}` comes from the blackboard ({text}); write the value itself")

    def number(self, element: Element, where: Where, port: str, default: str | None = None) -> int:
        """Return a whole number."""
        text = self.said(element, where, port, default)
        try:
            return int(text)
        except ValueError:
            self.refuse(element, where, f"`{port}` is {text!r} and has to be a whole number")

    def seconds(self, element: Element, where: Where, port: str) -> float:
        """Return a time [s] that is written in milliseconds."""
        milliseconds = self.number(element, where, port)
        if milliseconds < 0:
            self.refuse(element, where, f"`{port}` is {milliseconds} and can't be less than 0")
        return milliseconds / 1000

    def variable(self, wanted: str, where: Where, type_name: str, value: object) -> str:
        """Return a new variable of the task for the state of a node."""
        name = where.board.variables.new(wanted)
        entry = where.board.variables.every[name]
        entry.initial, entry.written = value, [type_name]
        return name


def reads_only(element: Element, allowed: tuple[str, ...]) -> list[str]:
    """Return the attributes that an element's node type doesn't have; those that any node may have begin with `_`."""
    return [a for a in element.attributes if a not in allowed and a not in RESERVED and not a.startswith("_")]
