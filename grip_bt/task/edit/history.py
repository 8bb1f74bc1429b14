"""Undo and redo over commands, with branches: what was undone and then overwritten stays reachable.

A history is made of texts, so that undo gives back the very bytes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from grip_bt.base.errors import DocumentError, EditError
from grip_bt.base.files import replace_text

from ..document import Document, read_text
from .commands import AnyCommand, title_of
from .documents import Edited, apply_to_document, rewrite
from .steps import Step, backwards

LIMIT = 1000
"""Moments that a history holds, unless it is told otherwise."""
LARGEST = 10_000_000
"""Bytes of a file; a larger history is stored without its oldest moments."""
OUTSIDE = "changed outside"


class Moment(BaseModel):
    """One state of a document in a history."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    number: Annotated[int, Field(ge=0)]
    """0 is what the history began with."""
    parent: int | None
    """The moment that it was made from; None for the first."""
    title: str
    """What was done, in a few words."""
    text: str
    steps: tuple[Step, ...] = ()
    """The way from the one before, for what follows the nodes."""


class History:
    """A document and everything that was done to it.

    A command after an undo begins a new branch; `redo` takes the youngest, `go` leads to any moment of any branch.
    """

    def __init__(self, document: Document, limit: int = LIMIT):
        self._moments = {0: Moment(number=0, parent=None, title="opened", text=document.text)}
        self._at = 0
        self._next = 1
        self._left: dict[int, int] = {}
        """Moment -> which of those made from it was left last, where it was left since the history was loaded."""
        self._limit = max(limit, 1)
        self._document = document

    @classmethod
    def restored(cls, document: Document, moments: Iterable[Moment], at: int, limit: int = LIMIT) -> History:
        """Return a history as it was: its document, its moments, and the number of the one at which it is."""
        history = cls(document, limit)
        history._moments = {each.number: each for each in moments}
        history._at, history._next = at, max(history._moments) + 1
        history._forget()
        return history

    @property
    def document(self) -> Document:
        """The document as it is now."""
        return self._document

    @property
    def at(self) -> Moment:
        """The moment at which the document is."""
        return self._moments[self._at]

    @property
    def moments(self) -> tuple[Moment, ...]:
        """All moments, in the order in which they were made."""
        return tuple(self._moments.values())

    @property
    def can_undo(self) -> bool:
        """Whether something can be undone here."""
        return self.at.parent is not None

    @property
    def can_redo(self) -> bool:
        """Whether something was undone here that can be done again."""
        return bool(self._below(self._at))

    def do(self, command: AnyCommand) -> Edited:
        """Carry out a command (one gesture: several are a `Group`) and keep how to undo it.

        Raises:
            EditError: it can't be carried out; nothing has changed.
        """
        edited = apply_to_document(self._document, command)
        number, self._next = self._next, self._next + 1
        told = {"title": title_of(command), "text": edited.document.text}
        self._moments[number] = Moment(number=number, parent=self._at, **told, steps=edited.steps)
        self._at, self._document = number, edited.document
        self._forget()
        return edited

    def undo(self) -> tuple[Step, ...]:
        """Go to the moment before, and return the way there; EditError where this is the first."""
        moment = self.at
        if moment.parent is None:
            raise EditError("", "there is nothing to undo")
        self._left[moment.parent] = moment.number
        self._turn_to(moment.parent)
        return backwards(moment.steps)

    def redo(self, number: int | None = None) -> tuple[Step, ...]:
        """Go to a moment that was made from this one: to the one of this number, or to the one that was left last.

        Raises:
            EditError: nothing was undone here, or there is no such moment.
        """
        below = self._below(self._at)
        if not below or (number is not None and number not in below):
            wrong = f"revision {number} doesn't follow from the current one"
            raise EditError("", "there is nothing to redo" if number is None else wrong)
        left = self._left.get(self._at)
        moment = self._moments[number if number is not None else left if left in below else below[-1]]
        self._turn_to(moment.number)
        return moment.steps

    def go(self, number: int) -> tuple[Step, ...]:
        """Go to any moment, over undo and redo; return the way there. Raises EditError: there is no such moment."""
        if number not in self._moments:
            forgotten = " any more" if 0 <= number < self._next else ""
            raise EditError("", f"there is no revision {number}{forgotten}; the last is {max(self._moments)}")
        up, down = self._line(self._at), self._line(number)
        common = next(each for each in up if each in down)
        ways = [self.undo() for _ in up[: up.index(common)]]
        ways += [self.redo(each) for each in reversed(down[: down.index(common)])]
        return tuple(step for way in ways for step in way)

    def _turn_to(self, number: int) -> None:
        self._at, self._document = number, read_text(self._moments[number].text, self._document.source)

    def _forget(self) -> None:
        """Keep no more moments than the limit; numbers stay."""
        while len(self._moments) > self._limit:
            line = self._line(self._at)
            loose = (number for number in self._moments if number not in line and not self._below(number))
            gone = self._moments.pop(next(loose, next(iter(self._moments))))
            if gone.parent is None:
                (first,) = self._below(gone.number)
                self._moments[first] = self._moments[first].model_copy(update={"parent": None, "steps": ()})

    def _below(self, number: int) -> list[int]:
        return [moment.number for moment in self._moments.values() if moment.parent == number]

    def _line(self, number: int) -> list[int]:
        line: list[int] = []
        at: int | None = number
        while at is not None:
            line.append(at)
            at = self._moments[at].parent
        return line


