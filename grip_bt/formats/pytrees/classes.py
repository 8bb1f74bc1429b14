"""Which kind of node each class of py_trees is, with which settings; exact, or none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from py_trees import behaviours, composites, decorators, timers
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy

from grip_bt.nodes import control
from grip_bt.nodes.container import KindNode
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Node
from grip_bt.task import model
from grip_bt.task.edges import Edges


class NoEqual(Exception):
    """A behaviour has no equal in a task; the text says why."""


@dataclass(frozen=True)
class Equal:
    """What a behaviour is in a task.

    Attributes:
        settings: keys of the node, `kind` or `node` among them.
        failures: whether a child's failure ends it at once, which its kind wouldn't.
        selected: positions of the children of a parallel whose successes are its own; empty where all count.
        remark: what to know about it.
    """

    settings: dict[str, Any] = field(default_factory=dict)
    failures: bool = False
    selected: tuple[int, ...] = ()
    remark: str = ""


def equal_of(behaviour: Behaviour) -> Equal:
    """Return what a behaviour of py_trees is in a task.

    Raises:
        NoEqual: nothing; the error says why.
    """
    known = _KNOWN.get(type(behaviour))
    if known is not None:
        return known(behaviour)
    raise NoEqual(why_not(type(behaviour)))


def is_known(behaviour: Behaviour) -> bool:
    """Tell whether its class has an equal, or is known to have none."""
    return type(behaviour) in _KNOWN or type(behaviour) in _WHY


def why_not(cls: type[Behaviour]) -> str:
    """Return why a class has no equal."""
    return _WHY.get(cls) or f"{cls.__module__}.{cls.__name__} is no class that a task has"


def _sequence(node: Any) -> Equal:
    return Equal({"kind": "sequence", "memory": bool(node.memory)})


def _selector(node: Any) -> Equal:
    return Equal({"kind": "fallback", "memory": bool(node.memory)})


def _parallel(node: Any) -> Equal:
    policy = node.policy
    # A child that has failed ends it: none but those that have succeeded could be ticked again.
    again = {} if policy.synchronise else {"retick": True}
    if type(policy) is ParallelPolicy.SuccessOnAll:
        return Equal({"kind": "parallel", **again})
    if type(policy) is ParallelPolicy.SuccessOnOne:
        # The first failure ends it too, and before a success is looked at: that is what an exit does.
        return Equal({"kind": "parallel", "policy": "any"}, failures=True)
    if type(policy) is ParallelPolicy.SuccessOnSelected:
        return _selected(node, again)
    raise NoEqual(f"a Parallel with {type(policy).__name__}: what that decides isn't known")


def _selected(node: Any, again: dict[str, Any]) -> Equal:
    chosen = {id(child) for child in node.policy.children}
    positions = tuple(n for n, child in enumerate(node.children) if id(child) in chosen)
    if not chosen or len(positions) < len(chosen):
        raise NoEqual(
            "a Parallel with SuccessOnSelected needs a selection of its own children; py_trees refuses it too"
        )
    return Equal({"kind": "parallel", **again}, selected=positions)


def _retry(node: Any) -> Equal:
    return Equal({"kind": "retry", "times": max(1, node.num_failures)})


def _repeat(node: Any) -> Equal:
    return Equal({"kind": "repeat", **({"times": node.num_success} if node.num_success > 0 else {})})


def _timeout(node: Any) -> Equal:
    if node.duration <= 0:
        raise NoEqual(f"a Timeout of {node.duration:g} s is over at once")
    own = {"kind": "timeout", "seconds": float(node.duration), "child_first": True}
    return Equal(own, remark="its time is that of the run's clock now")


def _timer(node: Any) -> Equal:
    leaf = {"node": "flow/wait", "with": {"seconds": float(node.duration)}}
    return Equal(leaf, remark="its time is that of the run's clock now")


def _always(**settings: Any) -> Callable[[Any], Equal]:
    return lambda node: Equal(dict(settings))


def _pass_through(node: Any) -> Equal:
    return Equal({"kind": "guard", "if": "true"}, remark="a PassThrough is a guard that is always open")


_KNOWN: dict[type[Behaviour], Callable[[Any], Equal]] = {
    composites.Sequence: _sequence,
    composites.Selector: _selector,
    composites.Parallel: _parallel,
    decorators.Retry: _retry,
    decorators.Repeat: _repeat,
    decorators.Timeout: _timeout,
    decorators.Inverter: _always(kind="invert"),
    decorators.FailureIsSuccess: _always(kind="force", **{"as": "success"}),
    decorators.SuccessIsFailure: _always(kind="force", **{"as": "failure"}),
    decorators.PassThrough: _pass_through,
    behaviours.Success: _always(node="flow/succeed"),
    behaviours.Failure: _always(node="flow/fail"),
    timers.Timer: _timer,
}
ENDS = {
    "flow/succeed": {"success": "success"},
    "flow/wait": {"success": "success"},
    "flow/fail": {"failure": "failure"},
}
"""What the leaves that behaviours of py_trees become can end with."""
_RUNNING = "it turns RUNNING into an end or an end into RUNNING; no task node does that"
_BLACKBOARD = "it works on py_trees' blackboard, which a task hasn't; its variables have types and a place"
_WHY: dict[type[Behaviour], str] = {
    decorators.RunningIsFailure: f"RunningIsFailure: {_RUNNING}",
    decorators.RunningIsSuccess: f"RunningIsSuccess: {_RUNNING}",
    decorators.FailureIsRunning: f"FailureIsRunning: {_RUNNING}",
    decorators.SuccessIsRunning: f"SuccessIsRunning: {_RUNNING}",
    decorators.Condition: f"Condition: {_RUNNING}",
    decorators.OneShot: "OneShot: what it remembers outlives its container; no node of a task does that",
    decorators.Count: "Count: nobody could read its counters; leave it out",
    decorators.EternalGuard: "EternalGuard: its condition is a Python function; write a guard with an expression",
    decorators.StatusToBlackboard: f"StatusToBlackboard: {_BLACKBOARD}",
    decorators.ForEach: f"ForEach: {_BLACKBOARD}",
    behaviours.SetBlackboardVariable: f"SetBlackboardVariable: {_BLACKBOARD}",
    behaviours.UnsetBlackboardVariable: f"UnsetBlackboardVariable: {_BLACKBOARD}",
    behaviours.BlackboardToStatus: f"BlackboardToStatus: {_BLACKBOARD}",
    behaviours.CheckBlackboardVariableExists: f"CheckBlackboardVariableExists: {_BLACKBOARD}",
    behaviours.CheckBlackboardVariableValue: f"CheckBlackboardVariableValue: {_BLACKBOARD}",
    behaviours.CheckBlackboardVariableValues: f"CheckBlackboardVariableValues: {_BLACKBOARD}",
    behaviours.CompareBlackboardVariables: f"CompareBlackboardVariables: {_BLACKBOARD}",
    behaviours.WaitForBlackboardVariable: f"WaitForBlackboardVariable: {_BLACKBOARD}",
    behaviours.WaitForBlackboardVariableValue: f"WaitForBlackboardVariableValue: {_BLACKBOARD}",
}


def from_document(behaviour: Node | None, document: model.AnyNode) -> dict[str, Any]:
    """Return a node's keys as its document has them, without children, with what was changed on the behaviour.

    Args:
        behaviour: the node of the tree; None where something else was made of the document.
        document: what it was made of.
    """
    said_by = behaviour.kind if isinstance(behaviour, KindNode) else document
    keys = said_by.model_dump(by_alias=True, exclude_unset=True, exclude={"children", "child"})
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
    if isinstance(behaviour, KindNode):
        return _of_kind(behaviour)
    keys = _keys(behaviour)
    if isinstance(behaviour, control.Container):
        if behaviour.enter is not None:
            raise NoEqual(f"it declares variables, {_GIVE}")
        more = {k: v for k, v in behaviour.meaning.items() if keys["kind"] == "state_machine" or k not in control.PLAIN}
        keys |= {"outcomes": more} if more else {}
        keys |= {"exits": _exits(behaviour.exits)} if behaviour.exits else {}
    return keys


def _of_kind(behaviour: KindNode) -> dict[str, Any]:
    kind = behaviour.kind
    if behaviour.enter is not None or any(kind.expressions()) or kind.reads:
        raise NoEqual(f"it is a {kind.kind} over variables, {_GIVE}")
    return kind.model_dump(by_alias=True, exclude_unset=True, exclude={"children", "child", "on", "x"})


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
