"""YAML text -> a tree that knows where everything stands; only the safe subset that tasks are written in.

Refused with line and column: tags, anchors and aliases (so nothing expands), duplicate keys, keys that aren't text,
nesting beyond `MAX_DEPTH`, numbers beyond 64 bits, more than one document. No input exhausts the stack.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from grip_bt.base.errors import DocumentError

from .scalars import read_plain

MAX_DEPTH = 120
"""Levels of mappings and lists in a file; a container of a task takes two."""
LONGEST_KEY = 200
MAX_CHARACTERS = 1_250_000
"""Of a file; some 10,000 nodes with a comment each."""
MAX_VALUES = 100_000
"""Scalars, mappings and lists in a file, keys included; 10,000 nodes with a parameter each take 80,000."""
PATIENCE = 100_000
"""Characters of a text that is read by the slow parser, which is exact about odd spellings; larger ones are refused."""
PATIENT_VALUES = 15_000
_DIRECTIVE = re.compile(r"([ \t]*(#.*)?\r?\n)*%")
_ODD_PARTS = (
    ("", "[^\n\r -~\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"),
    ("|>", r"[|>][-+0-9]*(#| *(#.*)?\r?\n +\r?\n)"),
    ("'\"", r"['\"]\s*:[^\s]"),
    ("\r", r"\r(?!\n)"),
)
"""What the two parsers don't read alike: tabs, odd ends of lines, and some unusual spellings.

Each with the signs without which it doesn't occur: looking for these first, one thing at a time, is much quicker.
"""
_ODD = tuple((tuple(signs), re.compile(pattern)) for signs, pattern in _ODD_PARTS)


@dataclass(slots=True)
class Comments:
    """What a person wrote around an entry; an empty string in `before` is a blank line."""

    before: list[str] = field(default_factory=list)
    beside: str = ""

    def any(self) -> bool:
        """Tell whether there is a comment; blank lines don't count."""
        return bool(self.beside or any(self.before))


@dataclass(slots=True)
class Scalar:
    """One value; `line` and `column` are 1-based, `span` are offsets into the text."""

    value: Any
    line: int = 0
    column: int = 0
    span: tuple[int, int] = (0, 0)
    block: bool = False
    """Whether it was written as a `|` or `>` block."""


@dataclass(slots=True)
class Entry:
    """A value in a mapping or (with an empty key) in a list."""

    key: str
    value: Value
    line: int = 0
    column: int = 0
    start: int = 0
    key_end: int = 0
    comments: Comments = field(default_factory=Comments)


@dataclass(slots=True)
class Mapping:
    """Entries by key, in order."""

    entries: dict[str, Entry] = field(default_factory=dict)
    line: int = 0
    column: int = 0
    span: tuple[int, int] = (0, 0)
    flow: bool = False
    closing: list[str] = field(default_factory=list)
    """Comments after the last entry."""


@dataclass(slots=True)
class Listing:
    """Entries of a list."""

    entries: list[Entry] = field(default_factory=list)
    line: int = 0
    column: int = 0
    span: tuple[int, int] = (0, 0)
    flow: bool = False
    closing: list[str] = field(default_factory=list)
    """Comments after the last entry."""


Value = Scalar | Mapping | Listing


def entries_of(value: Value) -> list[Entry]:
    """Return the entries of a mapping or a list; none for a scalar."""
    if isinstance(value, Mapping):
        return list(value.entries.values())
    return value.entries if isinstance(value, Listing) else []


def plain(value: Value) -> Any:
    """Return the value as dicts, lists and scalars."""
    if isinstance(value, Scalar):
        return value.value
    if isinstance(value, Mapping):
        return {key: plain(entry.value) for key, entry in value.entries.items()}
    return [plain(entry.value) for entry in value.entries]


def tree_of(data: Any) -> Value:
    """Return dicts, lists and scalars as a tree without places."""
    if isinstance(data, dict):
        return Mapping({str(k): Entry(str(k), tree_of(v)) for k, v in data.items()})
    if isinstance(data, list | tuple):
        return Listing([Entry("", tree_of(v)) for v in data])
    return Scalar(data)


def is_usual(text: str) -> bool:
    """Tell whether libyaml reads a text as YAML 1.2 does, if it reads it at all."""
    return not _DIRECTIVE.match(text) and _first_odd(text) is None


