"""A task while it is being edited: plain data where an edit looked or changed something, the old models elsewhere.

Only what was opened is checked again when the edit ends; the rest of the new task is the old one's, shared.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from grip_bt.base.errors import EditError

from ..canonical import data_of, file_data
from ..model import Task
from ..parts import FREE_PREFIX
from .steps import Assign, Drop, Place, Put, Rekey, Remark, Shift, Step, is_head, is_record


class _Open(dict[str, object]):
    """A mapping that belongs to the draft and may be changed."""


class _OpenList(list[object]):
    """A list that belongs to the draft and may be changed; its keys are `0`, `1` ..."""


class Draft:
    """The data of a task's file, opened where it is needed."""

    def __init__(self, task: Task):
        self._top = _Open(data_of(task))

    def mapping(self, at: Place) -> dict[str, object]:
        """Return the mapping at a place, to read.

        Raises:
            EditError: there is none.
        """
        current: Any = self._top
        for depth, key in enumerate(at):
            if not _has(current, key):
                raise EditError("/".join(at[:depth]), f"there is no {key!r}")
            index = _index(current, key)
            inner = current[index] = _opened(current[index])
            current = inner
            if not isinstance(current, _Open | _OpenList):
                raise EditError("/".join(at[:depth]), f"{key!r} holds nothing")
        return current  # type: ignore[no-any-return]

    def apply(self, step: Step) -> Step:
        """Do one step and return its inverse.

        Raises:
            EditError: an entry isn't there, or is there already; nothing is changed.
        """
        inside = self.mapping(step.at)
        if isinstance(step, Put):
            _expect(inside, step.at, step.key, False)
            _insert(inside, step.at, step.key, step.value, step.index)
            return Drop(at=step.at, key=step.key)
        if not is_head(step):
            _expect(inside, step.at, step.key, True)
        if isinstance(step, Remark):
            # a task knows no comments: who has the text fills in what was there
            return step.model_copy(update={"text": ""})
        if isinstance(step, Drop):
            order = position(inside, step.at, step.key)
            return Put(at=step.at, key=step.key, value=file_data(inside.pop(step.key)), index=order)
        if isinstance(step, Assign):
            index = _index(inside, step.key)
            before = file_data(inside[index])
            inside[index] = step.value
            return Assign(at=step.at, key=step.key, value=before)
        if isinstance(step, Rekey):
            _expect(inside, step.at, step.to, False)
            entries = [(step.to if key == step.key else key, value) for key, value in inside.items()]
            inside.clear()
            inside.update(entries)
            return Rekey(at=step.at, key=step.to, to=step.key)
        return self._shift(inside, step)

    def _shift(self, inside: dict[str, object], step: Shift) -> Step:
        if step.to[: len(step.at) + 1] == (*step.at, step.key):
            raise EditError("/".join(step.at), f"{step.key!r} can't go into itself")
        into = self.mapping(step.to)
        if into is not inside:
            _expect(into, step.to, step.key, False)
        index = position(inside, step.at, step.key)
        value = inside.pop(step.key)
        _insert(into, step.to, step.key, value, step.index)
        return Shift(at=step.to, key=step.key, to=step.at, index=index)

    def task(self, where: str) -> Task:
        """Return the task that the draft has become.

        Raises:
            EditError: it isn't one; `where` is what the message speaks about.
        """
        try:
            return Task.model_validate(_closed(self._top), strict=True, by_name=False)
        except ValidationError as error:
            faults = "; ".join(dict.fromkeys(_said(e) for e in error.errors()))
            raise EditError(where, faults) from None


def _opened(value: object) -> object:
    if isinstance(value, BaseModel):
        return _Open(data_of(value))
    if isinstance(value, dict):
        return value if isinstance(value, _Open) else _Open(value)
    if isinstance(value, list | tuple):
        return value if isinstance(value, _OpenList) else _OpenList(value)
    return value


def _index(inside: object, key: str) -> Any:
    return int(key) if isinstance(inside, list) else key


def _has(inside: Collection[object], key: str) -> bool:
    return key.isdecimal() and int(key) < len(inside) if isinstance(inside, list) else key in inside


def position(mapping: dict[str, object], at: Place, key: str) -> int | None:
    """Return the position of an entry among those whose order counts; None where the order of keys is fixed."""
    ordered = _ordered(mapping, at, key)
    return None if ordered is None else ordered.index(key)


def _ordered(mapping: dict[str, object], at: Place, key: str) -> list[str] | None:
    if not is_record(at):
        return list(mapping)
    return [k for k in mapping if k.startswith(FREE_PREFIX)] if key.startswith(FREE_PREFIX) else None


def _insert(mapping: dict[str, object], at: Place, key: str, value: object, index: int | None) -> None:
    ordered = _ordered(mapping, at, key)
    following = ordered[index:] if ordered is not None and index is not None else []
    moved = [(k, mapping.pop(k)) for k in following]
    mapping[key] = value
    mapping.update(moved)


def _expect(mapping: dict[str, object], at: Place, key: str, present: bool) -> None:
    if _has(mapping, key) != present:
        where = "/".join(at) or "the task"
        raise EditError(where, f"there is no {key!r}" if present else f"there is a {key!r} already")


def _closed(value: object) -> object:
    """Return a copy that the new task may keep; models that weren't opened are shared."""
    if isinstance(value, dict):
        return {key: _closed(inner) for key, inner in value.items()}
    return [_closed(inner) for inner in value] if isinstance(value, list | tuple) else value


def _said(error: ErrorDetails) -> str:
    at = "/".join(str(step) for step in error["loc"][-2:] if step not in ("children", "child", "leaf"))
    if error["type"] == "missing":
        return f"the key {str(error['loc'][-1])!r} is missing"
    if error["type"] == "extra_forbidden":
        return f"there is no key {str(error['loc'][-1])!r}; keys are those of the file"
    if error["type"] == "string_pattern_mismatch":
        return f"{error['input']!r} isn't a name: letters, digits, _, - and spaces, a letter or _ first"
    return f"{at}: {error['msg']}"
