"""Comments of a YAML text: finding them and tying each to the entry that it speaks about.

A comment on a line of its own speaks about the entry below it, unless it is indented like the entry above and
deeper than the one below: then it closes that one. A comment at the end of a line speaks about the entry there.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass

from grip_bt.base.yaml.tree import Comments, YamlEntry, YamlList, YamlMapping, YamlScalar, entries_of


@dataclass(frozen=True)
class _Comment:
    text: str
    start: int
    column: int
    alone: bool
    blank_before: bool


@dataclass(frozen=True)
class _Place:
    """An entry, the collection that it is in, and the innermost one in braces or brackets around it."""

    entry: YamlEntry
    parent: YamlMapping | YamlList
    flow: YamlMapping | YamlList | None


def attach_comments(tree: YamlMapping, text: str) -> list[str]:
    """Tie comments and blank lines to entries; return the lines before the first one, which stay at the file's top."""
    places = list(_places(tree))
    spans: list[tuple[int, int]] = []
    flows: list[YamlEntry] = []
    blocks: set[int] = set()
    for entry in (place.entry for place in places):
        value = entry.value
        spans.append((entry.start, entry.key_end))
        if not isinstance(value, YamlScalar):
            flows += [entry] * value.flow
            continue
        spans.append(value.span)
        blocks |= {value.span[0]} if value.block else set()
    _attach_blank_lines(places, text)
    header: list[str] = []
    starts = [p.entry.start for p in places]
    for comment in _find(text, spans, blocks):
        below = bisect_right(starts, comment.start)
        if below == 0:
            header.extend([""] * (comment.blank_before and bool(header)) + [comment.text])
            continue
        around = [f for f in flows if f.value.span[0] < comment.start < f.value.span[1]]
        if around:
            _attach_in_flow(around[-1], comment)
        elif comment.alone:
            _attach_alone(places, below, comment)
        else:
            on_line = next((p for p in reversed(places[:below]) if p.flow is None), places[0])
            _put_beside(on_line.entry.comments, comment.text)
    first = places[0].entry.comments if places else Comments()
    if header and "" in first.before[:1]:
        header.append("")
    first.before = [c for c in first.before if c]
    return header


def _places(tree: YamlMapping) -> Iterator[_Place]:
    stack = [_Place(e, tree, tree if tree.flow else None) for e in reversed(entries_of(tree))]
    while stack:
        place = stack.pop()
        yield place
        value = place.entry.value
        if not isinstance(value, YamlScalar):
            flow = value if value.flow else place.flow
            stack.extend(_Place(e, value, flow) for e in reversed(entries_of(value)))


def _find(text: str, spans: list[tuple[int, int]], blocks: set[int]) -> Iterator[_Comment]:
    """Yield the comments of a text, given the spans of its scalars in document order."""
    begins = [begin for begin, _ in spans]
    at = text.find("#")
    while at >= 0:
        inside = bisect_right(begins, at) - 1
        begin, end = spans[inside] if inside >= 0 else (0, 0)
        line_start = text.rfind("\n", 0, at) + 1
        header_line = begin in blocks and "\n" not in text[begin:at]
        starts_word = at == line_start or text[at - 1] in " \t"
        if (at >= end or header_line) and starts_word:
            line_end = text.find("\n", at)
            line_end = len(text) if line_end < 0 else line_end
            before = text[line_start:at]
            yield _Comment(
                text[at:line_end].rstrip(), at, at - line_start + 1, not before.strip(), _blank_above(text, line_start)
            )
            at = text.find("#", line_end)
        else:
            at = text.find("#", at + 1 if at >= end or header_line else end)


def _attach_blank_lines(places: list[_Place], text: str) -> None:
    for place in places:
        line_start = text.rfind("\n", 0, place.entry.start) + 1
        first = place.flow is None and not text[line_start : place.entry.start].strip(" -")
        if first and _blank_above(text, line_start):
            place.entry.comments.before.append("")


def _blank_above(text: str, line_start: int) -> bool:
    end = max(line_start - 1, 0)
    return line_start > 0 and not text[text.rfind("\n", 0, end) + 1 : end].strip()


def _attach_in_flow(flow: YamlEntry, comment: _Comment) -> None:
    entries = entries_of(flow.value)
    earlier = [e for e in entries if e.start < comment.start]
    later = entries[len(earlier) :]
    if earlier and not comment.alone:
        _put_beside(earlier[-1].comments, comment.text)
    elif later:
        later[0].comments.before.append(comment.text)
    elif earlier and not isinstance(flow.value, YamlScalar):
        flow.value.closing.append(comment.text)
    else:
        _put_beside(flow.comments, comment.text)


def _attach_alone(places: list[_Place], below: int, comment: _Comment) -> None:
    following = next((p for p in places[below:] if p.flow is None), None)
    lines = [""] * comment.blank_before + [comment.text]
    if following is not None and comment.column <= following.entry.column:
        before = following.entry.comments.before
        at = len(before) - 1 if before and before[-1] == "" else len(before)
        before[at:at] = lines
        return
    above = [p for p in places[:below] if p.flow is None] or places[:1]
    owner = next((p for p in reversed(above) if p.entry.column <= comment.column), above[0])
    owner.parent.closing.extend(lines)


def _put_beside(comments: Comments, text: str) -> None:
    if comments.beside:
        comments.before.append(text)
    else:
        comments.beside = text
