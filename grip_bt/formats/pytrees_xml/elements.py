"""Reading XML of anybody: no entities, no document types, bounded in size and depth, with lines for messages."""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.parsers import expat

from grip_bt.base.errors import DocumentError

LARGEST, DEEPEST = 4_000_000, 120


@dataclass
class Element:
    """One element.

    Attributes:
        tag: its name.
        attributes: by name, in order.
        line: where it begins, from 1.
        children: its elements; comments are left out.
        text: the characters in it.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def error(self, message: str, source: str) -> DocumentError:
        """Return an error that names this element and its place."""
        name = self.attributes.get("name") or self.attributes.get("ID")
        shown = f"<{self.tag}>" if name is None else f"<{self.tag}> {name!r}"
        return DocumentError(f"{shown}: {message}", source, self.line)


def read_elements(text: str, source: str) -> Element:
    """Return the root element of a document.

    Raises:
        DocumentError: it isn't well-formed, has a document type, or is too large or too deep.
    """
    if len(text) > LARGEST:
        raise DocumentError(f"larger than {LARGEST // 1_000_000} MB", source)
    top = Element("", {}, 0)
    stack = [top]
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > DEEPEST:
            raise DocumentError(f"nested deeper than {DEEPEST} levels", source, parser.CurrentLineNumber)
        element = Element(tag, attributes, parser.CurrentLineNumber)
        stack[-1].children.append(element)
        stack.append(element)

    def end(tag: str) -> None:
        stack.pop()

    def characters(text: str) -> None:
        stack[-1].text += text

    def refuse(*what: object) -> None:
        raise DocumentError("a document type (<!DOCTYPE ...>) isn't read; remove it", source, parser.CurrentLineNumber)

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = refuse
    parser.CharacterDataHandler, parser.buffer_text = characters, True
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        message = f"not well-formed XML: {expat.ErrorString(error.code)}"
        raise DocumentError(message, source, error.lineno, error.offset + 1) from None
    return top.children[0]
