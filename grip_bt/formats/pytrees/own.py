"""Nodes that were made of a task: they carry what the document said of them."""

from __future__ import annotations

from typing import Any

from py_trees.behaviour import Behaviour

from grip_bt.nodes import control
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Node
from grip_bt.task import model
from grip_bt.task.edges import Edges

from .kinds import NoEqual


def from_document(behaviour: Node | None, document: model.AnyNode) -> dict[str, Any]:
    """Return a node's keys as its document has them, without children, with what was changed on the behaviour.

    Args:
        behaviour: the node of the tree; None where something else was made of the document.
        document: what it was made of.
    """
    keys = document.model_dump(by_alias=True, exclude_unset=True, exclude={"children", "child"})
    for attribute, key in _SETTINGS.items():
        said = getattr(document, key, None)
        there = getattr(behaviour, attribute, said)
        if said is not None and there != said:
            keys[key] = there
    if isinstance(behaviour, Leaf) and isinstance(document, model.Leaf):
        keys |= _changed_parameters(behaviour, document)
    return keys


_SETTINGS = {"memory": "memory", "num_failures": "times", "num_success": "times", "duration": "seconds"}
"""Attribute of py_trees -> key of a node."""


def _changed_parameters(leaf: Leaf, document: model.Leaf) -> dict[str, Any]:
    defaults = {name: p.default for name, p in leaf.manifest.parameters.items() if not p.required}
    if leaf.params == {**defaults, **document.with_}:
        return {}
    return {"with": {k: v for k, v in leaf.params.items() if k in document.with_ or v != defaults.get(k)}}


def from_face(behaviour: Node) -> dict[str, Any]:
    """Return the keys of a node whose document isn't at hand, from what the behaviour carries.

    Raises:
        NoEqual: it reads or writes variables, whose names and types only the document has; or its class is unknown.
    """
    if isinstance(behaviour, control.Conditional):
        raise NoEqual(f"it has the precondition `{behaviour.precondition.text}`, {_GIVE}")
    keys = _keys(behaviour)
    if isinstance(behaviour, control.Container):
        if behaviour.enter is not None:
            raise NoEqual(f"it declares variables, {_GIVE}")
        more = {k: v for k, v in behaviour.meaning.items() if keys["kind"] == "state_machine" or k not in control.PLAIN}
        keys |= {"outcomes": more} if more else {}
        keys |= {"exits": _exits(behaviour.exits)} if behaviour.exits else {}
    return keys


_GIVE = "and which variables those are only the compiled task knows; give that to `to_task`, not its root"

_SECRETS: dict[type, str] = {
    control.Foreign: "what a foreign behaviour was made of only the compiled task knows; give that to `to_task`",
    control.Subtask: "which file it runs only the compiled task knows; give that to `to_task`, not its root",
}


def _keys(node: Node) -> dict[str, Any]:
    base = type(node)
    if isinstance(node, Leaf):
        return _leaf(node)
    if base is control.Sequence:
        return {"kind": "sequence", "memory": node.memory}
    if base is control.Fallback:
        return {"kind": "fallback", "memory": node.memory}
    if base in (control.Parallel, control.PromptParallel):
        return {
            "kind": "parallel",
            "prompt": base is control.PromptParallel,
            "cancel": node.cancel,
            "retick": node.retick,
            **_ruling(node.ruling),
        }
    if base is control.Dispatch:
        if node.run_to_completion:
            raise NoEqual("it runs to completion, which no task says")
        return {"kind": "state_machine", "initial": node.initial.name}
    if base is control.Retry:
        return {"kind": "retry", "times": node.num_failures}
    if base is control.Repeat:
        return {"kind": "repeat", **({"times": node.num_success} if node.num_success > 0 else {})}
    if base is control.Timeout:
        return {"kind": "timeout", "seconds": float(node.duration), "child_first": node.child_first}
    if base is control.Cooldown:
        return {"kind": "cooldown", "seconds": float(node.rule.seconds)}
    if base is control.Loop and node.rule.condition is None:
        return {"kind": "loop", **({"times": node.rule.times} if node.rule.times is not None else {})}
    if base is control.Invert:
        return {"kind": "invert"}
    if base is control.Force:
        return {"kind": "force", "as": node.forced}
    raise NoEqual(_SECRETS.get(base, f"a {base.__name__}, {_GIVE}"))


def _ruling(ruling: control.Ruling) -> dict[str, Any]:
    keys: dict[str, Any] = {"policy": ruling.policy}
    if ruling.rules:
        keys["rules"] = [_rule(match) for match in ruling.rules]
    if ruling.wait_for is not None:
        said = ruling.wait_for
        keys["wait_for"] = said if isinstance(said, str | int) else list(said)
    return keys


def _rule(match: control.Match) -> dict[str, Any]:
    keys: dict[str, Any] = {"when": {child: list(labels) for child, labels in match.when.items()}} if match.when else {}
    if match.at_least is not None:
        keys |= {"at_least": match.at_least, "ends": match.ends}
    return {**keys, "then": match.then}


def _leaf(leaf: Leaf) -> dict[str, Any]:
    if leaf.readers or leaf.writers:
        raise NoEqual(f"its ports {sorted({*leaf.readers, *leaf.writers})} are bound, {_GIVE}")
    defaults = {name: p.default for name, p in leaf.manifest.parameters.items() if not p.required}
    given = {k: v for k, v in leaf.params.items() if k not in defaults or v != defaults[k]}
    other = {k: v for k, v in leaf.meaning.items() if leaf.manifest.outcomes.get(k) != v}
    return {
        "node": leaf.manifest.id,
        **({"with": given} if given else {}),
        **({"meaning": other} if other else {}),
    }


def _exits(edges: Edges) -> dict[str, str]:
    return {".".join(filter(None, key)): target for key, target in edges}


def edges_of(dispatch: Behaviour, child: str) -> dict[str, str]:
    """Return `on` of a child of a state machine."""
    edges: Edges = getattr(dispatch, "edges", Edges())
    return {
        outcome if code is None else f"{outcome}.{code}": target
        for (name, outcome, code), target in edges
        if name == child
    }