def _first_odd(text: str) -> re.Match[str] | None:
    """Return a place that the two parsers don't read alike."""
    for signs, pattern in _ODD:
        if not signs or any(sign in text for sign in signs):
            found = pattern.search(text)
            if found:
                return found
    return None


_BEGINS = "a task begins with `grip: 1`"


def parse(text: str, source: str = "", *, lists: bool = False, begins: str = _BEGINS) -> Value:
    """Read one YAML document.

    Args:
        text: the document.
        source: what errors call it.
        lists: whether a list is expected too; where it isn't, one is read slowly, if only to be refused.
        begins: what an empty document is told.

    Raises:
        DocumentError: it isn't one, or it uses what tasks don't need.
    """
    if len(text) > MAX_CHARACTERS:
        raise DocumentError(f"larger than {MAX_CHARACTERS} characters", source)
    if is_usual(text):
        root = _quickly(text, source, lists)
        if root is not None:
            return root
    elif len(text) > PATIENCE:
        raise _too_odd(text, source)
    return _patiently(text, source, begins)


def _quickly(text: str, source: str = "", lists: bool = False) -> Value | None:
    """Read by libyaml; None where the patient way is needed, if only to say what is wrong.

    Raises:
        DocumentError: it is wrong, and too large for the patient way.
    """
    try:
        from yaml import YAMLError
        from yaml.cyaml import CParser
    except ImportError:
        return None
    large = len(text) > PATIENCE
    builder = _Builder(source)
    parser = CParser(text)
    try:
        while parser.check_event():
            builder.take(parser.get_event())
    except DocumentError:
        if large:
            raise
        return None
    except (YAMLError, ValueError) as error:
        if not large:
            return None
        marked = hasattr(error, "problem_mark")
        raise (_syntax_error(error, source) if marked else _unreadable(error, text, source)) from None
    expected = (Mapping, Listing) if lists else Mapping
    return builder.root if isinstance(builder.root, expected) or large else None


def _too_odd(text: str, source: str) -> DocumentError:
    found = _first_odd(text) or _DIRECTIVE.match(text)
    assert found is not None, "only odd texts are asked for"
    line, column = _place(text, found.start())
    odd = {"\t": "a tab", "\r": "a carriage return alone"}.get(found.group()[:1], f"the spelling {found.group()[:9]!r}")
    message = (
        f"{odd} is read only in files of up to {PATIENCE} characters, and this has {len(text)}; write it another way"
    )
    return DocumentError(message, source, line, column)


def _place(text: str, at: int) -> tuple[int, int]:
    """Return the 1-based line and column of an offset."""
    return text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)


