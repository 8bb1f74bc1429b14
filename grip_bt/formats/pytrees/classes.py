"""Which kind of node each class of py_trees is, with which settings; exact, or none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from py_trees import behaviours, composites, decorators, timers
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy

from grip_bt.nodes.leaf import Leaf
from grip_bt.task import model


class NoEquivalentError(Exception):
    """A behaviour has no equivalent in a task; the text says why."""


@dataclass(frozen=True)
class NodeSettings:
    """What a behaviour is in a task: keys of the node, and what to know about it.

    `failures`: a child's failure ends it at once, which its kind wouldn't. `selected`: positions of the children of a
    parallel whose successes are its own; empty where all count.
    """

    settings: dict[str, Any] = field(default_factory=dict)
    failures: bool = False
    selected: tuple[int, ...] = ()
    remark: str = ""


def convert_behaviour(behaviour: Behaviour) -> NodeSettings:
    """Return what a behaviour of py_trees is in a task.

    Raises:
        NoEquivalentError: nothing; the error says why.
    """
    known = _KNOWN.get(type(behaviour))
    if known is not None:
        return known(behaviour)
    raise NoEquivalentError(reason_unsupported(type(behaviour)))


def is_known(behaviour: Behaviour) -> bool:
    """Tell whether its class has an equivalent, or is known to have none."""
    return type(behaviour) in _KNOWN or type(behaviour) in _WHY


def reason_unsupported(cls: type[Behaviour]) -> str:
    """Return why a class has no equivalent."""
    return _WHY.get(cls) or f"{cls.__module__}.{cls.__name__} is no class that a task has"


def _parallel(node: Any) -> NodeSettings:
    policy = node.policy
    # A child that has failed ends it: none but those that have succeeded could be ticked again.
    again = {} if policy.synchronise else {"retick": True}
    if type(policy) is ParallelPolicy.SuccessOnAll:
        return NodeSettings({"kind": "parallel", **again})
    if type(policy) is ParallelPolicy.SuccessOnOne:
        # The first failure ends it too, and before a success is looked at: that is what an exit does.
        return NodeSettings({"kind": "parallel", "policy": "any"}, failures=True)
    if type(policy) is ParallelPolicy.SuccessOnSelected:
        chosen = {id(child) for child in policy.children}
        positions = tuple(n for n, child in enumerate(node.children) if id(child) in chosen)
        if not chosen or len(positions) < len(chosen):
            why = "needs a selection of its own children; py_trees refuses it too"
            raise NoEquivalentError(f"a Parallel with SuccessOnSelected {why}")
        return NodeSettings({"kind": "parallel", **again}, selected=positions)
    raise NoEquivalentError(f"a Parallel with {type(policy).__name__}: what that decides isn't known")


def _timeout(node: Any) -> NodeSettings:
    if node.duration <= 0:
        raise NoEquivalentError(f"a Timeout of {node.duration:g} s is over at once")
    return NodeSettings({"kind": "timeout", "seconds": float(node.duration), "child_first": True}, remark=_CLOCK)


_CLOCK = "its time is that of the run's clock now"
_OPEN = "a PassThrough is a guard that is always open"
_KNOWN: dict[type[Behaviour], Callable[[Any], NodeSettings]] = {
    composites.Sequence: lambda node: NodeSettings({"kind": "sequence", "memory": bool(node.memory)}),
    composites.Selector: lambda node: NodeSettings({"kind": "fallback", "memory": bool(node.memory)}),
    composites.Parallel: _parallel,
    decorators.Retry: lambda node: NodeSettings({"kind": "retry", "times": max(1, node.num_failures)}),
    decorators.Repeat: lambda node: NodeSettings(
        {"kind": "repeat", **({"times": node.num_success} if node.num_success > 0 else {})}
    ),
    decorators.Timeout: _timeout,
    decorators.Inverter: lambda node: NodeSettings({"kind": "invert"}),
    decorators.FailureIsSuccess: lambda node: NodeSettings({"kind": "force", "as": "success"}),
    decorators.SuccessIsFailure: lambda node: NodeSettings({"kind": "force", "as": "failure"}),
    decorators.PassThrough: lambda node: NodeSettings({"kind": "guard", "if": "true"}, remark=_OPEN),
    behaviours.Success: lambda node: NodeSettings({"node": "flow/succeed"}),
    behaviours.Failure: lambda node: NodeSettings({"node": "flow/fail"}),
    timers.Timer: lambda node: NodeSettings(
        {"node": "flow/wait", "with": {"seconds": float(node.duration)}}, remark=_CLOCK
    ),
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
    **{
        cls: f"{cls.__name__}: {_RUNNING}"
        for cls in (
            *(decorators.RunningIsFailure, decorators.RunningIsSuccess, decorators.FailureIsRunning),
            *(decorators.SuccessIsRunning, decorators.Condition),
        )
    },
    decorators.OneShot: "OneShot: what it remembers outlives its container; no node of a task does that",
    decorators.Count: "Count: its counters can't be read; leave it out",
    decorators.EternalGuard: "EternalGuard: its condition is a Python function; write a guard with an expression",
    **{
        cls: f"{cls.__name__}: {_BLACKBOARD}"
        for cls in (
            *(decorators.StatusToBlackboard, decorators.ForEach),
            *(found for name, found in vars(behaviours).items() if "Blackboard" in name),
        )
    },
}


def from_document(behaviour: Behaviour | None, document: model.AnyNode) -> dict[str, object]:
    """Return a node's keys without children, as its document has them and as they were changed on the behaviour."""
    keys = document.model_dump(by_alias=True, exclude_unset=True, exclude={"children", "child"})
    if isinstance(behaviour, Leaf) and isinstance(document, model.Leaf):
        defaults = {name: p.default for name, p in behaviour.manifest.parameters.items() if not p.required}
        if behaviour.params != {**defaults, **document.with_}:
            params = behaviour.params.items()
            keys["with"] = {k: v for k, v in params if k in document.with_ or v != defaults.get(k)}
    return keys


def refuse_variables(document: model.AnyNode) -> None:
    """Refuse a node that sees variables: where these are declared only the whole task says.

    Raises:
        NoEquivalentError: it reads, writes or declares some.
    """
    if document.precondition:
        raise NoEquivalentError(f"it has the precondition `{document.precondition}`, {_GIVE}")
    if isinstance(document, model.Leaf | model.Subtask) and (document.in_ or document.out):
        raise NoEquivalentError(f"its ports {sorted({*document.in_, *document.out})} are bound, {_GIVE}")
    if isinstance(document, model.Kind):
        if getattr(document, "data", None):
            raise NoEquivalentError(f"it declares variables, {_GIVE}")
        if document.reads or any(document.expressions()):
            raise NoEquivalentError(f"it is a {document.kind} over variables, {_GIVE}")


_GIVE = "and which variables those are only the compiled task knows; give that to `to_task`, not its root"
