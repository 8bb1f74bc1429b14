"""Undo and redo over commands, with branches: what was undone and then overwritten stays reachable."""

from __future__ import annotations

from dataclasses import dataclass, field

from grip_bt.errors import EditError

from ..document import Document
from .applied import title_of
from .commands import AnyCommand, Patch
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


@dataclass
class _Kept:
    """A moment with the way from and to its parent."""

    moment: Moment
    back: Patch | None
    forth: Patch | None = None
    children: list[int] = field(default_factory=list)


class History:
    """A document and everything that was done to it.

    A command after an undo begins a new branch; `redo` takes the youngest, `go` leads to any moment of any branch.
    """

    def __init__(self, document: Document):
        self._kept = [_Kept(Moment(0, None, "opened"), None)]
        self._at = 0
        self._document = document

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
        return tuple(kept.moment for kept in self._kept)

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
        number = len(self._kept)
        self._kept.append(_Kept(Moment(number, self._at, title_of(command)), edited.inverse))
        self._kept[self._at].children.append(number)
        self._at, self._document = number, edited.document
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
        if not 0 <= number < len(self._kept):
            raise EditError("", f"there is no moment {number}; the last is {len(self._kept) - 1}")
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
