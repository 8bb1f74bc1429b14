"""Commands on whole nodes, and what the nodes around one say about it by its name."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.base.errors import EditError
from grip_bt.base.frozen import FrozenDict

from ..canonical import file_data
from ..model import Name, StateMachine, children_of
from .editing import BaseCommand, Edit, PathCommand, expect_free, expect_others, expect_room, path_in_words, slot
from .steps import Assign, Place


class Add(BaseCommand):
    """A new node in a container."""

    do: Literal["add"] = "add"
    words: ClassVar[str] = "add {name} to {parent}"
    parent: str
    name: Name
    node: FrozenDict[str, object]
    """The node as it stands in a file, with whatever is below it."""
    index: int | None = Field(default=None, ge=0)
    """Position among the children; None: after the last."""

    def plan(self, edit: Edit) -> None:
        container = edit.container(self.parent)
        expect_room(container, self.parent)
        expect_free(container, self.parent, self.name)
        at = (*edit.place(self.parent), slot(container))
        edit.put(at, self.name, dict(self.node), self.index)


class Remove(PathCommand):
    """A node goes, with all below it, and with the edges and exits of its neighbours that name it.

    Where a state machine began with it, the machine begins with its first remaining child.
    """

    do: Literal["remove"] = "remove"
    words: ClassVar[str] = "remove {path}"

    def plan(self, edit: Edit) -> None:
        parent, name, container = edit.parent(self.path, "can't be removed; remove its children, or set another root")
        expect_others(container, parent)
        redirect(edit, parent, name, None)
        edit.drop((*edit.place(parent), slot(container)), name)


class Move(PathCommand):
    """A node goes elsewhere: to another position, or into another container.

    In another container it loses its `on`, and its old neighbours lose what they said about it.
    """

    do: Literal["move"] = "move"
    parent: str
    index: int | None = Field(default=None, ge=0)
    """Position among the new parent's children, counted without the node itself; None: after the last."""
    name: Name | None = None
    """Another name, where the new parent has a child of the old one."""

    def in_words(self) -> str:
        if (self.path.rpartition("/")[0] or "/") == self.parent:
            return f"reorder {self.path}"
        return f"move {self.path} into {path_in_words(self.parent)}"

    def plan(self, edit: Edit) -> None:
        parent, name, container = edit.parent(self.path, "can't be moved; wrap it in a container instead")
        target = edit.container(self.parent)
        if self.parent == parent:
            if self.name not in (None, name):
                raise EditError(self.path, "a move within a container keeps the name; rename it with `rename`")
            at = (*edit.place(parent), slot(container))
            edit.shift(at, name, at, self.index)
            return
        if self.parent == self.path or self.parent.startswith(f"{self.path}/"):
            raise EditError(self.path, f"can't be moved into its own descendant {self.parent}")
        expect_others(container, parent)
        expect_room(target, self.parent)
        to = self.name or name
        expect_free(target, self.parent, to)
        redirect(edit, parent, name, None)
        at = (*edit.place(parent), slot(container))
        if "on" in edit.draft.mapping((*at, name)):
            edit.drop((*at, name), "on")
        into = (*edit.place(self.parent), slot(target))
        _carry(edit, at, name, into, to, self.index)


class Rename(PathCommand):
    """A node is called `name`; `initial`, `on` and `exits` around it follow."""

    do: Literal["rename"] = "rename"
    words: ClassVar[str] = "rename {path} to {name}"
    name: Name

    def plan(self, edit: Edit) -> None:
        parent, name, container = edit.parent(self.path, "has no name; the task has one: set the task's `name`")
        if self.name == name:
            return
        expect_free(container, parent, self.name)
        redirect(edit, parent, name, self.name)
        edit.rekey((*edit.place(parent), slot(container)), name, self.name)


def _carry(edit: Edit, at: tuple[str, ...], name: str, into: tuple[str, ...], to: str, index: int | None) -> None:
    if to == name:
        edit.shift(at, name, into, index)
    elif to not in edit.draft.mapping(at):
        edit.rekey(at, name, to)
        edit.shift(at, to, into, index)
    elif name not in edit.draft.mapping(into):
        edit.shift(at, name, into, index)
        edit.rekey(into, name, to)
    else:
        raise EditError(name, f"choose another name than {to!r}: both containers have one of these names")


_KEYED_BY_CHILD = ("cases", "exits")
"""Keys of containers that hold a mapping by names of children, or by `child.outcome`."""


def redirect(edit: Edit, parent: str, name: str, to: str | None) -> None:
    """Let all that is said about the child `name` be said about `to`; take it out for None, as the child leaves."""
    container, place = edit.node(parent), edit.place(parent)
    if isinstance(container, StateMachine) and container.initial == name:
        edit.set(place, "initial", to or next(child for child in children_of(container) if child != name))
    for field in _KEYED_BY_CHILD:
        for key in edit.entries(place, field):
            child, dot, outcome = key.partition(".")
            if child == name:
                edit.drop((*place, field), key) if to is None else edit.rekey((*place, field), key, to + dot + outcome)
    if edit.draft.mapping(place).get("default") == name:
        edit.drop(place, "default") if to is None else edit.set(place, "default", to)
    _redirect_lists(edit, place, name, to)
    for sibling, node in children_of(container).items() if isinstance(container, StateMachine) else ():
        record = (*place, slot(container), sibling)
        for outcome in [outcome for outcome, target in node.on.items() if target == name]:
            edit.drop_in(record, "on", outcome) if to is None else edit.set((*record, "on"), outcome, to)


def _redirect_lists(edit: Edit, place: Place, name: str, to: str | None) -> None:
    """Redirect the rules of a parallel, and the children that it waits for where these are named."""
    record = edit.draft.mapping(place)
    rules, awaited = file_data(record.get("rules", [])), file_data(record.get("wait_for", []))
    about = [number for number, rule in enumerate(rules) if name in rule.get("when", {})]
    if to is not None:
        for number in about:
            edit.rekey((*place, "rules", str(number), "when"), name, to)
        for number, child in enumerate(awaited):
            if child == name:
                edit.take(Assign(at=(*place, "wait_for"), key=str(number), value=to))
        return
    for field, old, kept in (
        ("rules", rules, [rule for number, rule in enumerate(rules) if number not in about]),
        ("wait_for", awaited, [child for child in awaited if child != name] if name in awaited else awaited),
    ):
        if kept != old:
            edit.set(place, field, kept) if kept else edit.drop(place, field)
