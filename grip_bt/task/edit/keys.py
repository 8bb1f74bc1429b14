"""Commands on single keys of a node or of the task."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.base.errors import EditError, listing, nearest

from ..document import CHILDREN, keys_of
from ..model import Meaning, StateMachine, children_of, kind_of, outcomes_of
from ..parts import FREE_PREFIX
from .editing import Edit, PathCommand, path_in_words
from .steps import Place

_STRUCTURE = {
    "grip": "the version of the format stays",
    "kind": "use `change_kind`",
    "root": "use `add`, `wrap` or `move`",
    **dict.fromkeys(CHILDREN, "use `add`, `remove` or `move`"),
}

_IN_WORDS: dict[tuple[str, ...], str] = {
    ("doc",): "documentation",
    ("with",): "parameters",
    ("in",): "inputs",
    ("out",): "outputs",
}
_PORTS = {"in": "reads", "out": "writes"}


class Set(PathCommand):
    """A key of a node or of the task has a value: `["times"]`, `["with", "arm"]`, `["in", "cloud"]`, `["x-note"]`."""

    do: Literal["set"] = "set"
    key: tuple[str, ...] = Field(min_length=1)
    value: object

    def in_words(self) -> str:
        if self.key[0] in _PORTS and len(self.key) == 2:
            return f"{self.key[1]} of {path_in_words(self.path)} {_PORTS[self.key[0]]} {self.value}"
        return f"set {_key(self.path, self.key)}{_value(self.value)}"

    def plan(self, edit: Edit) -> None:
        place, *inner = _keys(edit, self.path, self.key)
        *above, last = inner
        for depth, key in enumerate(above):
            at = (*place, *above[:depth])
            if key not in edit.draft.mapping(at):
                value = self.value
                for below in reversed(inner[depth + 1 :]):
                    value = {below: value}
                edit.put(at, key, value)
                return
        edit.set((*place, *above), last, self.value)


class Unset(PathCommand):
    """A key of a node or of the task goes, so that its default holds."""

    do: Literal["unset"] = "unset"
    key: tuple[str, ...] = Field(min_length=1)

    def in_words(self) -> str:
        if self.key[0] in _PORTS and len(self.key) == 2:
            return f"{self.key[1]} of {path_in_words(self.path)} {_PORTS[self.key[0]]} no variable"
        return f"unset {_key(self.path, self.key)}"

    def plan(self, edit: Edit) -> None:
        place, *inner = _keys(edit, self.path, self.key)
        *above, last = inner
        if len(above) != 1:
            edit.drop((*place, *above), last)
            return
        there = edit.entries(place, above[0])
        if last not in there:
            message = f"`{above[0]}` has no {last!r}{nearest(last, there)} (available: {listing(there)})"
            raise EditError(self.path, message)
        edit.drop_in(place, above[0], last)


class Connect(PathCommand):
    """An outcome of a node leads to `target`.

    In a state machine to a sibling or to an outcome of the machine; at the root to an outcome of the task; in any other
    container to one of its outcomes (an entry of its `exits`).
    """

    do: Literal["connect"] = "connect"
    words: ClassVar[str] = "connect {outcome} of {path} to {target}"
    outcome: str
    """An outcome, or `outcome.code`."""
    target: str

    def plan(self, edit: Edit) -> None:
        record, field, key = _edge(edit, self.path, self.outcome)
        allowed = list(edit.task.outcomes)
        if self.path != "/":
            container = edit.parent(self.path, "")[2]
            siblings = children_of(container) if isinstance(container, StateMachine) else ()
            allowed = [*siblings, *outcomes_of(container)]  # type: ignore[arg-type]
        if self.target not in allowed:
            message = f"can't be connected to {self.target!r}{nearest(self.target, allowed)} (available: "
            hint = "" if field == "on" else "; edges between siblings need a state_machine: `change_kind`"
            raise EditError(self.path, f"{message}{listing(allowed)}){hint}")
        edit.set_in(record, field, key, self.target)


class Disconnect(PathCommand):
    """An outcome of a node isn't connected any more."""

    do: Literal["disconnect"] = "disconnect"
    words: ClassVar[str] = "disconnect {outcome} of {path}"
    outcome: str

    def plan(self, edit: Edit) -> None:
        record, field, key = _edge(edit, self.path, self.outcome)
        there = edit.entries(record, field)
        if key not in there:
            ends = [k.removeprefix(f"{self.path.rpartition('/')[2]}.") for k in there]
            raise EditError(self.path, f"{self.outcome!r} isn't connected (connected: {listing(ends)})")
        edit.drop_in(record, field, key)


class SetMeaning(PathCommand):
    """An outcome of a node, or of the task, means success or failure; for a leaf, None is what its manifest says."""

    do: Literal["set_meaning"] = "set_meaning"
    outcome: str
    meaning: Meaning | None

    def in_words(self) -> str:
        return f"{self.outcome} of {path_in_words(self.path)} means {self.meaning or 'what its manifest says'}"

    def plan(self, edit: Edit) -> None:
        place = edit.place(self.path)
        holder = edit.task if self.path == "" else edit.node(self.path)
        if "meaning" in type(holder).model_fields:
            if self.meaning is not None:
                edit.set_in(place, "meaning", self.outcome, self.meaning)
            elif self.outcome in edit.entries(place, "meaning"):
                edit.drop_in(place, "meaning", self.outcome)
            return
        if "outcomes" not in type(holder).model_fields:
            raise EditError(self.path, f"the outcomes of a {kind_of(holder)} keep their meanings")
        if self.meaning is None:
            raise EditError(self.path, f"the outcome {self.outcome!r} needs a meaning: success or failure")
        if self.path == "" and "outcomes" not in edit.draft.mapping(()):
            edit.put((), "outcomes", {**edit.task.outcomes, self.outcome: self.meaning})
        else:
            edit.set_in(place, "outcomes", self.outcome, self.meaning)


def _key(path: str, key: tuple[str, ...]) -> str:
    key = key[1:] if key[0] == "with" and len(key) > 1 else key
    return f"{_IN_WORDS.get(key, '/'.join(key))} of {path_in_words(path)}"


def _value(value: object) -> str:
    if isinstance(value, bool):
        return " to yes" if value else " to no"
    if isinstance(value, int | float | str) and 0 < len(str(value)) <= 20:
        return f" to {value}"
    return ""


def _keys(edit: Edit, path: str, key: tuple[str, ...]) -> tuple[Place, *tuple[str, ...]]:
    shape = type(edit.task if path == "" else edit.node(path))
    allowed = keys_of(shape)
    first = key[0]
    if first in _STRUCTURE:
        raise EditError(path, f"{first!r} isn't set like other keys: {_STRUCTURE[first]}")
    if first not in allowed and not first.startswith(FREE_PREFIX):
        raise EditError(path, f"there is no key {first!r}{nearest(first, allowed)} (available: {listing(allowed)})")
    return (edit.place(path), *key)


def _edge(edit: Edit, path: str, outcome: str) -> tuple[Place, str, str]:
    if path == "/" or isinstance(edit.parent(path, "")[2], StateMachine):
        return edit.place(path), "on", outcome
    above, name, _ = edit.parent(path, "")
    return edit.place(above), "exits", f"{name}.{outcome}"
