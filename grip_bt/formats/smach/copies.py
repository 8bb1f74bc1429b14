"""States that copy userdata into and out of a container, as SMACH does when it enters and leaves one."""

from __future__ import annotations

from collections.abc import Mapping

from grip_bt.task import FrozenDict, Leaf, StateMachine
from grip_bt.task.model import AnyNode, Meaning

from .keys import Keys
from .leaves import Leaves


def wrapped(node: AnyNode, ends: Mapping[str, str], outcomes: Mapping[str, Meaning]) -> StateMachine:
    """Return a machine of one state, which has room for what copies.

    Args:
        node: what is no machine.
        ends: outcome of the node -> outcome of the machine.
        outcomes: those of the machine.
    """
    name = "together"
    while name in outcomes:
        name += "_"
    state = node.model_copy(update={"on": FrozenDict(dict(ends))})
    return StateMachine(kind="state_machine", initial=name, outcomes=dict(outcomes), children={name: state})


def entered(node: StateMachine, copied: Mapping[str, str], inner: Keys, leaves: Leaves) -> StateMachine:
    """Put a state first that copies keys in.

    Args:
        node: the container.
        copied: its key -> the parent's variable.
        inner: its own variables.
        leaves: takes the leaf.
    """
    name = _free("enter", {*node.children, *node.outcomes})
    step = Leaf(
        node=leaves.copy(list(copied)).manifest.id,
        in_=dict(copied),
        out={key: inner(key) for key in copied},
        on={"done": node.initial},
    )
    return node.model_copy(update={"initial": name, "children": FrozenDict({name: step, **node.children})})


def left(node: StateMachine, out: Mapping[str, str], inner: Keys, leaves: Leaves) -> StateMachine:
    """Put a state before each outcome that copies keys out; arguments as for `entered`."""
    taken = {*node.children, *node.outcomes}
    names = {outcome: _free(f"leave {outcome}", taken) for outcome in node.outcomes}
    children = {
        label: child.model_copy(update={"on": FrozenDict({k: names.get(t, t) for k, t in child.on.items()})})
        for label, child in node.children.items()
    }
    used = {target for child in children.values() for target in child.on.values()}
    spec = leaves.copy(list(out))
    for outcome, name in names.items():
        if name in used:
            bound = {"in_": {key: inner(key) for key in out}, "out": dict(out)}
            children[name] = Leaf(node=spec.manifest.id, on={"done": outcome}, **bound)
    return node.model_copy(update={"children": FrozenDict(children)})


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name
