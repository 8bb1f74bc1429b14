"""YAML text -> a tree that knows where everything stands; only the safe subset that our files are written in.

Refused with line and column: tags, anchors and aliases (so nothing expands), duplicate keys, keys that aren't text,
nesting beyond `MAX_DEPTH`, numbers beyond 64 bits, more than one document. No input exhausts the stack.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml
from yaml import MarkedYAMLError
from yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    DocumentStartEvent,
    Event,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
)

from grip_bt.base.errors import DocumentError

from .scalars import STRANGE, read_plain

MAX_DEPTH = 120
"""Levels of mappings and lists in a file; a container of a task takes two."""
_LONGEST_KEY = 200
_MAX_CHARACTERS = 1_250_000
"""Of a file; some 10,000 nodes with a comment each."""
MAX_VALUES = 100_000
"""Scalars, mappings and lists in a file, keys included; 10,000 nodes with a parameter each take 80,000."""
_BYTE_ORDER_MARK = "\ufeff"
_UNREADABLE = re.compile(f"[\x00-\x08\x0b\x0c\x0e-\x1f{STRANGE}]")
"""Characters that YAML forbids, and ends of lines that only some editors and parsers take for one."""


_Parser = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml where PyYAML was built with it; else slower


@dataclass(slots=True)
class Comments:
    """What a person wrote around an entry; an empty string in `before` is a blank line."""

    before: list[str] = field(default_factory=list)
    beside: str = ""

    def any(self) -> bool:
        """Tell whether there is a comment; blank lines don't count."""
        return bool(self.beside or any(self.before))


@dataclass(slots=True)
class YamlScalar:
    """One value; `line` and `column` are 1-based, `span` are offsets into the text."""

    value: Any
    line: int = 0
    column: int = 0
    span: tuple[int, int] = (0, 0)
    block: bool = False
    """Whether it was written as a `|` or `>` block."""


@dataclass(slots=True)
class YamlEntry:
    """A value in a mapping or (with an empty key) in a list."""

    key: str
    value: YamlValue
    line: int = 0
    column: int = 0
    start: int = 0
    key_end: int = 0
    comments: Comments = field(default_factory=Comments)


@dataclass(slots=True)
class YamlMapping:
    """Entries by key, in order."""

    entries: dict[str, YamlEntry] = field(default_factory=dict)
    line: int = 0
    column: int = 0
    span: tuple[int, int] = (0, 0)
    flow: bool = False
    closing: list[str] = field(default_factory=list)
    """Comments after the last entry."""


@dataclass(slots=True)
class YamlList:
    """Entries of a list."""

    entries: list[YamlEntry] = field(default_factory=list)
    line: int = 0
    column: int = 0
    span: tuple[int, int] = (0, 0)
    flow: bool = False
    closing: list[str] = field(default_factory=list)
    """Comments after the last entry."""


YamlValue = YamlScalar | YamlMapping | YamlList


def entries_of(value: YamlValue) -> list[YamlEntry]:
    """Return the entries of a mapping or a list; none for a scalar."""
    if isinstance(value, YamlMapping):
        return list(value.entries.values())
    return value.entries if isinstance(value, YamlList) else []


def inner(value: YamlValue, step: str | int) -> YamlEntry | None:
    """Return the entry of a mapping at a key, or of a list at an index, which may be a text; None where it isn't."""
    if isinstance(value, YamlMapping):
        return value.entries.get(str(step))
    index = int(step) if str(step).isdecimal() else -1
    return entries_of(value)[index] if 0 <= index < len(entries_of(value)) else None


def to_data(value: YamlValue) -> Any:
    """Return the value as dicts, lists and scalars."""
    if isinstance(value, YamlScalar):
        return value.value
    if isinstance(value, YamlMapping):
        return {key: to_data(entry.value) for key, entry in value.entries.items()}
    return [to_data(entry.value) for entry in value.entries]


def from_data(data: object) -> YamlValue:
    """Return dicts, lists and scalars as a tree without places."""
    if isinstance(data, dict):
        return YamlMapping({str(k): YamlEntry(str(k), from_data(v)) for k, v in data.items()})
    if isinstance(data, list | tuple):
        return YamlList([YamlEntry("", from_data(v)) for v in data])
    return YamlScalar(data)


