"""The comment of a node: the lines right above it in its file, and what stands at the end of its first line.

Above are the lines that begin with `#`, without a gap, down to the node. Comments that are set off by a blank line,
that close what stands before, or that are inside the node's braces aren't the node's.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from grip_bt.base.errors import EditError
from grip_bt.base.yaml.tree import YamlEntry, YamlMapping

from .regions import content_end, line_end, line_start, region_end

LONGEST = 10_000
"""Characters of a comment."""
_STRANGE = re.compile("[^ -~\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class Found:
    """Where the comment of an entry stands.

    Attributes:
        begin: offset of the first line above that belongs to it; of the entry's own line where there is none.
        end: offset of the entry's own line.
        above: what the lines above say.
        beside: begin and end of what stands at the end of the entry's line, from the `#` on; None where nothing does.
        aside: what it says.
    """

    begin: int
    end: int
    above: tuple[str, ...]
    beside: tuple[int, int] | None
    aside: tuple[str, ...]

    @property
    def text(self) -> str:
        """What it says, one line after the other."""
        return "\n".join((*self.above, *self.aside))


def lines_of_comment(path: str, text: str) -> list[str]:
    """Return a comment as it stands in a file, line by line; blank lines at its ends are left out.

    Raises:
        EditError: it is too long, or has characters that files of tasks can't have.
    """
    if len(text) > LONGEST:
        raise EditError(path, f"a comment may have {LONGEST} characters, not {len(text)}; shorten it")
    lines = [line.expandtabs(4).rstrip() for line in text.splitlines()]
    strange = _STRANGE.search("".join(lines))
    if strange:
        raise EditError(path, f"a comment can't have the character {strange.group()!r}; leave it out")
    while lines and not lines[-1]:
        del lines[-1]
    while lines and not lines[0]:
        del lines[0]
    return [f"# {line}".rstrip() for line in lines]


def found_at(text: str, inside: YamlMapping, key: str) -> Found:
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
        above.insert(0, said(line))
        begin = line_start(text, begin - 1)
    beside = _beside(text, entry)
    aside = (said(text[slice(*beside)]),) if beside else ()
    return Found(begin, end, tuple(above), beside, aside)


def _beside(text: str, entry: YamlEntry) -> tuple[int, int] | None:
    if isinstance(entry.value, YamlMapping) and not entry.value.flow:
        at = text.index(":", entry.key_end) + 1
    else:
        at = content_end(text, entry)
    rest = text[at : line_end(text, at)]
    found = rest.strip()
    begin = at + len(rest) - len(rest.lstrip())
    return (begin, begin + len(found)) if found.startswith("#") else None


def said(line: str) -> str:
    """Return what a line says that begins with `#`."""
    return line.removeprefix("#").removeprefix(" ").rstrip()
