"""The command that takes a container away and leaves its children in its place."""

from __future__ import annotations

from grip_bt.base.errors import EditError, listing

from ..model import AnyNode, StateMachine, Task
from ..walking import children_of
from .commands import Unwrap
from .editing import Editing, slot
from .kinds import edges_of
from .references import child_of
from .steps import Place


def unwrap(editing: Editing, command: Unwrap) -> None:
    """Put a container's children in its place."""
    node = editing.container(command.path)
    names = list(children_of(node))
    if command.path == "/":
        _unwrap_root(editing, node, names)
        return
    parent, name, container = editing.parent(command.path, "")
    if len(names) != 1 and (slot(container) == "child" or isinstance(container, StateMachine) and not names):
        raise EditError(command.path, f"{parent} needs exactly one node here, not {listing(names, 'none')}")
    taken = [n for n in names if n in children_of(container) and n != name]
    if taken:
        raise EditError(command.path, f"{parent} has its own {listing(taken)}; rename one of each first")
    place, at = editing.place(command.path), (*editing.place(parent), slot(container))
    _rehome(editing, node, place, container, editing.place(parent))
    if isinstance(container, StateMachine):
        _give_edges(editing, node, place, container, name)
    else:
        _give_exits(editing, node, place, editing.place(parent), name)
    inner = (*place, slot(node))
    index = list(children_of(container)).index(name)
    if name in names:
        aside = name
        while aside in names or aside in children_of(container):
            aside += "_"
        editing.rekey(at, name, aside)
        name, inner = aside, (*at, aside, slot(node))
    for position, child in enumerate(names):
        editing.shift(inner, child, at, index + position)
    editing.drop(at, name)


def _unwrap_root(editing: Editing, node: AnyNode, names: list[str]) -> None:
    if len(names) != 1:
        raise EditError("/", f"a task has one root; this one would leave {listing(names, 'none')}")
    _rehome(editing, node, ("root",), editing.task, ())
    inner = ("root", slot(node))
    record = (*inner, names[0])
    on = {
        outcome: node.on.get(label, label)
        for outcome, label in edges_of(node)[names[0]].items()
        if label not in names and node.on.get(label, label) in editing.task.outcomes
    }
    _set_on(editing, record, on if node.on or isinstance(node, StateMachine) else {})
    aside = "x-aside"
    while aside in editing.draft.mapping(()) or aside in names:
        aside += "-"
    editing.rekey(inner, names[0], aside)
    editing.shift(inner, aside, ())
    editing.drop((), "root")
    editing.rekey((), aside, "root")


def _rehome(editing: Editing, node: AnyNode, place: Place, around: AnyNode | Task, to: Place) -> None:
    """Let the variables of the container be those of the one around it."""
    own = list(getattr(node, "data", ()))
    if not own:
        return
    both = [name for name in own if name in getattr(around, "data", ())]
    if both:
        where = "the task" if to == () else "the container around it"
        raise EditError("/".join(place[2::2]), f"{where} has its own {listing(both)}; rename a variable first")
    if "data" not in editing.draft.mapping(to):
        editing.shift(place, "data", to)
        return
    for name in own:
        editing.shift((*place, "data"), name, (*to, "data"))


def _give_edges(editing: Editing, node: AnyNode, place: Place, machine: StateMachine, name: str) -> None:
    """Connect the children to where the container led, and what led to the container to its first child."""
    names = list(children_of(node))
    first = node.initial if isinstance(node, StateMachine) and node.initial in names else names[0]
    at = place[:-1]
    for sibling, child in machine.children.items():
        for outcome, target in child.on.items():
            if target == name != sibling:
                editing.set((*at, sibling, "on"), outcome, first)
    if machine.initial == name:
        editing.set(at[:-1], "initial", first)
    for inner, edges in edges_of(node).items():
        on: dict[str, str] = {}
        for outcome, label in edges.items():
            if label in names:
                on[outcome] = label
                continue
            for exit_, target in node.on.items():
                base, dot, code = exit_.partition(".")
                if base == label and (not dot or "." not in outcome):
                    on[f"{outcome}{dot}{code}"] = first if target == name else target
        _set_on(editing, (*place, slot(node), inner), on)


def _give_exits(editing: Editing, node: AnyNode, place: Place, around: Place, name: str) -> None:
    """Let the labels of the children that left the container around it through this one leave it themselves."""
    old = {key: exit_ for key, exit_ in editing.entries(around, "exits").items() if child_of(key) == name}
    for key in old:
        editing.drop_in(around, "exits", key)
    for child, edges in edges_of(node).items():
        for outcome, label in edges.items():
            if f"{name}.{label}" in old and label not in children_of(node):
                editing.set_in(around, "exits", f"{child}.{outcome}", old[f"{name}.{label}"])
        _set_on(editing, (*place, slot(node), child), {})


def _set_on(editing: Editing, record: Place, on: dict[str, str]) -> None:
    if on:
        editing.set(record, "on", on)
    elif "on" in editing.draft.mapping(record):
        editing.drop(record, "on")
