"""Commands on whole nodes, and what the nodes around one say about it by its name.

That is the container's `initial`, `default`, `cases`, `exits`, `rules` and `wait_for`, and the `on` of siblings in a
machine.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from pydantic import Field

from grip_bt.base.errors import EditError
from grip_bt.base.frozen import FrozenDict

from ..model import AnyNode, Name, StateMachine
from ..walking import children_of
from .command import BaseCommand, said
from .draft import deep
from .editing import Editing, expect_free, expect_others, expect_room, slot
from .steps import Assign, Place


class Add(BaseCommand):
    """A new node in a container."""

    do: Literal["add"] = "add"
    parent: str
    name: Name
    node: FrozenDict[str, Any]
    """The node as it stands in a file, with whatever is below it."""
    index: int | None = Field(default=None, ge=0)
    """Position among the children; None: after the last."""

    def in_words(self) -> str:
        return f"add {self.name} to {said(self.parent)}"

    def plan(self, editing: Editing) -> None:
        container = editing.container(self.parent)
        expect_room(container, self.parent)
        expect_free(container, self.parent, self.name)
        at = (*editing.place(self.parent), slot(container))
        editing.put(at, self.name, dict(self.node), self.index)


class Remove(BaseCommand):
    """A node goes, with all below it, and with the edges and exits of its neighbours that name it.

    Where a state machine began with it, the machine begins with its first remaining child.
    """

    do: Literal["remove"] = "remove"
    path: str

    def in_words(self) -> str:
        return f"remove {said(self.path)}"

    def plan(self, editing: Editing) -> None:
        parent, name, container = editing.parent(
            self.path, "can't be removed; remove its children, or set another root"
        )
        expect_others(container, parent)
        forget(editing, parent, name)
        editing.drop((*editing.place(parent), slot(container)), name)


class Move(BaseCommand):
    """A node goes elsewhere: to another position, or into another container.

    In another container it loses its `on`, and its old neighbours lose what they said about it.
    """

    do: Literal["move"] = "move"
    path: str
    parent: str
    index: int | None = Field(default=None, ge=0)
    """Position among the new parent's children, counted without the node itself; None: after the last."""
    name: Name | None = None
    """Another name, where the new parent has a child of the old one."""

    def in_words(self) -> str:
        if (self.path.rpartition("/")[0] or "/") == self.parent:
            return f"reorder {self.path}"
        return f"move {self.path} into {said(self.parent)}"

    def plan(self, editing: Editing) -> None:
        parent, name, container = editing.parent(self.path, "can't be moved; wrap it in a container instead")
        target = editing.container(self.parent)
        if self.parent == parent:
            if self.name not in (None, name):
                raise EditError(self.path, "a move within a container keeps the name; rename it with `rename`")
            at = (*editing.place(parent), slot(container))
            editing.shift(at, name, at, self.index)
            return
        if self.parent == self.path or self.parent.startswith(f"{self.path}/"):
            raise EditError(self.path, f"can't go into {self.parent}, which is below it")
        expect_others(container, parent)
        expect_room(target, self.parent)
        to = self.name or name
        expect_free(target, self.parent, to)
        forget(editing, parent, name)
        at = (*editing.place(parent), slot(container))
        if "on" in editing.draft.mapping((*at, name)):
            editing.drop((*at, name), "on")
        into = (*editing.place(self.parent), slot(target))
        _carry(editing, at, name, into, to, self.index)


class Rename(BaseCommand):
    """A node is called `name`; `initial`, `on` and `exits` around it follow."""

    do: Literal["rename"] = "rename"
    path: str
    name: Name

    def in_words(self) -> str:
        return f"rename {said(self.path)} to {self.name}"

    def plan(self, editing: Editing) -> None:
        parent, name, container = editing.parent(self.path, "has no name; the task has one: set the task's `name`")
        if self.name == name:
            return
        expect_free(container, parent, self.name)
        follow(editing, parent, name, self.name)
        editing.rekey((*editing.place(parent), slot(container)), name, self.name)


