"""Comments in a task's file, of nodes and of the task as a whole: where they stand, how they are read and written."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from grip_bt.base.errors import EditError
from grip_bt.base.yaml.scalars import STRANGE
from grip_bt.base.yaml.tree import YamlEntry, YamlMapping

from ..document import Document
from .editing import BaseCommand, Edit, path_in_words
from .steps import FILE_COMMENT, Place, Remark
from .text_places import content_end, line_end, line_start, one_entry_a_line, region_end

LONGEST = 10_000
"""Characters of a comment."""

_UNWRITABLE = re.compile(f"[\x00-\x1f{STRANGE}]")


@dataclass(frozen=True)
class _Written:
    """A comment without its signs, and where it stands.

    Attributes:
        begin: offset of its first line above; where one would go, if there is none.
        after: offset after the blank lines that set it off from what follows, and go with it.
        beside: begin and end of what stands at the end of the entry's line, from the `#` on; None where nothing does.
    """

    text: str
    begin: int
    end: int
    after: int
    beside: tuple[int, int] | None = None


def lines_of_comment(path: str, text: str) -> list[str]:
    """Return a comment as it stands in a file, line by line; blank lines at its ends are left out.

    Raises:
        EditError: it is too long, or has characters that files of tasks can't have.
    """
    if len(text) > LONGEST:
        raise EditError(path, f"a comment may have {LONGEST} characters, not {len(text)}; shorten it")
    lines = "\n".join(line.expandtabs(4).rstrip() for line in text.splitlines()).strip("\n").splitlines()
    strange = _UNWRITABLE.search("".join(lines))
    if strange:
        raise EditError(path, f"a comment can't have the character {strange.group()!r}; leave it out")
    return [f"# {line}".rstrip() for line in lines]


def found_at(text: str, inside: YamlMapping, key: str) -> _Written:
    """Return where the comment of an entry of a tidy mapping stands."""
    keys = list(inside.entries)
    index, entry = keys.index(key), inside.entries[key]
    end = begin = line_start(text, entry.start)
    limit = region_end(text, inside.entries[keys[index - 1]]) if index else 0
    above: list[str] = []
    while begin > limit:
        line = text[line_start(text, begin - 1) : begin].strip()
        if not line.startswith("#"):
            break
        above.insert(0, _uncommented(line))
        begin = line_start(text, begin - 1)
    beside = _beside(text, entry)
    aside = [_uncommented(text[slice(*beside)])] if beside else []
    return _Written("\n".join([*above, *aside]), begin, end, end, beside)


def _beside(text: str, entry: YamlEntry) -> tuple[int, int] | None:
    if isinstance(entry.value, YamlMapping) and not entry.value.flow:
        at = text.index(":", entry.key_end) + 1
    else:
        at = content_end(text, entry)
    rest = text[at : line_end(text, at)]
    found = rest.strip()
    begin = at + len(rest) - len(rest.lstrip())
    return (begin, begin + len(found)) if found.startswith("#") else None


def _uncommented(line: str) -> str:
    return line.removeprefix("#").removeprefix(" ").rstrip()


_MARK = "\ufeff"


_HEAD = re.compile(r"^[ \t]*#[^\n]*\n?([ \t]*(#[^\n]*)?\r?\n)*", re.MULTILINE)
"""Lines of comments, with blank ones between and below them."""


def head_at(text: str, tree: YamlMapping) -> _Written:
    """Return where the comment at the top of a file stands, given its syntax; `---` may stand before it or after it."""
    end, at = _end(text, tree), len(_MARK) if text.startswith(_MARK) else 0
    found = _HEAD.search(text[at:end])
    if found is None:
        return _Written("", end, end, end)
    begin = at + found.start()
    last = line_end(text, begin + len(found.group().rstrip()))
    lines = [_uncommented(line.strip()) for line in text[begin:last].splitlines()]
    return _Written("\n".join(lines), begin, last, at + found.end())


def _end(text: str, tree: YamlMapping) -> int:
    """Return the offset before which everything is the file's and no entry's."""
    entries = list(tree.entries)
    if entries[:1] == ["root"] and one_entry_a_line(text, tree):
        return found_at(text, tree, "root").begin
    first = tree.span[0] if tree.flow else tree.entries[entries[0]].start
    return max(line_start(text, first), len(_MARK) if text.startswith(_MARK) else 0)


class Comment(BaseCommand):
    """A node has another comment in its file; in place of the lines right above it and of the end of its first line."""

    do: Literal["comment"] = "comment"
    path: str
    """Empty for the task, whose comment is the lines at the top of the file."""
    text: str
    """Its lines without `#`; empty for none."""

    def in_words(self) -> str:
        return (
            f"comment on {path_in_words(self.path)}"
            if self.text.strip()
            else f"no comment on {path_in_words(self.path)}"
        )

    def plan(self, edit: Edit) -> None:
        place: Place = edit.place(self.path) or (FILE_COMMENT,)
        lines_of_comment(self.path, self.text)
        edit.take(Remark(at=place[:-1], key=place[-1], text=self.text))


def comment_of(document: Document, path: str) -> str:
    """Return the comment of a node, of the task for an empty path, without its signs; empty where it has none.

    Raises:
        EditError: there is no such node.
    """
    if path == "":
        return head_at(document.text, document.tree).text
    *above, key = Edit(document.task).place(path)
    inside = document.tree
    for step in above:
        inner = inside.entries[step].value
        if not isinstance(inner, YamlMapping):
            return ""
        inside = inner
    return found_at(document.text, inside, key).text if one_entry_a_line(document.text, inside) else ""
