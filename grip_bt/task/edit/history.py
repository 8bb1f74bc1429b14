"""Undo and redo over commands, with branches: what was undone and then overwritten stays reachable."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from grip_bt.base.errors import DocumentError, EditError
from grip_bt.base.files import replace_text

from ..document import Document, read_text
from .commands import AnyCommand, Patch, title_of
from .documents import Edited, apply_to_document, rewrite

LIMIT = 1000
"""Moments that a history holds, unless it is told otherwise."""
VERSION = 1
LARGEST = 20_000_000
"""Bytes of a file; a larger history is stored without its oldest moments."""
OUTSIDE = "changed outside"


class Moment(BaseModel):
    """One state of a document in a history, with the way from and to the one before."""

    model_config = ConfigDict(extra="forbid")

    number: Annotated[int, Field(ge=0)]
    """0 is what the history began with."""
    parent: int | None
    """The moment that it was made from; None for the first."""
    title: str
    """What was done, in a few words."""
    back: Patch | None = None
    forth: Patch | None = None
    children: list[int] = []
    """The moments made from it, the one left last at the end."""


class History:
    """A document and everything that was done to it.

    A command after an undo begins a new branch; `redo` takes the youngest, `go` leads to any moment of any branch.
    """

    def __init__(self, document: Document, limit: int = LIMIT):
        self._moments = {0: Moment(number=0, parent=None, title="opened")}
        self._at = 0
        self._next = 1
        self._limit = max(limit, 1)
        self._document = document

    @classmethod
    def restored(cls, document: Document, moments: Iterable[Moment], at: int, limit: int = LIMIT) -> History:
        """Return a history as it was: its document, its moments, and the number of the one at which it is."""
        history = cls(document, limit)
        history._moments = {each.number: each.model_copy(update={"children": [*each.children]}) for each in moments}
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
        return self._moments[self._at].back is not None

    @property
    def can_redo(self) -> bool:
        """Whether something was undone here that can be done again."""
        return bool(self._moments[self._at].children)

    def do(self, command: AnyCommand) -> Edited:
        """Carry out a command (one gesture: several are a `Group`) and keep how to undo it.

        Raises:
            EditError: it can't be carried out; nothing has changed.
        """
        edited = apply_to_document(self._document, command)
        number, self._next = self._next, self._next + 1
        self._moments[number] = Moment(number=number, parent=self._at, title=title_of(command), back=edited.inverse)
        self._moments[self._at].children.append(number)
        self._at, self._document = number, edited.document
        self._forget()
        return edited

    def undo(self) -> Edited:
        """Go to the moment before; EditError where this is the first."""
        moment = self._moments[self._at]
        if moment.back is None or moment.parent is None:
            raise EditError("", "there is nothing to undo")
        edited = apply_to_document(self._document, moment.back)
        moment.forth = edited.inverse
        self._take(moment.parent, moment.number, edited)
        return edited

    def redo(self, number: int | None = None) -> Edited:
        """Go to a moment that was made from this one: to the one of this number, or to the one that was left last.

        Raises:
            EditError: nothing was undone here, or there is no such moment.
        """
        children = self._moments[self._at].children
        if not children or (number is not None and number not in children):
            wrong = f"revision {number} doesn't follow from the current one"
            raise EditError("", "there is nothing to redo" if number is None else wrong)
        moment = self._moments[children[-1] if number is None else number]
        assert moment.forth is not None
        edited = apply_to_document(self._document, moment.forth)
        moment.back = edited.inverse
        self._take(moment.number, moment.number, edited)
        return edited

    def go(self, number: int) -> tuple[Edited, ...]:
        """Go to any moment, over undo and redo; return what was done on the way.

        Raises:
            EditError: there is no such moment.
        """
        if number not in self._moments:
            forgotten = " any more" if 0 <= number < self._next else ""
            raise EditError("", f"there is no revision {number}{forgotten}; the last is {max(self._moments)}")
        up = self._line(self._at)
        down = []
        at: int = number
        while at not in up:
            down.append(at)
            parent = self._moments[at].parent
            assert parent is not None
            at = parent
        done = [self.undo() for _ in range(up.index(at))]
        return (*done, *(self.redo(step) for step in reversed(down)))

    def _forget(self) -> None:
        """Keep no more moments than the limit; numbers stay."""
        while len(self._moments) > self._limit:
            line = set(self._line(self._at))
            loose = next((n for n, moment in self._moments.items() if n not in line and not moment.children), None)
            gone = self._moments.pop(next(iter(self._moments)) if loose is None else loose)
            if gone.parent is not None:
                self._moments[gone.parent].children.remove(gone.number)
            else:
                begin = self._moments[gone.children[0]]
                begin.parent = begin.back = begin.forth = None

    def _line(self, number: int) -> list[int]:
        line: list[int] = []
        at: int | None = number
        while at is not None:
            line.append(at)
            at = self._moments[at].parent
        return line

    def _take(self, number: int, used: int, edited: Edited) -> None:
        parent = self._moments[used].parent
        assert parent is not None
        siblings = self._moments[parent].children
        siblings.remove(used)
        siblings.append(used)
        self._at, self._document = number, edited.document


class _Stored(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    grip_history: Literal[1]
    text: str
    at: int
    moments: list[Moment] = Field(min_length=1)


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
    made = _Stored(grip_history=1, text=history.document.text, at=history.at.number, moments=list(history.moments))
    return json.dumps(made.model_dump(mode="json"), ensure_ascii=False) + "\n"


def load_history(path: Path, document: Document, limit: int = LIMIT) -> History:
    """Return the history of a task whose file holds `document` now; a new one where there is no file.

    Raises:
        DocumentError: the file is damaged or of a newer version; delete it, and begin with a new history.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return History(document, limit)
    except (OSError, UnicodeDecodeError) as error:
        message = f"the edit history can't be read: {error}; delete the file to start a new one"
        raise DocumentError(message, str(path)) from None
    history = restored(text, document.source, limit, str(path))
    if history.document.text != document.text:
        history.do(rewrite(history.document, document.text, OUTSIDE))
    return history


