"""Tidy YAML text -> dicts, lists and scalars, by one regular expression a line: the quickest way into a usual text.

Tidy is what people and our formatter write: mappings by indentation, with plain, quoted, `|` and `>` texts, and on one
line `{...}` and `[...]` of plain and quoted values; comments and blank lines anywhere. At anything else (lists of
`- items`, texts over several lines, escapes, tags, anchors, `---`, whatever is wrong) it gives up, and libyaml reads
the text. So it may refuse what is right, but never accept what is wrong, and never find another value.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from grip_bt.base.yaml.scalars import WORDS

_DEEPEST = 50
"""Levels by indentation, and as many within brackets; together fewer than a file may have."""
_KEY = r"[A-Za-z_][\w./-]{0,99}(?: [\w./-]{1,99})?"
_WORD = r"[\w./+()<>=*|%;$@&!~^-]+"
_INLINE = rf"(?:(?=[\w/.+(]|-[\d.]){_WORD}(?: {_WORD})*)"
"""A plain value within brackets: words with a space between, and no sign that means something there."""
_PAIR = rf"{_KEY}: {_INLINE}"
_PLAIN = r"(?:[\w/.+(~]|-[\d.])[^:#\n]*(?:(?::(?=[^ \n])|(?<=[^ \n])#)[^:#\n]*)*"
"""A plain value at the end of a line: neither `: ` nor ` #` in it."""
_LINE = re.compile(
    rf"^( *)(?:({_KEY}):(?: +(?:({_PLAIN})|\{{({_PAIR}(?:, {_PAIR})*)\}} *|([{{[\"'|>][^#\n]*))?)?)?"
    r"(?:(?<![^ \n])#[^\n]*)?\n|^(.*)\n",
    re.MULTILINE,
)
"""Indentation, key, and one of: a plain value; the inside of flat braces; the rest of the line. Else the odd line."""
_TOKEN = re.compile(rf" *(?:({_KEY}): +|({_INLINE})|\"([^\"\\]*)\"|'([^']*)'|([{{}}\[\],]))")


def tidy_data(text: str, meanings: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the data of a tidy text, or None when it isn't one.

    Args:
        text: what `syntax.is_usual` holds for, and not too large.
        meanings: what unquoted texts mean.

    Raises:
        ValueError: a number that doesn't fit 64 bits.
    """
    if text[-1:] != "\n" or "\r" in text:
        return None
    try:
        return _read(text, meanings) or None
    except _NotTidyError:
        return None


class _NotTidyError(Exception):
    pass


def _read(text: str, meanings: Mapping[str, Any]) -> dict[str, Any]:
    into: dict[str, Any] = {}
    above: list[tuple[dict[str, Any], int]] = []
    root, at, key = into, 0, ""
    lines: list[str] = []
    numbered = enumerate(_LINE.findall(text))
    for number, (indent, name, plain, flat, other, odd) in numbered:
        if not name:
            if odd:
                raise _NotTidyError
            continue
        if len(indent) != at:
            into, at = _stepped(into, at, key, len(indent), above)
        if name in into or name in WORDS:
            raise _NotTidyError
        key = ""
        if plain:
            into[name] = meanings[plain.rstrip(" ")]
        elif flat:
            into[name] = _flat(flat, meanings)
        elif not other:
            key = name
            into[name] = None  # until something stands below it
        elif other[0] in "|>":
            lines = lines or text.split("\n")
            into[name], passed = _block(lines, number, at, other)
            for _ in range(passed):
                next(numbered)
        else:
            into[name] = _inline(other, meanings)
    return root


def _stepped(
    into: dict[str, Any], at: int, key: str, width: int, above: list[tuple[dict[str, Any], int]]
) -> tuple[dict[str, Any], int]:
    """Return the mapping that a line of another indentation belongs to: a new one below `key`, or one above."""
    if width > at:
        if not key or len(above) >= _DEEPEST:
            raise _NotTidyError
        above.append((into, at))
        inner: dict[str, Any] = {}
        into[key] = inner
        return inner, width
    while at > width and above:
        into, at = above.pop()
    if at != width:
        raise _NotTidyError
    return into, at


