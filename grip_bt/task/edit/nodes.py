"""Commands on whole nodes: add, remove, move, rename."""

from __future__ import annotations

from grip_bt.base.errors import EditError

from .commands import Add, Move, Remove, Rename
from .editing import Editing, expect_free, expect_others, expect_room, slot
from .references import follow, forget


def add(editing: Editing, command: Add) -> None:
    """Put a node into a container."""
    container = editing.container(command.parent)
    expect_room(container, command.parent)
    expect_free(container, command.parent, command.name)
    at = (*editing.place(command.parent), slot(container))
    editing.put(at, command.name, dict(command.node), command.index)


def remove(editing: Editing, command: Remove) -> None:
    """Take a node out, with what its neighbours say about it."""
    parent, name, container = editing.parent(command.path, "can't be removed; remove its children, or set another root")
    expect_others(container, parent)
    forget(editing, parent, name)
    editing.drop((*editing.place(parent), slot(container)), name)


def move(editing: Editing, command: Move) -> None:
    """Move a node within its container or into another one."""
    parent, name, container = editing.parent(command.path, "can't be moved; wrap it in a container instead")
    target = editing.container(command.parent)
    if command.parent == parent:
        if command.name not in (None, name):
            raise EditError(command.path, "a move within a container keeps the name; rename it with `rename`")
        at = (*editing.place(parent), slot(container))
        editing.shift(at, name, at, command.index)
        return
    if command.parent == command.path or command.parent.startswith(f"{command.path}/"):
        raise EditError(command.path, f"can't go into {command.parent}, which is below it")
    expect_others(container, parent)
    expect_room(target, command.parent)
    to = command.name or name
    expect_free(target, command.parent, to)
    forget(editing, parent, name)
    at = (*editing.place(parent), slot(container))
    if "on" in editing.draft.mapping((*at, name)):
        editing.drop((*at, name), "on")
    into = (*editing.place(command.parent), slot(target))
    _carry(editing, at, name, into, to, command.index)


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


def rename(editing: Editing, command: Rename) -> None:
    """Give a node another name."""
    parent, name, container = editing.parent(command.path, "has no name; the task has one: set the task's `name`")
    if command.name == name:
        return
    expect_free(container, parent, command.name)
    follow(editing, parent, name, command.name)
    editing.rekey((*editing.place(parent), slot(container)), name, command.name)