def restored(text: str, source: str, limit: int = LIMIT, where: str = "") -> History:
    """Return the history that a text holds; `source` names its task and `where` the file in messages.

    Raises:
        DocumentError: it holds none.
    """
    try:
        found = json.loads(text)
        version = found.get("grip_history") if isinstance(found, dict) else None
        if isinstance(version, int) and version > VERSION:
            newer = f"version {version} of the edit history is newer than this version of GRIP reads ({VERSION})"
            raise DocumentError(f"{newer}; run `pip install -U grip-bt`", where)
        kept = _checked(_Stored.model_validate_json(text))
        document = read_text(kept.text, source)
    except DocumentError as error:
        if where == error.source:
            raise
        raise _corrupt(error.message, where) from None
    except (ValueError, RecursionError) as error:
        raise _corrupt(str(error), where) from None
    return History.restored(document, kept.moments, kept.at, limit)


def _corrupt(words: str, where: str) -> DocumentError:
    message = f"the edit history is corrupt ({words.splitlines()[0]}); delete the file to start a new one"
    return DocumentError(message, where)


def _checked(found: _Stored) -> _Stored:
    """Refuse moments that aren't one tree with a way back from each; ValueError where they aren't."""
    numbers = [m.number for m in found.moments]
    parents = {m.number: m.parent for m in found.moments}
    children = sorted((m.number, child) for m in found.moments for child in m.children)
    if numbers != sorted(set(numbers)) or found.at not in parents:
        raise ValueError("moments without an order")
    if children != sorted((parent, n) for n, parent in parents.items() if parent is not None):
        raise ValueError("moments that don't hang together")
    if any(parent is None for parent in list(parents.values())[1:]) or parents[numbers[0]] is not None:
        raise ValueError("moments without a beginning")
    if any(parent >= n for n, parent in parents.items() if parent is not None):
        raise ValueError("moments before their parents")
    line: set[int | None] = {found.at}
    for number in reversed(numbers):
        line |= {parents[number]} if number in line else set()
    if any((m.back is None) != (m.parent is None) or (m.forth is None and m.number not in line) for m in found.moments):
        raise ValueError("moments without a way back or forth")
    return found
