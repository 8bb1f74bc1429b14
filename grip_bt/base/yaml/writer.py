"""A syntax tree -> text: the layout of task files, and nothing about what tasks mean.

What fits on a line within `WIDTH` columns stands on one line in braces or brackets; what doesn't, or what carries
comments, stands one entry a line. Long text is folded.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from .scalars import STRANGE, is_plain, quoted, write_scalar
from .tree import YamlEntry, YamlList, YamlMapping, YamlScalar, YamlValue, entries_of

WIDTH = 100
_FOLDABLE = re.compile(r"[^\s#&*!|>'\"%@`?:,\[\]{}-]\S*( \S+)+")
_LITERAL_LINE = re.compile(f"[^\x00-\x1f{STRANGE}]*")

_AlwaysBlock = Callable[[YamlValue], bool]


def write(tree: YamlMapping, always_block: _AlwaysBlock, header: list[str] | None = None) -> str:
    """Return the text of a mapping.

    Args:
        always_block: tells which mappings stand one entry a line although they would fit on one.
    """
    lines = [*(header or ()), *_block(tree, 0, always_block)]
    return "\n".join(lines) + "\n"


def _block(value: YamlMapping | YamlList, indent: int, always_block: _AlwaysBlock) -> Iterator[str]:
    space = " " * indent
    for number, entry in enumerate(entries_of(value)):
        before = entry.comments.before
        if number == 0:
            before = before[next((i for i, c in enumerate(before) if c), len(before)) :]
        yield from (space + c if c else "" for c in before)
        yield from _entry(value, entry, indent, always_block)
    yield from (space + c if c else "" for c in value.closing)


def _entry(parent: YamlMapping | YamlList, entry: YamlEntry, indent: int, always_block: _AlwaysBlock) -> list[str]:
    space = " " * indent
    lead = f"{write_scalar(entry.key, flow=True)}:" if isinstance(parent, YamlMapping) else "-"
    beside = f"  {entry.comments.beside}" if entry.comments.beside else ""
    value = entry.value
    if isinstance(value, YamlScalar):
        first, *rest = _text(value.value, indent, len(lead) + 1)
        return [f"{space}{lead} {first}{beside}", *rest]
    flow = None if always_block(value) else in_braces(value)
    if flow is not None and (indent + len(lead) + 1 + len(flow) <= WIDTH or not entries_of(value)):
        return [f"{space}{lead} {flow}{beside}"]
    inner = list(_block(value, indent + 2, always_block))
    if isinstance(parent, YamlList) and not beside and not inner[0].lstrip().startswith("#"):
        return [f"{space}- {inner[0].lstrip()}", *inner[1:]]
    return [f"{space}{lead}{beside}", *inner]


def in_braces(value: YamlValue) -> str | None:
    """Return a value on one line, in braces or brackets; None when it carries comments or can't stand there."""
    if isinstance(value, YamlScalar):
        return write_scalar(value.value, flow=True)
    if value.closing:
        return None
    parts = []
    for entry in entries_of(value):
        inner = None if entry.comments.any() else in_braces(entry.value)
        if inner is None:
            return None
        key = f"{write_scalar(entry.key, flow=True)}: " if isinstance(value, YamlMapping) else ""
        parts.append(key + inner)
    joined = ", ".join(parts)
    return f"{{{joined}}}" if isinstance(value, YamlMapping) else f"[{joined}]"


def _text(value: object, indent: int, used: int) -> list[str]:
    if not isinstance(value, str):
        return [write_scalar(value, flow=False)]
    if "\n" in value:
        return _literal(value, indent + 2) or [quoted(value)]
    one = value if is_plain(value, flow=False) else quoted(value)
    if indent + used + len(one) > WIDTH and _FOLDABLE.fullmatch(value) and _LITERAL_LINE.fullmatch(value):
        return [">-", *_folded(value, indent + 2)]
    return [one]


def _folded(text: str, indent: int) -> Iterator[str]:
    line = " " * indent
    for number, word in enumerate(text.split(" ")):
        if number and len(line) + 1 + len(word) > WIDTH and line.strip():
            yield line
            line = " " * indent + word
        else:
            line += (" " if line.strip() else "") + word
    yield line


def _literal(text: str, indent: int) -> list[str] | None:
    """Return a text of several lines as a `|` block; None where a block would change it."""
    body = text[:-1] if text.endswith("\n") else text
    lines = body.split("\n")
    if not lines[0] or lines[0][0].isspace() or not lines[-1].strip():
        return None
    if not all(_LITERAL_LINE.fullmatch(line) and line == line.rstrip() for line in lines):
        return None
    head = "|" if text.endswith("\n") else "|-"
    return [head, *(" " * indent + line if line else "" for line in lines)]
