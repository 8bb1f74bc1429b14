"""Undo and redo over commands, with branches: what was undone and then overwritten stays reachable.

A history holds a bounded number of moments. What is forgotten first are the oldest ends of branches on which the
document isn't; then its own beginning.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from grip_bt.base.errors import EditError

from ..document import Document
from .commands import AnyCommand, Patch, title_of
from .documents import Edited, apply_to_document


@dataclass(frozen=True)
class Moment:
    """One state of a document in a history.

    Attributes:
        number: its number; 0 is what the history began with.
        parent: the moment that it was made from; None for the first.
        title: what was done, in a few words.
    """

    number: int
    parent: int | None
    title: str


LIMIT = 1000
"""Moments that a history holds, unless it is told otherwise."""


@dataclass
class Kept:
    """A moment with the way from and to its parent, and the moments made from it, the one left last at the end."""

    moment: Moment
    back: Patch | None
    forth: Patch | None = None
    children: list[int] = field(default_factory=list)


class History:
    """A document and everything that was done to it.

    A command after an undo begins a new branch; `redo` takes the youngest, `go` leads to any moment of any branch.
    """

    def __init__(self, document: Document, limit: int = LIMIT):
        self._kept = {0: Kept(Moment(0, None, "opened"), None)}
        self._at = 0
        self._next = 1
        self._limit = max(limit, 1)
        self._document = document

    @classmethod
    def restored(cls, document: Document, kept: Iterable[Kept], at: int, limit: int = LIMIT) -> History:
        """Return a history as it was: its document, its moments, and the number of the one at which it is."""
        history = cls(document, limit)
        history._kept = {each.moment.number: each for each in kept}
        history._at, history._next = at, max(history._kept) + 1
        history._forget()
        return history

    @property
    def document(self) -> Document:
        """The document as it is now."""
        return self._document

    @property
    def at(self) -> Moment:
        """The moment at which the document is."""
        return self._kept[self._at].moment

    @property
    def moments(self) -> tuple[Moment, ...]:
        """All moments, in the order in which they were made."""
        return tuple(kept.moment for kept in self._kept.values())

    @property
    def kept(self) -> tuple[Kept, ...]:
        """All moments with the ways between them, for whoever stores them."""
        return tuple(self._kept.values())

    @property
    def can_undo(self) -> bool:
        """Whether something can be undone here."""
        return self._kept[self._at].back is not None

    @property
    def can_redo(self) -> bool:
        """Whether something was undone here that can be done again."""
        return bool(self._kept[self._at].children)

    def do(self, command: AnyCommand) -> Edited:
        """Carry out a command (one gesture: several are a `Group`) and keep how to undo it.

        Raises:
            EditError: it can't be carried out; nothing has changed.
        """
        edited = apply_to_document(self._document, command)
        number, self._next = self._next, self._next + 1
        self._kept[number] = Kept(Moment(number, self._at, title_of(command)), edited.inverse)
        self._kept[self._at].children.append(number)
        self._at, self._document = number, edited.document
        self._forget()
        return edited

    def undo(self) -> Edited:
        """Go to the moment before.

        Raises:
            EditError: this is the first.
        """
        kept = self._kept[self._at]
        if kept.back is None or kept.moment.parent is None:
            raise EditError("", "there is nothing to undo")
        edited = apply_to_document(self._document, kept.back)
        kept.forth = edited.inverse
        self._take(kept.moment.parent, kept.moment.number, edited)
        return edited

    def redo(self, number: int | None = None) -> Edited:
        """Go to a moment that was made from this one: to the one of this number, or to the one that was left last.

        Raises:
            EditError: nothing was undone here, or there is no such moment.
        """
        children = self._kept[self._at].children
        if not children or (number is not None and number not in children):
            raise EditError(
                "", "there is nothing to redo" if number is None else f"moment {number} isn't made from here"
            )
        kept = self._kept[children[-1] if number is None else number]
        assert kept.forth is not None
        edited = apply_to_document(self._document, kept.forth)
        kept.back = edited.inverse
        self._take(kept.moment.number, kept.moment.number, edited)
        return edited

    def go(self, number: int) -> tuple[Edited, ...]:
        """Go to any moment, over undo and redo; return what was done on the way.

        Raises:
            EditError: there is no such moment.
        """
        if number not in self._kept:
            forgotten = " any more" if 0 <= number < self._next else ""
            raise EditError("", f"there is no moment {number}{forgotten}; the last is {max(self._kept)}")
        up = self._line(self._at)
        down = []
        at: int = number
        while at not in up:
            down.append(at)
            parent = self._kept[at].moment.parent
            assert parent is not None
            at = parent
        done = [self.undo() for _ in range(up.index(at))]
        return (*done, *(self.redo(step) for step in reversed(down)))

    def replace(self, text: Document) -> None:
        """Take a document that was changed from outside (a person edited the text) as the one of this moment.

        What was done before can still be undone: the text then changes where the commands had changed it.
        """
        self._document = text

    def _forget(self) -> None:
        """Keep no more moments than the limit; numbers stay."""
        while len(self._kept) > self._limit:
            line = set(self._line(self._at))
            loose = next((n for n, kept in self._kept.items() if n not in line and not kept.children), None)
            self._forget_end(loose) if loose is not None else self._forget_beginning()

    def _forget_end(self, number: int) -> None:
        parent = self._kept.pop(number).moment.parent
        assert parent is not None, "the beginning is on every line"
        self._kept[parent].children.remove(number)

    def _forget_beginning(self) -> None:
        first = next(iter(self._kept))
        begin = self._kept[self._kept.pop(first).children[0]]
        begin.moment = replace(begin.moment, parent=None)
        begin.back = begin.forth = None

    def _line(self, number: int) -> list[int]:
        line: list[int] = []
        at: int | None = number
        while at is not None:
            line.append(at)
            at = self._kept[at].moment.parent
        return line

    def _take(self, number: int, used: int, edited: Edited) -> None:
        """Be at a moment; the branch that was used last is the one that a redo takes."""
        parent = self._kept[used].moment.parent
        assert parent is not None
        siblings = self._kept[parent].children
        siblings.remove(used)
        siblings.append(used)
        self._at, self._document = number, edited.document