def _carry(editing: Editing, at: tuple[str, ...], name: str, into: tuple[str, ...], to: str, index: int | None) -> None:
    """Shift an entry under a name that is free on both sides at each step."""
    if to == name:
        editing.shift(at, name, into, index)
    elif to not in editing.draft.mapping(at):
        editing.rekey(at, name, to)
        editing.shift(at, to, into, index)
    elif name not in editing.draft.mapping(into):
        editing.shift(at, name, into, index)
        editing.rekey(into, name, to)
    else:
        raise EditError(name, f"choose another name than {to!r}: both containers have one of these names")


_BY_CHILD = ("cases",)
"""Keys of containers that hold a mapping by names of children."""

_BY_END = ("exits",)
"""Keys of containers that hold a mapping by `child.outcome`."""


def forget(editing: Editing, parent: str, name: str) -> None:
    """Take out all that is said about the child `name`, which is about to leave."""
    container, place = editing.node(parent), editing.place(parent)
    for field in (*_BY_CHILD, *_BY_END):
        for key in editing.entries(place, field):
            if (child_of(key) if field in _BY_END else key) == name:
                editing.drop((*place, field), key)
    if editing.draft.mapping(place).get("default") == name:
        editing.drop(place, "default")
    _forget_in_lists(editing, place, name)
    for record, outcome in _edges_to(editing, container, place, name):
        editing.drop_in(record, "on", outcome)
    if isinstance(container, StateMachine) and container.initial == name:
        remaining = [child for child in children_of(container) if child != name]
        editing.set(place, "initial", remaining[0])


def follow(editing: Editing, parent: str, name: str, to: str) -> None:
    """Let all that is said about the child `name` be said about `to`."""
    container, place = editing.node(parent), editing.place(parent)
    if isinstance(container, StateMachine) and container.initial == name:
        editing.set(place, "initial", to)
    if editing.draft.mapping(place).get("default") == name:
        editing.set(place, "default", to)
    for field in _BY_CHILD:
        if name in editing.entries(place, field):
            editing.rekey((*place, field), name, to)
    _follow_in_lists(editing, place, name, to)
    follow_exits(editing, place, lambda child: to if child == name else child)
    for record, outcome in _edges_to(editing, container, place, name):
        editing.set((*record, "on"), outcome, to)


def follow_exits(editing: Editing, place: Place, renamed: Callable[[str], str]) -> None:
    """Rename the children that the keys of a container's `exits` begin with."""
    for field in _BY_END:
        for key in editing.entries(place, field):
            child, dot, outcome = key.partition(".")
            editing.rekey((*place, field), key, renamed(child) + dot + outcome)


def _lists(editing: Editing, place: Place) -> tuple[list[dict[str, Any]], list[Any]]:
    """Return the rules of a parallel, and the children that it waits for where these are named."""
    record = editing.draft.mapping(place)
    rules, awaited = deep(record.get("rules", [])), deep(record.get("wait_for", []))
    return rules, awaited if isinstance(awaited, list) else []


def _forget_in_lists(editing: Editing, place: Place, name: str) -> None:
    rules, awaited = _lists(editing, place)
    kept = [rule for rule in rules if name not in rule.get("when", {})]
    if len(kept) < len(rules):
        editing.set(place, "rules", kept) if kept else editing.drop(place, "rules")
    if name in awaited:
        others = [child for child in awaited if child != name]
        editing.set(place, "wait_for", others) if others else editing.drop(place, "wait_for")


def _follow_in_lists(editing: Editing, place: Place, name: str, to: str) -> None:
    rules, awaited = _lists(editing, place)
    for number, rule in enumerate(rules):
        if name in rule.get("when", {}):
            editing.rekey((*place, "rules", str(number), "when"), name, to)
    for number, child in enumerate(awaited):
        if child == name:
            editing.take(Assign(at=(*place, "wait_for"), key=str(number), value=to))


def child_of(key: str) -> str:
    """Return the child that a key of `exits` is about."""
    return key.partition(".")[0]


def _edges_to(editing: Editing, container: AnyNode, place: Place, name: str) -> list[tuple[Place, str]]:
    """Return the record and outcome of every edge to a child of a state machine."""
    if not isinstance(container, StateMachine):
        return []
    found = []
    for sibling, node in children_of(container).items():
        record = (*place, slot(container), sibling)
        found += [(record, outcome) for outcome, target in node.on.items() if target == name]
    return found
