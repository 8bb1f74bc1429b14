"""Commands applied to documents: the text changes only where the command does.

A text typed by a person is a command too: the steps from the old task to the new one, and the very bytes. So it stands
in the same history, and what lives beside a task (layout, breakpoints, a selection) follows it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass

from grip_bt.base.errors import DocumentError, EditError
from grip_bt.task.document import CHILDREN, Document, read_text
from grip_bt.task.model import Task
from grip_bt.task.parts import FREE_PREFIX

from ..canonical import file_data
from .commands import AnyCommand, Patch, apply
from .steps import Assign, Drop, Place, Put, Rekey, Shift, Step, is_record, path_after
from .text import Text


def alike(one: Task, other: Task) -> bool:
    """Tell whether two tasks are equal as JSON, in which edits are kept: values, their types, the order of entries.

    `==` takes 1 for True and 1.0, and doesn't look at the order of a mapping.
    """
    return one.model_dump_json() == other.model_dump_json()


@dataclass(frozen=True)
class Edited:
    """A document after a command.

    Attributes:
        steps: what was done, for whatever else follows the edit.
    """

    document: Document
    steps: tuple[Step, ...]

    def path(self, before: str) -> str | None:
        """Return where the node that was at a path is now; None when it is gone."""
        return path_after(before, self.steps)


def apply_to_document(document: Document, command: AnyCommand) -> Edited:
    """Return a document after a command; comments, and the formatting of everything else, stay.

    Raises:
        EditError: the command can't be carried out, or the text is formatted in a way that can't be changed in place;
            nothing has changed.
    """
    done = apply(document.task, command)
    if isinstance(command, Patch) and command.text is not None:
        text = command.text
    else:
        draft = Text(document.text)
        for step in done.steps:
            draft.take(step)
        draft.flush()
        text = draft.text
    return Edited(_read(text, document.source, done.task), done.steps)


def _read(text: str, source: str, expected: Task) -> Document:
    """Read an edited text, and make sure that it says what the edited task says."""
    try:
        after = read_text(text, source)
    except DocumentError as error:
        raise EditError("", f"can't be written here ({error.message}); run `grip fmt` and edit again") from error
    if not alike(after.task, expected):
        raise EditError("", "this formatting can't be edited in place; run `grip fmt` first")
    return after


TITLE = "edit the text"


def rewrite(document: Document, text: str, title: str = TITLE) -> Patch:
    """Return the command that gives a document another text; DocumentError where the text isn't a task."""
    after = read_text(text, document.source)
    steps = tuple(differences(file_data(document.task), file_data(after.task)))
    return Patch(title=title, steps=steps, text=text)


def differences(old: dict[str, object], new: dict[str, object], at: Place = ()) -> Iterator[Step]:
    """Yield steps that make one mapping of a file, at a place, into another one."""
    if is_record(at):
        yield from _of_record(old, new, at)
    else:
        yield from _of_list(old, new, at)
    for key, value in new.items():
        before = old.get(key, value)
        if isinstance(before, dict) and isinstance(value, dict):
            yield from differences(before, value, (*at, key))
        elif not _same_data(before, value):
            yield Assign(at=at, key=key, value=value)


def _of_record(old: dict[str, object], new: dict[str, object], at: Place) -> Iterator[Step]:
    """Drop and put the keys of a record; the order of free keys counts, so that they go and come when it changes."""
    free = [key for key in old if key.startswith(FREE_PREFIX)], [key for key in new if key.startswith(FREE_PREFIX)]
    again = free[0] if free[0] != free[1] else []
    for key in [k for k in old if k not in new or k in again]:
        old.pop(key)
        yield Drop(at=at, key=key)
    for key, value in new.items():
        if key not in old:
            old[key] = value
            yield Put(at=at, key=key, value=value)


def _of_list(old: dict[str, object], new: dict[str, object], at: Place) -> Iterator[Step]:
    """Make the keys of a list by name those of another one, in its order."""
    if at and at[-1] in CHILDREN:
        yield from _renamed(old, new, at)
    for key in [k for k in old if k not in new]:
        old.pop(key)
        yield Drop(at=at, key=key)
    order = list(old)
    for index, key in enumerate(new):
        if key not in old:
            old[key] = new[key]
            order.insert(index, key)
            yield Put(at=at, key=key, value=new[key], index=index)
        elif order[index] != key:
            order.remove(key)
            order.insert(index, key)
            yield Shift(at=at, key=key, to=at, index=index)


def _renamed(old: dict[str, object], new: dict[str, object], at: Place) -> Iterator[Step]:
    fresh = [key for key in new if key not in old]
    for gone in [key for key in old if key not in new]:
        match = next((key for key in fresh if _same_data(new[key], old[gone])), None)
        if match is not None:
            fresh.remove(match)
            entries = [(match if key == gone else key, value) for key, value in old.items()]
            old.clear()
            old.update(entries)
            yield Rekey(at=at, key=gone, to=match)


def _same_data(one: object, other: object) -> bool:
    """Tell whether two values stand for the same in a file: 1, 1.0 and true are three things, and order counts."""
    return one is other or json.dumps(one) == json.dumps(other)
