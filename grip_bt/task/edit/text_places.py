"""Where entries stand in a text."""

from __future__ import annotations

from grip_bt.base.errors import EditError
from grip_bt.base.yaml.tree import YamlEntry, YamlList, YamlMapping, YamlScalar, YamlValue, entries_of, parse
from grip_bt.base.yaml.writer import write
from grip_bt.task.comments import attach_comments

from .steps import Place

NOT_EDITABLE = "this formatting can't be edited in place; run `grip fmt` first"
"""What is said where a text is refused."""


def line_start(text: str, at: int) -> int:
    """Return the offset at which the line of an offset begins."""
    return text.rfind("\n", 0, at) + 1


def line_end(text: str, at: int) -> int:
    """Return the offset after the end of the line of an offset."""
    end = text.find("\n", at)
    return len(text) if end < 0 else end + 1


def one_entry_a_line(text: str, mapping: YamlValue) -> bool:
    """Tell whether a mapping has entries, each of which begins a line of its own."""
    if not isinstance(mapping, YamlMapping) or mapping.flow or not mapping.entries:
        return False
    return all(not text[line_start(text, e.start) : e.start].strip(" ") for e in mapping.entries.values())


def content_end(text: str, entry: YamlEntry) -> int:
    """Return the offset after the last character of an entry's value."""
    value: YamlValue = entry.value
    while isinstance(value, YamlMapping | YamlList) and not value.flow:
        entry = entries_of(value)[-1]
        value = entry.value
    begin, end = value.span
    if not isinstance(value, YamlScalar):
        return end
    if begin == end:
        colon = text.find(":", entry.key_end)
        return colon + 1 if entry.key and colon >= 0 else max(entry.key_end, end)
    if value.block:
        head = text[begin : line_end(text, begin)].partition("#")[0]
        return max(end - 1, begin) if "+" in head and text[end - 1 : end] == "\n" else len(text[:end].rstrip())
    return end


def region_end(text: str, entry: YamlEntry) -> int:
    """Return the offset after the last line that belongs to an entry of a tidy mapping."""
    at = found = line_end(text, content_end(text, entry))
    while at < len(text):
        end = line_end(text, at)
        line = text[at:end].strip()
        if line:
            if not line.startswith("#") or _indent(text[at:end]) + 1 <= entry.column:
                break
            found = end
        at = end
    return found


def region_start(text: str, mapping: YamlMapping, index: int, top: bool) -> int:
    """Return the offset of the first line that belongs to an entry of a tidy mapping.

    Args:
        top: whether it is the whole file, whose first lines belong to the file.
    """
    entries = list(mapping.entries.values())
    if index > 0:
        return region_end(text, entries[index - 1])
    begin = line_start(text, entries[0].start)
    if top:
        return begin
    while begin > 0:
        above = line_start(text, begin - 1)
        line = text[above:begin].strip()
        if line and not line.startswith("#"):
            break
        begin = above
    return begin


def dedented(text: str, column: int) -> str:
    """Return lines without their first `column - 1` blanks."""
    return "\n".join(line[min(_indent(line), column - 1) :] for line in text.split("\n"))


def indented(lines: list[str], column: int) -> list[str]:
    """Return lines moved right so that those of column 1 stand in `column`."""
    return [" " * (column - 1) + line if line.strip() else line for line in lines]


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def expand(text: str, at: Place, depth: int) -> tuple[int, int, list[str]]:
    """Return two offsets, and the lines between them for the mappings on the way to a place, one entry a line.

    Args:
        depth: how far down the first one is that is in braces; 0 is the file as a whole.

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
    if not one_entry_a_line(text, chain[depth - 1]):
        raise EditError("/".join(at), NOT_EDITABLE)
    holder.comments.before = []
    written = write(YamlMapping({holder.key: holder}), lambda value: id(value) in blocks)
    lines = indented(written.removesuffix("\n").split("\n"), holder.column)
    return line_start(text, holder.start), line_end(text, content_end(text, holder)), lines
