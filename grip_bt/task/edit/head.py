"""The comment of a task as a whole: the `#` lines at the top of its file, before the first key.

They stay at the top whatever key comes first, blank lines between them are part of them, and a change of a line leaves
the spelling of the others alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from difflib import SequenceMatcher

from grip_bt.base.yaml.tree import YamlMapping

from .regions import is_tidy, line_end, line_start
from .remarks import found_at, lines_of_comment, said

_MARK = "\ufeff"


@dataclass(frozen=True)
class Head:
    """Where the comment at the top of a file stands.

    Attributes:
        begin: offset of its first line; where one would go, if there is none.
        end: offset after its last line.
        spelled: its lines as they are, with their ends.
        after: offset after the blank lines that set it off from what follows.
    """

    begin: int
    end: int
    spelled: tuple[str, ...]
    after: int

    @property
    def text(self) -> str:
        """What it says, one line after the other."""
        return "\n".join(self.said)

    @property
    def said(self) -> tuple[str, ...]:
        """What its lines say, without their signs."""
        return tuple(said(line.strip()) for line in self.spelled)


def head_at(text: str, tree: YamlMapping) -> Head:
    """Return where the comment at the top of a file stands, given its syntax."""
    end = _end(text, tree)
    at = len(_MARK) if text.startswith(_MARK) else 0
    runs: list[list[tuple[int, str]]] = [[]]
    while at < end:
        line = text[at : line_end(text, at)]
        if line.strip() and not line.lstrip().startswith("#"):
            runs.append([])  # `---`: what says something may stand before it or after it
        else:
            runs[-1].append((at, line))
        at += len(line)
    run = next((run for run in runs if any(line.strip() for _, line in run)), [])
    marked = [number for number, (_, line) in enumerate(run) if line.strip()]
    if not marked:
        return Head(end, end, (), end)
    lines = run[marked[0] : marked[-1] + 1]
    last, line = lines[-1]
    after = sum(map(len, (blank for _, blank in run[marked[-1] + 1 :])), last + len(line))
    return Head(lines[0][0], last + len(line), tuple(line for _, line in lines), after)


def _end(text: str, tree: YamlMapping) -> int:
    """Return the offset before which everything is the file's and no entry's."""
    entries = list(tree.entries)
    if entries[:1] == ["root"] and is_tidy(text, tree):
        return found_at(text, tree, "root").begin
    first = tree.span[0] if tree.flow else tree.entries[entries[0]].start
    return max(line_start(text, first), len(_MARK) if text.startswith(_MARK) else 0)


def rewritten(head: Head, comment: str, newline: str) -> tuple[int, int, str]:
    """Return what to put where so that a head says something else: (begin, end, text).

    Lines that stay keep their spelling; where all go, the blank lines below go too.

    Raises:
        EditError: no file can hold the comment.
    """
    lines = lines_of_comment("", comment)
    if not lines:
        return head.begin, head.after, ""
    wanted = [said(line) for line in lines]
    written: list[str] = []
    for what, begin, end, first, last in SequenceMatcher(None, head.said, wanted, autojunk=False).get_opcodes():
        same = what == "equal"
        written += head.spelled[begin:end] if same else [line + newline for line in lines[first:last]]
    return head.begin, head.end, "".join(written)