_BEGINS = "a task begins with `grip: 1`"


def parse(text: str, source: str = "", *, begins: str = _BEGINS) -> YamlValue:
    """Read one YAML document.

    Args:
        begins: what an empty document is told.

    Raises:
        DocumentError: it isn't one, or it uses what our files don't need.
    """
    if len(text) > _MAX_CHARACTERS:
        raise DocumentError(f"larger than {_MAX_CHARACTERS} characters", source)
    unreadable = _UNREADABLE.search(text, text.startswith(_BYTE_ORDER_MARK))
    if unreadable:
        at = unreadable.start()
        line, column = text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)
        message = f"not valid YAML: the character U+{ord(unreadable.group()):04X} isn't allowed; escape it in quotes"
        raise DocumentError(message, source, line, column)
    before = text.startswith(_BYTE_ORDER_MARK)  # the parsers count it or they don't
    builder, parser = _Builder(source, before), _Parser(text[before:])
    try:
        while parser.check_event():
            builder.take(parser.get_event())
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        message = " ".join(part for part in (error.context, error.problem) if part)
        place = (mark.line + 1, mark.column + 1) if mark else (None, None)
        raise DocumentError(f"not valid YAML: {message}", source, *place) from None
    except (ValueError, OverflowError) as error:  # the Python parser's own, of an escape such as "\\UFFFFFFFF"
        raise DocumentError(f"not valid YAML: {error}", source, 1, 1) from None
    if builder.root is None:
        raise DocumentError(f"the file is empty; {begins}", source, 1, 1)
    return builder.root


class _Builder:
    """Takes parser events one by one; `root` is the finished tree."""

    def __init__(self, source: str, shift: int):
        self.source = source
        self.shift = shift
        self.left = MAX_VALUES
        self.root: YamlValue | None = None
        self.open: list[YamlMapping | YamlList] = []
        self.keys: list[YamlScalar | None] = []
        self.documents = 0

    def take(self, event: Event) -> None:
        if isinstance(event, ScalarEvent):
            self._check(event, event.tag if event.tag != "!" or not event.style else None)
            self._add(self._scalar(event))
        elif isinstance(event, CollectionStartEvent):
            self._check(event, event.tag)
            self._begin(YamlMapping() if isinstance(event, MappingStartEvent) else YamlList(), event)
        elif isinstance(event, CollectionEndEvent):
            ended = self.open.pop()
            ended.span = (ended.span[0], event.end_mark.index + self.shift)
            self.keys.pop()
        elif isinstance(event, AliasEvent):
            raise self._error(event, f"YAML aliases (*{event.anchor}) aren't supported; repeat the value")
        elif isinstance(event, DocumentStartEvent):
            if event.version or event.tags:
                raise self._error(event, "YAML directives aren't supported; remove the line")
            self.documents += 1
            if self.documents > 1:
                raise self._error(event, "the file has more than one YAML document")

    def _check(self, event: NodeEvent, tag: str | None) -> None:
        if event.anchor:
            raise self._error(event, f"YAML anchors (&{event.anchor}) aren't supported; remove it")
        if tag:
            raise self._error(event, f"YAML tags ({tag}) aren't supported; remove it")

    def _scalar(self, event: ScalarEvent) -> YamlScalar:
        start, end = event.start_mark, event.end_mark
        try:
            event.value.encode()  # refuses half characters such as "\\ud800"
            value = event.value if event.style else read_plain(event.value)
        except ValueError as error:
            raise self._error(event, str(error)) from None
        block = event.style in ("|", ">")
        return YamlScalar(
            value, start.line + 1, start.column + 1, (start.index + self.shift, end.index + self.shift), block
        )

    def _begin(self, value: YamlMapping | YamlList, event: CollectionStartEvent) -> None:
        mark = event.start_mark
        value.line, value.column = mark.line + 1, mark.column + 1
        value.span, value.flow = (mark.index + self.shift,) * 2, bool(event.flow_style)
        if len(self.open) >= MAX_DEPTH:
            raise self._error(event, f"nested deeper than {MAX_DEPTH} levels")
        self._add(value)
        self.open.append(value)
        self.keys.append(None)

    def _add(self, value: YamlValue) -> None:
        self.left -= 1
        if self.left < 0:
            message = f"the file has more than {MAX_VALUES} values; move parts of it into files of their own"
            raise DocumentError(message, self.source, value.line, value.column)
        if not self.open:
            if isinstance(value, YamlScalar) and value.span[0] == value.span[1]:
                value.line = value.column = 1  # as below: nothing is written
            self.root = value
            return
        parent = self.open[-1]
        if isinstance(parent, YamlList):
            parent.entries.append(YamlEntry("", value, value.line, value.column, value.span[0], value.span[0]))
            return
        key = self.keys[-1]
        if key is None:
            self.keys[-1] = self._key(value, parent)
            return
        if isinstance(value, YamlScalar) and value.span[0] == value.span[1]:
            # nothing is written: where that is, no two parsers agree
            value.line, value.column, value.span = key.line, key.column, (key.span[1], key.span[1])
        parent.entries[key.value] = YamlEntry(key.value, value, key.line, key.column, key.span[0], key.span[1])
        self.keys[-1] = None

    def _key(self, value: YamlValue, parent: YamlMapping) -> YamlScalar:
        place = (self.source, value.line, value.column)
        if not isinstance(value, YamlScalar) or not isinstance(value.value, str):
            shown = repr(value.value) if isinstance(value, YamlScalar) else "a collection"
            raise DocumentError(f"{shown} as a key; keys are text: put it in quotes", *place)
        if len(value.value) > _LONGEST_KEY:
            raise DocumentError(f"a key longer than {_LONGEST_KEY} characters", *place)
        if value.value in parent.entries:
            first = parent.entries[value.value]
            raise DocumentError(f"duplicate key {value.value!r}; it is already defined in line {first.line}", *place)
        return value

    def _error(self, event: Event, message: str) -> DocumentError:
        mark = event.start_mark
        return DocumentError(message, self.source, mark.line + 1, mark.column + 1)


