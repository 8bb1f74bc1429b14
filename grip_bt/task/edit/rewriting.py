"""A text typed by a person as a command: the steps from the old task to the new one, and the very bytes.

So an edit of the text stands in the same history as every other, and what lives beside a task (layout, breakpoints,
a selection) follows it: a node that was only renamed, or put elsewhere among its siblings, keeps what belongs to it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..canonical import data_of
from ..document import Document, read_text
from ..shape import CHILDREN, FREE
from .commands import Patch, Restore, Splice
from .documents import digest_of
from .draft import deep
from .steps import Assign, Drop, Place, Put, Rekey, Shift, Step, is_record

TITLE = "edit the text"


def rewrite(document: Document, text: str, title: str = TITLE) -> Patch:
    """Return the command that gives a document another text.

    Raises:
        DocumentError: the text isn't a task.
    """
    after = read_text(text, document.source)
    steps = tuple(differences(_data(document), _data(after)))
    restore = Restore(digest=digest_of(document.text), splices=(_splice(document.text, text),))
    return Patch(title=title, steps=steps, restore=restore)


def _data(document: Document) -> dict[str, Any]:
    found = deep(data_of(document.task))
    assert isinstance(found, dict)
    return found


def differences(old: dict[str, Any], new: dict[str, Any], at: Place = ()) -> Iterator[Step]:
    """Yield steps that make one mapping of a file, at a place, into another one."""
    if is_record(at):
        yield from _of_record(old, new, at)
    else:
        yield from _of_list(old, new, at)
    for key, value in new.items():
        before = old.get(key, value)
        if isinstance(before, dict) and isinstance(value, dict):
            yield from differences(before, value, (*at, key))
        elif not alike(before, value):
            yield Assign(at=at, key=key, value=value)


def _of_record(old: dict[str, Any], new: dict[str, Any], at: Place) -> Iterator[Step]:
    """Drop and put the keys of a record; the order of free keys counts, so that they go and come when it changes."""
    free = [key for key in old if key.startswith(FREE)], [key for key in new if key.startswith(FREE)]
    again = free[0] if free[0] != free[1] else []
    for key in [k for k in old if k not in new or k in again]:
        old.pop(key)
        yield Drop(at=at, key=key)
    for key, value in new.items():
        if key not in old:
            old[key] = value
            yield Put(at=at, key=key, value=value)


def _of_list(old: dict[str, Any], new: dict[str, Any], at: Place) -> Iterator[Step]:
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


def _renamed(old: dict[str, Any], new: dict[str, Any], at: Place) -> Iterator[Step]:
    """Rename children whose name is all that has changed."""
    fresh = [key for key in new if key not in old]
    for gone in [key for key in old if key not in new]:
        match = next((key for key in fresh if alike(new[key], old[gone])), None)
        if match is not None:
            fresh.remove(match)
            entries = [(match if key == gone else key, value) for key, value in old.items()]
            old.clear()
            old.update(entries)
            yield Rekey(at=at, key=gone, to=match)


def alike(one: Any, other: Any) -> bool:
    """Tell whether two values stand for the same in a file: 1, 1.0 and true are three things, and order counts."""
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return list(one) == list(other) and all(alike(value, other[key]) for key, value in one.items())
    if isinstance(one, list):
        return len(one) == len(other) and all(alike(a, b) for a, b in zip(one, other, strict=True))
    return bool(one == other or (one != one and other != other))


def _splice(old: str, new: str) -> Splice:
    """Return the one piece in which two texts differ."""
    shorter = min(len(old), len(new))
    start = next((i for i in range(shorter) if old[i] != new[i]), shorter)
    end = next((i for i in range(shorter - start) if old[-1 - i] != new[-1 - i]), shorter - start)
    return Splice(start=start, old=old[start : len(old) - end], new=new[start : len(new) - end])
