"""Undo and redo over commands. A history is made of texts, so that undo gives back the very bytes."""

from __future__ import annotations

from dataclasses import dataclass

from grip_bt.base.errors import EditError, listing

from ..document import Document, read_text
from .commands import AnyCommand, title_of
from .documents import Edited, apply_to_document
from .steps import Step, backwards

LIMIT = 1000
"""Moments that a history holds, unless it is told otherwise."""


@dataclass(frozen=True)
class Moment:
    """One state of a document in a history.

    Attributes:
        number: 0 is what the history began with; none is used twice.
        title: what was done, in a few words.
        steps: the way from the one before, for what follows the nodes.
    """

    number: int
    title: str
    text: str
    steps: tuple[Step, ...] = ()


class History:
    """A document and what was done to it; a command after an undo takes the place of what was undone."""

    def __init__(self, document: Document, limit: int = LIMIT):
        self.document = document
        self.moments = [Moment(0, "opened", document.text)]
        self._at, self._next, self._limit = 0, 1, max(limit, 1)

    @property
    def at(self) -> Moment:
        """The moment at which the document is."""
        return self.moments[self._at]

    @property
    def can_undo(self) -> bool:
        """Whether something can be undone here."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether something was undone here that can be done again."""
        return self._at + 1 < len(self.moments)

    def do(self, command: AnyCommand) -> Edited:
        """Carry out a command (one gesture: several are a `Group`) and keep how to undo it.

        Raises:
            EditError: it can't be carried out; nothing has changed.
        """
        edited = apply_to_document(self.document, command)
        made = Moment(self._next, title_of(command), edited.document.text, edited.steps)
        self.moments = [*self.moments[: self._at + 1], made][-self._limit :]
        self._at, self._next, self.document = len(self.moments) - 1, self._next + 1, edited.document
        return edited

    def undo(self) -> tuple[Step, ...]:
        """Go to the moment before, and return the way there; EditError where this is the first."""
        if not self.can_undo:
            raise EditError("", "there is nothing to undo")
        steps = self.at.steps
        self._turn_to(self._at - 1)
        return backwards(steps)

    def redo(self) -> tuple[Step, ...]:
        """Go to the moment after, and return the way there; EditError where nothing was undone here."""
        if not self.can_redo:
            raise EditError("", "there is nothing to redo")
        self._turn_to(self._at + 1)
        return self.at.steps

    def go(self, number: int) -> tuple[Step, ...]:
        """Go to any moment, over undo and redo; return the way there. Raises EditError where it isn't there."""
        numbers = [moment.number for moment in self.moments]
        if number not in numbers:
            raise EditError("", f"there is no revision {number} (available: {listing(map(str, numbers))})")
        ways = []
        while self.at.number != number:
            ways.append(self.undo() if numbers.index(number) < self._at else self.redo())
        return tuple(step for way in ways for step in way)

    def _turn_to(self, at: int) -> None:
        self._at, self.document = at, read_text(self.moments[at].text, self.document.source)