def read_file(path: Path | str) -> str:
    """Return a file's text; DocumentError where there is no such file, or it isn't UTF-8 text of a sensible size."""
    name = str(path)
    if not name:  # of an unset variable of a shell, say; to `Path` it is the folder around
        raise DocumentError("a file's name is needed; this one is empty", "''")
    try:
        with Path(path).open("rb") as file:
            data = file.read(_MAX_CHARACTERS + 1)
    except (FileNotFoundError, IsADirectoryError) as error:
        named = Path(path)
        meant = f"; it leads to {named.readlink()}" if named.is_symlink() else _meant(named)
        raise DocumentError(f"can't be read: {error.strerror}{meant}", name) from None
    except OSError as error:
        raise DocumentError(f"can't be read: {error.strerror or error}", name) from None
    except ValueError as error:
        raise DocumentError(f"can't be read: {error}", name) from None
    if len(data) > _MAX_CHARACTERS:
        raise DocumentError(f"larger than {_MAX_CHARACTERS} bytes; a task file is text", name)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        raise DocumentError(f"not text in UTF-8 (byte 0x{data[error.start]:02x})", name, line, column) from None


def _meant(path: Path) -> str:
    """Return what somebody probably meant who named a folder, or a file that isn't there; empty for no idea."""
    folder = path if path.is_dir() else path.parent
    try:
        there = sorted(str(file) for part in (folder, folder / "tasks") for file in part.glob("*.yaml"))
    except OSError:
        return ""
    there = [file for file in there if _can_be_meant(Path(file))]
    if path.is_dir():
        return f"; name a file in it, such as {there[0]}" if there else ""
    by_name = {Path(file).name: file for file in reversed(there)}
    close = get_close_matches(path.name, by_name, n=1)
    return f"; did you mean {by_name[close[0]]}?" if close else ""


def _can_be_meant(file: Path) -> bool:
    """Return whether a file may be a task, and its name can be put into a sentence."""
    listed = file.name.isprintable() and file.name != "grip.yaml" and not file.name.endswith(".layout.yaml")
    return listed and file.is_file()