class _Stored(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    grip_history: Literal[3]
    at: int
    moments: list[Moment] = Field(min_length=1)

    @model_validator(mode="after")
    def _one_tree(self) -> _Stored:
        seen: list[int | None] = [None]
        for number, parent in ((moment.number, moment.parent) for moment in self.moments):
            if parent not in seen or (number in seen) or (parent is None) != (seen == [None]):
                raise ValueError("moments that don't hang together")
            seen.append(number)
        if self.at not in seen:
            raise ValueError(f"no moment {self.at}")
        return self


def history_path(task: Path | str) -> Path:
    """Return where the history of a task file is kept."""
    task = Path(task)
    return task.parent / ".grip" / "history" / f"{task.name}.json"


def save_history(history: History, path: Path) -> None:
    """Write a history in one step: whoever reads the file sees the old one or the new one.

    Raises:
        DocumentError: it can't be written.
    """
    text, limit = stored(history), len(history.moments)
    while len(text.encode()) > LARGEST and limit > 1:
        limit //= 2
        history = History.restored(history.document, history.moments, history.at.number, limit)
        text = stored(history)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_text(path, text)
    except OSError as error:
        raise DocumentError(f"can't be written: {error.strerror or error}", str(path)) from error


def stored(history: History) -> str:
    """Return a history as the text of its file."""
    made = _Stored(grip_history=3, at=history.at.number, moments=list(history.moments))
    return json.dumps(made.model_dump(mode="json"), ensure_ascii=False) + "\n"


def load_history(path: Path, document: Document, limit: int = LIMIT) -> History:
    """Return the history of a task whose file holds `document` now; a new one where there is no file.

    Raises:
        DocumentError: the file is damaged or of another version; delete it, and begin with a new history.
    """
    try:
        return restored(path.read_text(encoding="utf-8"), document, limit)
    except FileNotFoundError:
        return History(document, limit)
    except (OSError, ValueError, RecursionError, DocumentError) as error:
        why = str(error).splitlines()[0]
        message = f"the edit history can't be read ({why}); delete the file to start a new one"
        raise DocumentError(message, str(path)) from None


def restored(text: str, document: Document, limit: int = LIMIT) -> History:
    """Return the history that a text holds; a document that differs from its last one was changed outside."""
    kept = _Stored.model_validate_json(text)
    last = next(moment.text for moment in kept.moments if moment.number == kept.at)
    history = History.restored(read_text(last, document.source), kept.moments, kept.at, limit)
    if last != document.text:
        history.do(rewrite(history.document, document.text, OUTSIDE))
    return history
