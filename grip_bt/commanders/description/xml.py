"""XML files of robots: read with line numbers, without entities, and never so deep that a recursion would end.

`xml.etree` forgets lines; the same expat parser feeds its tree builder here, and each element knows its line.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from xml.parsers import expat

from grip_bt.base.errors import DocumentError, listing

from .files import note

DEEPEST = 200
LARGEST = 64 * 1024 * 1024
"""Bytes; the largest robots have about one million."""


class Element(ET.Element):
    """An element that knows its line.

    Attributes:
        line: 1-based line of its start.
        left_out: of a robot that was expanded, what its files include of packages that aren't here.
    """

    line: int | None = None
    left_out: tuple[str, ...] = ()


def line_of(element: ET.Element) -> int | None:
    """Return the 1-based line on which an element starts, where it was read from a file."""
    return getattr(element, "line", None)


def read_xml(path: Path, root: str) -> Element:
    """Read a file whose outermost element is `root`.

    Raises:
        DocumentError: it isn't there, isn't well-formed, declares entities, or has another root.
    """
    note(path)
    if not path.is_file():
        raise DocumentError("there is no such file", str(path))
    if path.stat().st_size > LARGEST:
        raise DocumentError(f"it has more than {LARGEST // 2**20} MiB: that isn't a robot's description", str(path))
    text = path.read_bytes()
    if (begin := text.find(b"<?xml")) > 0:  # below a licence; ROS's parsers don't mind
        end = text.find(b"?>", begin) + 2
        text = text[:begin] + b" " * (end - begin) + text[end:]
    return parse_xml(text, root, str(path))


def parse_xml(text: bytes | str, root: str, source: str = "") -> Element:
    """Parse a document whose outermost element is `root`; see `read_xml`.

    Raises:
        DocumentError: likewise.
    """
    builder = _Builder(source)
    try:
        element = builder.parse(text if isinstance(text, bytes) else text.encode())
    except expat.ExpatError as error:
        raise DocumentError(
            f"isn't well-formed XML: {expat.errors.messages[error.code]}", source, error.lineno, error.offset + 1
        ) from None
    except (ValueError, LookupError) as error:  # an encoding that expat or Python doesn't know
        raise DocumentError(f"isn't well-formed XML: {error}", source) from None
    if element.tag != root:
        raise DocumentError(f"its outermost element has to be <{root}>, not <{element.tag}>", source, element.line)
    return element


def numbers(element: ET.Element, attribute: str, count: int, default: str, source: str = "") -> tuple[float, ...]:
    """Return an attribute as so many finite numbers.

    Raises:
        DocumentError: it isn't that.
    """
    text = element.get(attribute, default)
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise DocumentError(
            f"{attribute}={text!r} of <{element.tag}> has to be {wanted}", source, line_of(element)
        ) from None
    return values


def required(element: ET.Element, attribute: str, source: str = "") -> str:
    """Return an attribute that mustn't be missing or empty.

    Raises:
        DocumentError: it is.
    """
    value = element.get(attribute, "").strip()
    if not value:
        has = listing(element.keys(), "none at all")
        raise DocumentError(
            f"<{element.tag}> needs the attribute {attribute!r} (it has: {has})", source, line_of(element)
        )
    return value


class _Builder:
    def __init__(self, source: str):
        self.source, self.depth = source, 0
        self.builder = ET.TreeBuilder(element_factory=Element)
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self.builder.data
        self.parser.EntityDeclHandler = self._entity

    def parse(self, text: bytes) -> Element:
        self.parser.Parse(text, True)
        return self.builder.close()  # type: ignore[return-value]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            self._refuse(f"elements are nested more than {DEEPEST} deep")
        element = self.builder.start(tag, attributes)
        element.line = self.parser.CurrentLineNumber  # type: ignore[attr-defined]

    def _end(self, tag: str) -> None:
        self.depth -= 1
        self.builder.end(tag)

    def _entity(self, *_: object) -> None:
        self._refuse("it declares an entity; write out what it stands for")

    def _refuse(self, message: str) -> None:
        raise DocumentError(message, self.source, self.parser.CurrentLineNumber)
