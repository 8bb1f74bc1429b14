"""The six things that an edit can do to a task file, and where; every command is a list of them.

A place is the keys on the way to a mapping of the file: `("root", "children", "look", "in")`; in a list the keys are
`0`, `1` ... (its entries are renamed within and assigned, not put, dropped or shifted). The same steps are
applied to the models (`draft`) and to the text (`text`), so the two can't drift apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from grip_bt.task.model import join

from ..document import CHILDREN, key_rank
from ..parts import FREE_PREFIX

Place = tuple[str, ...]


class _Step(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    at: Place
    key: str


class Put(_Step):
    """A new entry `key` in the mapping at `at`."""

    step: Literal["put"] = "put"
    value: object
    index: int | None = None
    """Position among the entries whose order counts; None: at the end."""


class Drop(_Step):
    """The entry `key` of the mapping at `at` goes."""

    step: Literal["drop"] = "drop"


class Rekey(_Step):
    """The entry `key` of the mapping at `at` is called `to`, and stays where it is."""

    step: Literal["rekey"] = "rekey"
    to: str


class Assign(_Step):
    """The entry `key` of the mapping at `at` has another value."""

    step: Literal["assign"] = "assign"
    value: object


class Shift(_Step):
    """The entry `key` of the mapping at `at` goes to the mapping at `to`, or to another position in its own."""

    step: Literal["shift"] = "shift"
    to: Place
    index: int | None = None
    """Position in `to`, counted without the entry itself; None: at the end."""


FILE_COMMENT = ""
"""What a `Remark` at the top has as its key when it is about the comment of the file, and not of an entry."""


class Remark(_Step):
    """The entry `key` of the mapping at `at` has another comment; nothing of what the task does changes."""

    step: Literal["remark"] = "remark"
    text: str
    """Its lines without `#`; empty for none."""


Step = Annotated[Put | Drop | Rekey | Assign | Shift | Remark, Field(discriminator="step")]


def is_head(step: Step) -> bool:
    """Tell whether a step is about the comment at the top of the file."""
    return isinstance(step, Remark) and step.at == () and step.key == FILE_COMMENT


def is_record(at: Place) -> bool:
    """Tell whether a place is a task, a node or a variable, whose keys have a fixed order, and not a list by name."""
    if at[:1] != ("root",):
        return at == () or (len(at) == 2 and at[0] == "data")
    inner = at[1:]
    while inner and inner[0] in CHILDREN:
        if len(inner) == 1:
            return False
        inner = inner[2:]
    return inner == () or (len(inner) == 2 and inner[0] == "data")


def position_of(at: Place, keys: list[str], key: str, index: int | None) -> int:
    """Return before which of the keys a new one stands."""
    if not is_record(at):
        return len(keys) if index is None else min(index, len(keys))
    if key.startswith(FREE_PREFIX):
        free = [position for position, other in enumerate(keys) if other.startswith(FREE_PREFIX)]
        if index is not None and index < len(free):
            return free[index]
        if free:
            return free[-1] + 1
    rank = key_rank(key)
    lower = [position for position, other in enumerate(keys) if key_rank(other) <= rank]
    return lower[-1] + 1 if lower else 0


def path_of(place: Place) -> str | None:
    """Return the path of the node at a place; None when no node is there."""
    if place[:1] != ("root",) or len(place) % 2 == 0 or any(key not in CHILDREN for key in place[1::2]):
        return None
    path = "/"
    for name in place[2::2]:
        path = join(path, name)
    return path


def path_after(path: str, steps: Iterable[Step]) -> str | None:
    """Return where the node that was at `path` is after some steps; None when it is gone.

    What lives beside a task and speaks about its nodes (layout, breakpoints, a selection) follows an edit by this.
    """
    names: tuple[str, ...] = () if path == "/" else tuple(path.split("/"))
    where: tuple[str, ...] | None = ("root", *names)
    for step in steps:
        if where is None:
            return None
        where = _after(where, step)
    if where is None or where[0] != "root":
        return None
    return "/".join(where[1:]) or "/"


def backwards(steps: Iterable[Step]) -> tuple[Step, ...]:
    """Return steps that lead nodes back to where they were, for `path_after`; values aren't those that there were."""
    return tuple(_backwards(step) for step in reversed(tuple(steps)))


def _backwards(step: Step) -> Step:
    match step:
        case Put():
            return Drop(at=step.at, key=step.key)
        case Drop():
            return Put(at=step.at, key=step.key, value=None)
        case Rekey():
            return Rekey(at=step.at, key=step.to, to=step.key)
        case Shift():
            return Shift(at=step.to, key=step.key, to=step.at)
    return step


def _after(where: tuple[str, ...], step: Step) -> tuple[str, ...] | None:
    if isinstance(step, Put):
        return where
    at = _names(step.at)
    if at is None or where[: len(at) + 1] != (*at, step.key):
        return where
    below = where[len(at) + 1 :]
    if isinstance(step, Drop):
        return None
    if isinstance(step, Rekey):
        return (*at, step.to, *below)
    if isinstance(step, Shift):
        to = _names(step.to)
        return None if to is None else (*to, step.key, *below)
    return where


def _names(at: Place) -> tuple[str, ...] | None:
    """Return the names on the way to a mapping of nodes; None for any other mapping."""
    if at == ():
        return ()
    if len(at) % 2 or any(key not in CHILDREN for key in at[1::2]):
        return None
    return at[::2]
