"""A history as a file beside its task: `tasks/.grip/history/pick.yaml.json`.

It holds the text that the history ended with and the way from each moment to its neighbours. When the task's file was
changed since by something else, that change is one more moment, so that nothing that was done before is lost.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from grip_bt.base.errors import DocumentError
from grip_bt.base.files import replace_text

from ..document import Document, read_text
from .commands import Patch
from .history import LIMIT, History, Kept, Moment
from .rewriting import rewrite

VERSION = 1
LARGEST = 20_000_000
"""Bytes of a file; a larger history is stored without its oldest moments."""
OUTSIDE = "changed outside"


class _StoredMoment(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    number: Annotated[int, Field(ge=0)]
    parent: int | None
    title: str
    back: Patch | None
    forth: Patch | None
    children: list[int]


class _Stored(BaseModel):
    """What the file holds."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    grip_history: Literal[1]
    text: str
    at: int
    moments: list[_StoredMoment] = Field(min_length=1)


def history_path(task: Path | str) -> Path:
    """Return where the history of a task file is kept."""
    task = Path(task)
    return task.parent / ".grip" / "history" / f"{task.name}.json"


def save_history(history: History, path: Path) -> None:
    """Write a history in one step: whoever reads the file sees the old one or the new one.

    Raises:
        DocumentError: it can't be written.
    """
    text, limit = stored(history), len(history.kept)
    while len(text.encode()) > LARGEST and limit > 1:
        limit //= 2
        history = History.restored(history.document, history.kept, history.at.number, limit)
        text = stored(history)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_text(path, text)
    except OSError as error:
        raise DocumentError(f"can't be written: {error.strerror or error}", str(path)) from error


def stored(history: History) -> str:
    """Return a history as the text of its file."""
    moments = [
        _StoredMoment(
            number=each.moment.number,
            parent=each.moment.parent,
            title=each.moment.title,
            back=each.back,
            forth=each.forth,
            children=each.children,
        )
        for each in history.kept
    ]
    made = _Stored(grip_history=1, text=history.document.text, at=history.at.number, moments=moments)
    return json.dumps(made.model_dump(mode="json"), ensure_ascii=False) + "\n"


def load_history(path: Path, document: Document, limit: int = LIMIT) -> History:
    """Return the history of a task whose file holds `document` now; a new one where there is no file.

    Args:
        path: the history's file, as `history_path` names it.
        document: the task as it is.
        limit: moments that the history holds.

    Raises:
        DocumentError: the file is damaged or of a newer version; delete it, and begin with a new history.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return History(document, limit)
    except (OSError, UnicodeDecodeError) as error:
        raise DocumentError(f"the history can't be read: {error}; delete it to begin anew", str(path)) from None
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
            raise DocumentError(f"a history of version {version}, and this grip reads {VERSION}; update grip", where)
        kept = _checked(_Stored.model_validate_json(text))
        document = read_text(kept.text, source)
    except (ValueError, ValidationError, RecursionError) as error:
        words = str(error).splitlines()[0]
        raise DocumentError(f"the history is damaged ({words}); delete it to begin anew", where) from None
    except DocumentError as error:
        if where == error.source:
            raise
        words = error.message.splitlines()[0]
        raise DocumentError(f"the history is damaged ({words}); delete it to begin anew", where) from None
    moments = [Kept(Moment(m.number, m.parent, m.title), m.back, m.forth, list(m.children)) for m in kept.moments]
    return History.restored(document, moments, kept.at, limit)


def _checked(found: _Stored) -> _Stored:
    """Refuse moments that aren't one tree with a way back from each.

    Raises:
        ValueError: they aren't.
    """
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