def _patiently(text: str, source: str, begins: str = _BEGINS) -> Value:
    """Read by a parser in Python: slow, exact in its messages, and of YAML 1.2 in every corner."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    directive = _DIRECTIVE.match(text)
    if directive:
        line = text.count("\n", 0, directive.end()) + 1
        raise DocumentError("a directive: tasks have none; remove the line", source, line, 1)
    builder = _Builder(source, PATIENT_VALUES)
    try:
        for event in _events(YAML(typ="safe", pure=True), text):
            builder.take(event)
    except MarkedYAMLError as error:
        raise _syntax_error(error, source) from None
    except YAMLError as error:
        raise _unreadable(error, text, source) from None
    except DocumentError:
        raise
    except Exception as error:
        # the parser's own trouble with odd input, such as "\\UFFFFFFFF" or a directive
        raise DocumentError(f"not valid YAML: {error}", source, 1, 1) from error
    if builder.root is None:
        raise DocumentError(f"the file is empty; {begins}", source, 1, 1)
    return builder.root


def _events(yaml: Any, text: str) -> Iterator[Any]:
    # not yaml.parse(), which sets up a constructor and leaves the parser alive when a caller stops early
    _, parser = yaml.get_constructor_parser(text)
    try:
        while parser.check_event():
            yield parser.get_event()
    finally:
        parser.dispose()


def _syntax_error(error: Any, source: str) -> DocumentError:
    mark = error.problem_mark or error.context_mark
    message = " ".join(part for part in (error.context, error.problem) if part)
    place = (mark.line + 1, mark.column + 1) if mark else (None, None)
    return DocumentError(f"not valid YAML: {message}", source, *place)


def _unreadable(error: Any, text: str, source: str) -> DocumentError:
    message = f"not valid YAML: {str(error).splitlines()[0]}"
    return DocumentError(message, source, *_place(text, getattr(error, "position", 0)))


class _Builder:
    """Takes parser events one by one; `root` is the finished tree."""

    def __init__(self, source: str, most: int = MAX_VALUES):
        self.source = source
        self.left = self.most = most
        self.root: Value | None = None
        self.open: list[Mapping | Listing] = []
        self.keys: list[Scalar | None] = []
        self.documents = 0

    def take(self, event: Any) -> None:
        match type(event).__name__:
            case "ScalarEvent":
                self._check(event)
                self._add(self._scalar(event))
            case "MappingStartEvent" | "SequenceStartEvent" as name:
                self._check(event)
                self._begin(Mapping() if name.startswith("M") else Listing(), event)
            case "MappingEndEvent" | "SequenceEndEvent":
                ended = self.open.pop()
                ended.span = (ended.span[0], event.end_mark.index)
                self.keys.pop()
            case "AliasEvent":
                raise self._error(event, f"the alias *{event.anchor}: write the value again instead")
            case "DocumentStartEvent":
                self.documents += 1
                if self.documents > 1:
                    raise self._error(event, "a second document; one file holds one")

    def _check(self, event: Any) -> None:
        if event.anchor:
            raise self._error(event, f"the anchor &{event.anchor}: anchors aren't used in tasks")
        tag = getattr(event, "tag", None)
        if tag and not (tag == "!" and getattr(event, "style", None)):
            raise self._error(event, f"the tag {tag}: tags aren't used in tasks")

    def _scalar(self, event: Any) -> Scalar:
        start, end = event.start_mark, event.end_mark
        try:
            event.value.encode()  # refuses half characters such as "\\ud800"
            value = event.value if event.style else read_plain(event.value)
        except ValueError as error:
            raise self._error(event, str(error)) from None
        return Scalar(
            value,
            start.line + 1,
            start.column + 1,
            (start.index, end.index),
            event.style in ("|", ">"),
        )

    def _begin(self, value: Mapping | Listing, event: Any) -> None:
        mark = event.start_mark
        value.line, value.column = mark.line + 1, mark.column + 1
        value.span, value.flow = (mark.index, mark.index), bool(event.flow_style)
        if len(self.open) >= MAX_DEPTH:
            raise self._error(event, f"nested deeper than {MAX_DEPTH} levels")
        self._add(value)
        self.open.append(value)
        self.keys.append(None)

    def _add(self, value: Value) -> None:
        self.left -= 1
        if self.left < 0:
            message = f"more than {self.most} values in a file; let parts of the task be subtasks"
            raise DocumentError(message, self.source, value.line, value.column)
        if not self.open:
            self.root = value
            return
        parent = self.open[-1]
        if isinstance(parent, Listing):
            parent.entries.append(Entry("", value, value.line, value.column, value.span[0], value.span[0]))
            return
        key = self.keys[-1]
        if key is None:
            self.keys[-1] = self._key(value, parent)
            return
        if isinstance(value, Scalar) and value.span[0] == value.span[1]:
            # nothing is written: where that is, no two parsers agree
            value.line, value.column, value.span = key.line, key.column, (key.span[1], key.span[1])
        parent.entries[key.value] = Entry(key.value, value, key.line, key.column, key.span[0], key.span[1])
        self.keys[-1] = None

    def _key(self, value: Value, parent: Mapping) -> Scalar:
        place = (self.source, value.line, value.column)
        if not isinstance(value, Scalar) or not isinstance(value.value, str):
            shown = repr(value.value) if isinstance(value, Scalar) else "a collection"
            raise DocumentError(f"{shown} as a key; keys are text: put it in quotes", *place)
        if len(value.value) > LONGEST_KEY:
            raise DocumentError(f"a key longer than {LONGEST_KEY} characters", *place)
        if value.value in parent.entries:
            first = parent.entries[value.value]
            raise DocumentError(f"the key {value.value!r} again; it stands in line {first.line} too", *place)
        return value

    def _error(self, event: Any, message: str) -> DocumentError:
        mark = event.start_mark
        return DocumentError(message, self.source, mark.line + 1, mark.column + 1)
