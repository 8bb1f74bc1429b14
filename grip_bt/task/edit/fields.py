"""Commands on single keys: set, unset, connect, disconnect, bind, unbind, set_meaning."""

from __future__ import annotations

from grip_bt.base.errors import EditError, listing, nearest

from ..model import AnyNode, StateMachine
from ..shape import CHILDREN, FREE, keys_of
from ..walking import children_of, outcomes_of
from .commands import Bind, Connect, Disconnect, Set, SetMeaning, Unbind, Unset
from .editing import Editing, kind_of
from .steps import Place

_STRUCTURE = {
    "grip": "the version of the format stays",
    "kind": "use `change_kind`",
    "root": "use `add`, `wrap` or `move`",
    **dict.fromkeys(CHILDREN, "use `add`, `remove` or `move`"),
}


def set_key(editing: Editing, command: Set) -> None:
    """Give a key a value."""
    place, *inner = _keys(editing, command.path, command.key)
    *above, last = inner
    for depth, key in enumerate(above):
        at = (*place, *above[:depth])
        if key not in editing.draft.mapping(at):
            value = command.value
            for below in reversed(inner[depth + 1 :]):
                value = {below: value}
            editing.put(at, key, value)
            return
    editing.set((*place, *above), last, command.value)


def unset_key(editing: Editing, command: Unset) -> None:
    """Take a key out."""
    place, *inner = _keys(editing, command.path, command.key)
    *above, last = inner
    if len(above) == 1 and last in editing.entries(place, above[0]):
        editing.drop_in(place, above[0], last)
    else:
        editing.drop((*place, *above), last)


def _keys(editing: Editing, path: str, key: tuple[str, ...]) -> tuple[Place, *tuple[str, ...]]:
    shape = type(editing.task if path == "" else editing.node(path))
    allowed = keys_of(shape)
    first = key[0]
    if first in _STRUCTURE:
        raise EditError(path, f"{first!r} isn't set like other keys: {_STRUCTURE[first]}")
    if first not in allowed and not first.startswith(FREE):
        raise EditError(path, f"there is no key {first!r}{nearest(first, allowed)} (there are: {listing(allowed)})")
    return (editing.place(path), *key)


def connect(editing: Editing, command: Connect) -> None:
    """Let an outcome lead somewhere."""
    record, field, key = _edge(editing, command.path, command.outcome)
    allowed = _targets(editing, command.path)
    if command.target not in allowed:
        message = f"can't lead to {command.target!r}{nearest(command.target, allowed)} (it may lead to: "
        hint = "" if field == "on" else "; edges between siblings need a state_machine: `change_kind`"
        raise EditError(command.path, f"{message}{listing(allowed)}){hint}")
    editing.set_in(record, field, key, command.target)


def disconnect(editing: Editing, command: Disconnect) -> None:
    """Take an edge or an exit out."""
    record, field, key = _edge(editing, command.path, command.outcome)
    there = editing.entries(record, field)
    if key not in there:
        ends = [k.removeprefix(f"{command.path.rpartition('/')[2]}.") for k in there]
        raise EditError(command.path, f"{command.outcome!r} leads nowhere (what does: {listing(ends)})")
    editing.drop_in(record, field, key)


def _edge(editing: Editing, path: str, outcome: str) -> tuple[Place, str, str]:
    """Return the record, the field and the key that hold where an outcome leads."""
    if path == "/" or isinstance(editing.parent(path, "")[2], StateMachine):
        return editing.place(path), "on", outcome
    above, name, _ = editing.parent(path, "")
    return editing.place(above), "exits", f"{name}.{outcome}"


def _targets(editing: Editing, path: str) -> list[str]:
    if path == "/":
        return list(editing.task.outcomes)
    container = editing.parent(path, "")[2]
    siblings = children_of(container) if isinstance(container, StateMachine) else ()
    return [*siblings, *outcomes_of(container)]  # type: ignore[arg-type]


def bind(editing: Editing, command: Bind) -> None:
    """Bind a port to a variable."""
    _leaf(editing, command.path, "ports")
    editing.set_in(editing.place(command.path), command.side, command.port, command.variable)


def unbind(editing: Editing, command: Unbind) -> None:
    """Take a binding out."""
    _leaf(editing, command.path, "ports")
    place = editing.place(command.path)
    there = editing.entries(place, command.side)
    if command.port not in there:
        hint = nearest(command.port, there)
        raise EditError(command.path, f"the port {command.port!r} isn't bound{hint} (bound are: {listing(there)})")
    editing.drop_in(place, command.side, command.port)


def _leaf(editing: Editing, path: str, what: str) -> AnyNode:
    node = editing.node(path)
    if not {"in", "out"} <= set(keys_of(type(node))):
        raise EditError(path, f"a {kind_of(node)} has no {what}; leaves have")
    return node


def set_meaning(editing: Editing, command: SetMeaning) -> None:
    """Say what an outcome means."""
    place = editing.place(command.path)
    holder = editing.task if command.path == "" else editing.node(command.path)
    if "meaning" in type(holder).model_fields:
        if command.meaning is not None:
            editing.set_in(place, "meaning", command.outcome, command.meaning)
        elif command.outcome in editing.entries(place, "meaning"):
            editing.drop_in(place, "meaning", command.outcome)
        return
    if "outcomes" not in type(holder).model_fields:
        raise EditError(command.path, f"the outcomes of a {kind_of(holder)} keep their meanings")
    if command.meaning is None:
        raise EditError(command.path, f"the outcome {command.outcome!r} needs a meaning: success or failure")
    if command.path == "" and "outcomes" not in editing.draft.mapping(()):
        editing.put((), "outcomes", {**editing.task.outcomes, command.outcome: command.meaning})
    else:
        editing.set_in(place, "outcomes", command.outcome, command.meaning)
