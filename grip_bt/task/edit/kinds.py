"""The edges that a container's kind implies, and the command that changes the kind."""

from __future__ import annotations

from grip_bt.base.errors import EditError, listing, nearest

from ..model import KINDS, AnyNode, Fallback, Force, Invert, Sequence, StateMachine
from ..shape import CHILDREN, FREE, keys_of, model_of_kind
from ..walking import children_of
from .commands import ChangeKind
from .editing import Editing, holds_nodes, kind_of, slot

STANDARD = ("success", "failure")


def expect_kind(path: str, kind: str) -> None:
    """Refuse a kind that there isn't.

    Raises:
        EditError: there isn't.
    """
    if kind not in KINDS:
        raise EditError(path, f"unknown kind {kind!r}{nearest(kind, KINDS)} (there are: {listing(KINDS)})")


def holds_nodes_of_kind(kind: str) -> bool:
    """Tell whether nodes of a kind are containers."""
    return not model_of_kind(kind).model_fields.keys().isdisjoint(CHILDREN)


def slot_of_kind(kind: str) -> str:
    """Return the key under which containers of a kind have their children."""
    return "child" if "child" in model_of_kind(kind).model_fields else "children"


def edges_of(container: AnyNode) -> dict[str, dict[str, str]]:
    """Return where each child's outcomes lead: outcome -> sibling or outcome of the container, by child.

    In a state machine that is what is written; elsewhere what the kind does with success and failure, and `exits`.
    """
    below = children_of(container)
    if isinstance(container, StateMachine):
        return {name: dict(child.on) for name, child in below.items()}
    edges = chain(container, list(below))
    for key, label in getattr(container, "exits", {}).items():
        name, _, outcome = key.partition(".")
        if name in edges:
            edges[name][outcome] = label
    return edges


def chain(container: AnyNode | None, names: list[str]) -> dict[str, dict[str, str]]:
    """Return the edges by which a container of this kind leads from child to child; those of a sequence for None."""
    edges = {}
    for name, following in zip(names, [*names[1:], None], strict=False):
        success, failure = STANDARD
        if container is None or isinstance(container, Sequence):
            success = following or success
        elif isinstance(container, Fallback):
            failure = following or failure
        elif isinstance(container, Invert):
            success, failure = failure, success
        elif isinstance(container, Force):
            success = failure = container.as_
        edges[name] = {"success": success, "failure": failure}
    return edges


def change_kind(editing: Editing, command: ChangeKind) -> None:
    """Make a container one of another kind."""
    node = editing.node(command.path)
    expect_kind(command.path, command.kind)
    if not holds_nodes(node) or not holds_nodes_of_kind(command.kind):
        raise EditError(command.path, "only a container becomes another container; add a node, or wrap this one")
    names = list(children_of(node))
    new_slot = slot_of_kind(command.kind)
    if new_slot == "child" and len(names) != 1:
        held = listing(names, "no child")
        raise EditError(command.path, f"a {command.kind} has one child, this {kind_of(node)} has {held}")
    place = editing.place(command.path)
    if command.kind != kind_of(node):
        _change_edges(editing, node, command)
        editing.set(place, "kind", command.kind)
        allowed = {*keys_of(model_of_kind(command.kind)), *CHILDREN}
        for key in [k for k in editing.draft.mapping(place) if k not in allowed and not k.startswith(FREE)]:
            editing.drop(place, key)
        if command.kind == "state_machine" and "initial" not in command.fields and names:
            editing.put(place, "initial", names[0])
        editing.rekey(place, slot(node), new_slot)
    for key, value in command.fields.items():
        editing.set(place, key, value)


def _change_edges(editing: Editing, node: AnyNode, command: ChangeKind) -> None:
    """Turn edges into exits, or the order of the children and exits into edges."""
    place = editing.place(command.path)
    below = (*place, slot(node))
    edges = edges_of(node)
    if command.kind == "state_machine":
        for name, on in edges.items():
            editing.set((*below, name), "on", on)
        reached = {target for on in edges.values() for target in on.values() if target in STANDARD}
        for label in STANDARD:
            if label in reached and label not in editing.entries(place, "outcomes"):
                editing.set_in(place, "outcomes", label, label)
    elif isinstance(node, StateMachine):
        for name, on in edges.items():
            if "on" in editing.draft.mapping((*below, name)):
                editing.drop((*below, name), "on")
            for outcome, target in on.items():
                if target in node.outcomes and target not in STANDARD and target not in edges:
                    editing.set_in(place, "exits", f"{name}.{outcome}", target)
        for label in STANDARD:
            if label in editing.entries(place, "outcomes"):
                editing.drop_in(place, "outcomes", label)