def _flat(pairs: str, meanings: Mapping[str, Any]) -> dict[str, Any]:
    parts = pairs.split(", ")
    entries: dict[str, Any] = {}
    for part in parts:
        key, _, value = part.partition(": ")
        entries[key] = meanings[value]
    if len(entries) != len(parts) or not WORDS.keys().isdisjoint(entries):
        raise _NotTidyError
    return entries


def _block(lines: list[str], number: int, width: int, header: str) -> tuple[str, int]:
    """Return the text of a `|` or `>` block below the key in a line, and how many lines it takes."""
    if header not in ("|", "|-", ">", ">-") or not lines[number].endswith(header):
        raise _NotTidyError
    first = lines[number + 1]
    indent = len(first) - len(first.lstrip(" "))
    if not first or indent <= width or len(first) == indent:
        raise _NotTidyError
    end = number + 1
    margin = " " * indent
    while end < len(lines) - 1 and (not lines[end] or lines[end].startswith(margin)):
        end += 1
    after = lines[end]
    if len(after) - len(after.lstrip(" ")) > width:
        raise _NotTidyError
    taken = lines[number + 1 : end]
    while not taken[-1]:
        taken.pop()
    content = [line[indent:] for line in taken]
    if any(line[-1:] == " " for line in content) or (header[0] == ">" and any(line[:1] == " " for line in content)):
        raise _NotTidyError
    text = "\n".join(content) if header[0] == "|" else _folded(content)
    return text + ("" if header[1:] else "\n"), end - number - 1


def _folded(content: list[str]) -> str:
    """Return lines with the breaks between them as spaces, and a break less where there are several."""
    text, breaks = content[0], 0
    for line in content[1:]:
        if not line:
            breaks += 1
            continue
        text += ("\n" * breaks or " ") + line
        breaks = 0
    return text


def _inline(text: str, meanings: Mapping[str, Any]) -> Any:
    """Return the value of a quoted text, or of brackets with anything inside, that fill a line."""
    text = text.rstrip(" ")
    value, at = _value(text, 0, meanings, 0)
    if at != len(text):
        raise _NotTidyError
    return value


def _value(text: str, at: int, meanings: Mapping[str, Any], depth: int) -> tuple[Any, int]:
    """Return the value that begins at an offset, and where it ends."""
    match = _TOKEN.match(text, at)
    if match is None:
        raise _NotTidyError
    which = match.lastindex
    if which == 2:
        return meanings[match[2]], match.end()
    if which in (3, 4):
        return match[which], match.end()
    if which != 5 or match[5] not in "[{" or depth > _DEEPEST:
        raise _NotTidyError
    take: Callable[..., tuple[Any, int]] = _list if match[5] == "[" else _mapping
    return take(text, match.end(), meanings, depth + 1)


def _list(text: str, at: int, meanings: Mapping[str, Any], depth: int) -> tuple[list[Any], int]:
    items: list[Any] = []
    if text.startswith("]", at):
        return items, at + 1
    while True:
        item, at = _value(text, at, meanings, depth)
        items.append(item)
        more, at = _separator(text, at, "]")
        if not more:
            return items, at


def _mapping(text: str, at: int, meanings: Mapping[str, Any], depth: int) -> tuple[dict[str, Any], int]:
    entries: dict[str, Any] = {}
    if text.startswith("}", at):
        return entries, at + 1
    while True:
        match = _TOKEN.match(text, at)
        if match is None or match.lastindex != 1 or match[1] in entries or match[1] in WORDS:
            raise _NotTidyError
        entries[match[1]], at = _value(text, match.end(), meanings, depth)
        more, at = _separator(text, at, "}")
        if not more:
            return entries, at


def _separator(text: str, at: int, closing: str) -> tuple[bool, int]:
    """Tell whether another item follows, and where; each is parted from the next by `, `."""
    match = _TOKEN.match(text, at)
    if match is not None and match.lastindex == 5:
        if match[5] == closing:
            return False, match.end()
        if match[5] == "," and text.startswith(" ", match.end()):
            return True, match.end()
    raise _NotTidyError
