"""XML of anybody, read with its lines: without entities, so that nothing expands, and of a bounded depth."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from xml.parsers import expat

from .errors import DocumentError


class MalformedError(DocumentError):
    """A text isn't well-formed XML."""


class XmlElement(ET.Element):
    """An element that knows the 1-based line of its start, which those of `xml.etree` forget."""

    line: int | None = None


def parse_xml(text: bytes | str, source: str = "", deepest: int = 200) -> XmlElement:
    """Return the outermost element of a document.

    Raises:
        MalformedError: it isn't well-formed.
        DocumentError: it declares an entity, or has elements nested deeper; with the line.
    """
    builder, parser, depth = ET.TreeBuilder(element_factory=XmlElement), expat.ParserCreate(), 0

    def refuse(message: str) -> None:
        raise DocumentError(message, source, parser.CurrentLineNumber)

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > deepest:
            refuse(f"elements are nested more than {deepest} deep")
        builder.start(tag, attributes).line = parser.CurrentLineNumber  # type: ignore[attr-defined]

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = start, end, builder.data
    parser.EntityDeclHandler = lambda *_: refuse("it declares an entity; write out what it stands for")
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        said = f"isn't well-formed XML: {expat.errors.messages[error.code]}"
        raise MalformedError(said, source, error.lineno, error.offset + 1) from None
    except (ValueError, LookupError) as error:  # an encoding that expat or Python doesn't know
        raise MalformedError(f"isn't well-formed XML: {error}", source) from None
    return builder.close()  # type: ignore[return-value]
