"""Which lines of a text belong to which entry of a mapping that is written one entry a line.

The lines of such a mapping are shared out without gaps: to an entry belong the comments and blank lines above it, and
below it the comments that are indented deeper than its key.
"""

from __future__ import annotations

from grip_bt.base.yaml.tree import YamlEntry, YamlList, YamlMapping, YamlScalar, YamlValue, entries_of

ODD = "this text is spelled in a way that can't be changed in place; bring it into form with `grip fmt`, then edit"
"""What is said where a text is refused."""


def line_start(text: str, at: int) -> int:
    """Return the offset at which the line of an offset begins."""
    return text.rfind("\n", 0, at) + 1


def line_end(text: str, at: int) -> int:
    """Return the offset after the end of the line of an offset."""
    end = text.find("\n", at)
    return len(text) if end < 0 else end + 1


def is_tidy(text: str, mapping: YamlValue) -> bool:
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
        text: the file's text.
        mapping: the mapping.
        index: which of its entries.
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
