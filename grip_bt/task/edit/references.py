"""What the nodes around a node say about it by its name.

The container's `initial`, `default`, `cases`, `exits`, `rules` and `wait_for`, and the `on` of siblings in a machine.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..model import AnyNode, StateMachine
from ..walking import children_of
from .draft import deep
from .editing import Editing, slot
from .steps import Assign, Place

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
