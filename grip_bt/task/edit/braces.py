"""Mappings in braces: changed within their line, or written anew with one entry a line.

Each change is a splice, (begin, end, text): what is put in place of the text between two offsets.
"""

from __future__ import annotations

from typing import Any

from grip_bt.base.errors import EditError
from grip_bt.base.yaml.tree import YamlEntry, YamlMapping, YamlScalar, entries_of, from_data, parse
from grip_bt.base.yaml.writer import WIDTH, in_braces, write

from ..comments import attach_comments
from .regions import ODD, content_end, indented, is_tidy, line_end, line_start
from .steps import Place, path_of, position_of

_Splice = tuple[int, int, str]


def fits(text: str, inside: YamlMapping, more: int) -> bool:
    """Tell whether a mapping in braces stays within its line when it has so many characters more."""
    begin, end = inside.span
    line = text[line_start(text, end - 1) : line_end(text, end - 1)].partition("#")[0]
    return len(line.rstrip()) + more <= WIDTH and "\n" not in text[begin:end]


def is_odd(text: str, inside: YamlMapping) -> bool:
    """Tell whether a mapping in braces has comments, or entries without a value."""
    begin, end = inside.span
    empty = any(isinstance(e.value, YamlScalar) and e.value.span[0] == e.value.span[1] for e in entries_of(inside))
    return empty or "#" in text[begin:end]


def without(inside: YamlMapping, entry: YamlEntry) -> _Splice:
    """Return how an entry of a mapping in braces is taken out."""
    entries = entries_of(inside)
    index = list(inside.entries).index(entry.key)
    if len(entries) == 1:
        return *inside.span, "{}"
    if index + 1 < len(entries):
        return entry.start, entries[index + 1].start, ""
    return _end(entries[index - 1]), _end(entry), ""


def with_another(text: str, inside: YamlMapping, at: Place, key: str, value: Any, index: int | None) -> _Splice | None:
    """Return how a new entry is written into a mapping in braces; None where it is to have lines of its own."""
    if path_of((*at, key)) is not None:
        if not isinstance(value, dict) or "kind" in value or at[-1:] == ("child",) or not inside.entries:
            return None
    inline = in_braces(from_data({key: value}))
    if inline is None or is_odd(text, inside):
        return None
    pair = inline[1:-1]
    if not fits(text, inside, len(pair) + 2):
        return None
    entries, keys = entries_of(inside), list(inside.entries)
    if not entries:
        return *inside.span, f"{{{pair}}}"
    before = position_of(at, keys, key, index)
    if before < len(keys):
        return entries[before].start, entries[before].start, f"{pair}, "
    end = _end(entries[-1])
    return end, end, f", {pair}"


def _end(entry: YamlEntry) -> int:
    """Return the offset after an entry of a mapping in braces."""
    return max(entry.value.span[1], entry.key_end)


def spread(text: str, at: Place, depth: int) -> tuple[int, int, list[str]]:
    """Return how the mappings on the way to a place are written with one entry a line, from a depth on.

    Args:
        text: the file's text.
        at: the place.
        depth: how far down the first one is that is in braces; 0 is the file as a whole.

    Returns:
        Two offsets, and the lines in place of what is between them.

    Raises:
        EditError: that first one doesn't begin a line.
    """
    tree = parse(text)
    assert isinstance(tree, YamlMapping)
    header = attach_comments(tree, text.replace("\r", " "))
    chain: list[YamlMapping] = [tree]
    holders: list[YamlEntry] = []
    for key in at:
        inner = chain[-1].entries[key]
        assert isinstance(inner.value, YamlMapping)
        holders.append(inner)
        chain.append(inner.value)
    blocks = {id(mapping) for mapping in chain[depth:] if mapping.entries}
    if depth == 0:
        written = write(tree, lambda value: id(value) in blocks, header)
        return 0, len(text), written.removesuffix("\n").split("\n")
    holder = holders[depth - 1]
    if not is_tidy(text, chain[depth - 1]):
        raise EditError("/".join(at), ODD)
    holder.comments.before = []
    written = write(YamlMapping({holder.key: holder}), lambda value: id(value) in blocks)
    lines = indented(written.removesuffix("\n").split("\n"), holder.column)
    return line_start(text, holder.start), line_end(text, content_end(text, holder)), lines
