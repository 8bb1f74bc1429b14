"""Which kind of node each class of py_trees is, with which settings; exact, or none."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import groupby
from typing import Any

from py_trees import behaviours, composites, decorators, timers
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from grip_bt.nodes.leaf import Leaf
from grip_bt.task import model

from .keys import Keys, NoEquivalentError, NoKeys


@dataclass(frozen=True)
class NodeSettings:
    """What a behaviour is in a task: keys of the node, and what to know about it.

    `failures`: a child's failure ends it at once, which its kind wouldn't. `selected`: positions of the children of a
    parallel whose successes are its own; empty where all count. `inverted`: an `invert` is between it and its child.
    """

    settings: dict[str, Any] = field(default_factory=dict)
    failures: bool = False
    selected: tuple[int, ...] = ()
    inverted: bool = False
    remark: str = ""


def convert_behaviour(behaviour: Behaviour, keys: Keys | None = None) -> NodeSettings:
    """Return what a behaviour of py_trees is in a task; a subclass that only constructs is what its base is.

    Args:
        keys: hands out variables; without it, nothing that is on a blackboard has an equivalent.

    Raises:
        NoEquivalentError: nothing; the error says why.
    """
    cls = type(behaviour)
    known = _KNOWN.get(_does_as(cls))
    if known is not None:
        return known(behaviour, keys or NoKeys())
    raise NoEquivalentError(f"{cls.__module__}.{cls.__name__} isn't a class that a task has")


def _does_as(cls: type[Behaviour]) -> type[Behaviour]:
    """Return the class of py_trees whose methods it has, but for that which constructs it."""
    for base in cls.__mro__:
        if base in _KNOWN:
            return base
        own = (name for name, value in vars(base).items() if callable(value) and not name.startswith("__"))
        if any(hasattr(above, name) for name in own for above in base.__bases__):
            break
    return cls


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


_CLOCK = "its time is that of the run's clock now"
_OPEN = "a PassThrough is a guard that is always open"
_COUNTED = "a Count only counts, which the journal does too: a guard that is always open"
_OPERATORS: dict[Any, str] = {
    **{operator.eq: "==", operator.ne: "!=", operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}
}

_JOINED: dict[Any, str] = {operator.and_: "and", operator.or_: "or", operator.xor: "!="}
INSIDE = "inside"
"""What nodes are called that do together what one behaviour does."""


def _plays(statuses: Sequence[Status | str], then: Status | None = None, **more: Any) -> NodeSettings:
    """Return the leaf that answers ticks by a list; `running*3` is three in a row."""
    words = [str(getattr(each, "value", each)).lower() for each in statuses]
    rows = [(word, len(list(row))) for word, row in groupby(words)]
    said: dict[str, Any] = {"statuses": [word if n == 1 else f"{word}*{n}" for word, n in rows], **more}
    return NodeSettings({"node": PLAYED, "with": said | ({"then": then.value.lower()} if then is not None else {})})


def _periodic(node: Any) -> NodeSettings:
    n = node.period  # and one tick more of each, but for the first
    rows = [("running", n), ("success", n + 1), ("failure", n + 1), ("running", 1)]
    return _plays([word for word, count in rows for _ in range(count)])


def _condition(node: Any) -> NodeSettings:
    if node.succeed_status not in (Status.SUCCESS, Status.FAILURE):
        raise NoEquivalentError(f"a Condition that waits for {node.succeed_status.value}")
    return NodeSettings({"kind": "retry"}, inverted=node.succeed_status is Status.FAILURE)


def _one_shot(node: Any) -> NodeSettings:
    every = {status.value.lower() for status in node.policy.value} == {"success", "failure"}
    return NodeSettings({"kind": "once", **({"policy": "any"} if every else {})})


def _guard(node: Any, keys: Keys) -> NodeSettings:
    return NodeSettings({"kind": "guard", "if": keys.condition(node.condition, node.blackboard)})


def _asks(expression: str) -> NodeSettings:
    return NodeSettings({"node": "flow/succeed", "precondition": expression})


def _compared(node: Any, check: Any, keys: Keys) -> tuple[str, str]:
    """Return the variable of a comparison, and what it is compared with: `== 1`."""
    name = keys.plain(node.blackboard, check.variable)
    value = keys.literal(check.value_generator, node.blackboard, check.variable)
    return name, f"{_sign(check.operator, _OPERATORS)} {value!r}"


def _checks(node: Any, keys: Keys) -> NodeSettings:
    name, compared = _compared(node, node.check, keys)
    return _asks(f"{name} != null and {name} {compared}")


def _checks_all(node: Any, keys: Keys) -> NodeSettings:
    """Return what compares several keys: one that isn't there fails it, and only else are the results kept."""
    sign = _sign(node.operator, _JOINED)
    compared = [_compared(node, check, keys) for check in node.checks]
    there = " and ".join(f"{name} != null" for name in dict(compared))
    joined = reduce(lambda one, other: f"({one}) {sign} ({other})", (f"{name} {how}" for name, how in compared))
    asked = _asks(f"{there} and ({joined})")
    if node.blackboard_results is None:
        return asked
    steps: dict[str, Any] = {f"{INSIDE} 0": _asks(there).settings}
    for number, (name, how) in enumerate(compared, 1):
        kept = keys.plain(node.blackboard_results, str(number))
        said = {"with": {"expression": f"a {how}"}, "in": {"a": name}, "out": {"value": kept}}
        steps[f"{INSIDE} {number}"] = {"node": "flow/compute", **said}
    return NodeSettings({"kind": "sequence", "memory": False, "children": steps | {INSIDE: asked.settings}})


def _between(node: Any, keys: Keys) -> str:
    one, other = (keys.plain(node.blackboard, name) for name in (node.var1_key, node.var2_key))
    return f"{one} != null and {other} != null and {one} {_sign(node.operator, _OPERATORS)} {other}"


def _sign(function: Any, signs: Mapping[Any, str]) -> str:
    if function not in signs:
        raise NoEquivalentError(f"a comparison by {function}, which is a Python function")
    return signs[function]


def _sets(name: str, value: object, **more: Any) -> NodeSettings:
    return NodeSettings({"node": "flow/set", **more, "with": {"value": value}, "out": {"value": name}})


def _set(node: Any, keys: Keys) -> NodeSettings:
    name = keys.plain(node.blackboard, node.variable_name)
    value = keys.literal(node.variable_value_generator, node.blackboard, node.variable_name)
    return _sets(name, value, **({} if node.overwrite else {"precondition": f"{name} == null"}))


def _waits(variable: str, expression: str = "") -> NodeSettings:
    text = f"a != null and a {expression}" if expression else "a != null"
    return NodeSettings({"node": "flow/wait_until", "with": {"expression": text}, "in": {"a": variable}})


_KNOWN: dict[type[Behaviour], Callable[[Any, Keys], NodeSettings]] = {
    composites.Sequence: lambda node, _: NodeSettings({"kind": "sequence", "memory": bool(node.memory)}),
    composites.Selector: lambda node, _: NodeSettings({"kind": "fallback", "memory": bool(node.memory)}),
    composites.Parallel: lambda node, _: _parallel(node),
    decorators.Retry: lambda node, _: NodeSettings({"kind": "retry", "times": max(1, node.num_failures)}),
    decorators.Repeat: lambda node, _: NodeSettings(
        {"kind": "repeat", **({"times": node.num_success} if node.num_success > 0 else {})}
    ),
    decorators.Timeout: lambda node, _: NodeSettings(
        {"kind": "timeout", "seconds": max(0.0, node.duration), "child_first": True}, remark=_CLOCK
    ),
    decorators.RunningIsFailure: lambda node, _: NodeSettings({"kind": "timeout", "seconds": 0.0, "child_first": True}),
    decorators.SuccessIsRunning: lambda node, _: NodeSettings({"kind": "repeat"}),
    decorators.FailureIsRunning: lambda node, _: NodeSettings({"kind": "retry"}),
    decorators.Condition: lambda node, _: _condition(node),
    decorators.OneShot: lambda node, _: _one_shot(node),
    decorators.EternalGuard: _guard,
    decorators.Inverter: lambda node, _: NodeSettings({"kind": "invert"}),
    decorators.FailureIsSuccess: lambda node, _: NodeSettings({"kind": "force", "as": "success"}),
    decorators.SuccessIsFailure: lambda node, _: NodeSettings({"kind": "force", "as": "failure"}),
    decorators.PassThrough: lambda node, _: NodeSettings({"kind": "guard", "if": "true"}, remark=_OPEN),
    decorators.Count: lambda node, _: NodeSettings({"kind": "guard", "if": "true"}, remark=_COUNTED),
    behaviours.Success: lambda node, _: NodeSettings({"node": "flow/succeed"}),
    behaviours.Failure: lambda node, _: NodeSettings({"node": "flow/fail"}),
    behaviours.Running: lambda node, _: _plays(["running"]),
    behaviours.Dummy: lambda node, _: _plays(["running"]),
    behaviours.Periodic: lambda node, _: _periodic(node),
    behaviours.StatusQueue: lambda node, _: _plays(node.queue, node.eventually),
    behaviours.SuccessEveryN: lambda node, _: _plays(["failure"] * (node.every_n - 1) + ["success"]),
    behaviours.TickCounter: lambda node, _: _plays(["running"] * node.duration + [node.completion_status], anew=True),
    behaviours.CheckBlackboardVariableExists: lambda node, keys: _asks(
        f"{keys.plain(node.blackboard, node.variable_name)} != null"
    ),
    behaviours.WaitForBlackboardVariable: lambda node, keys: _waits(keys.plain(node.blackboard, node.variable_name)),
    behaviours.CheckBlackboardVariableValue: _checks,
    behaviours.WaitForBlackboardVariableValue: lambda node, keys: _waits(*_compared(node, node.check, keys)),
    behaviours.CheckBlackboardVariableValues: _checks_all,
    behaviours.CompareBlackboardVariables: lambda node, keys: _asks(_between(node, keys)),
    behaviours.SetBlackboardVariable: _set,
    behaviours.UnsetBlackboardVariable: lambda node, keys: _sets(keys.plain(node.blackboard, node.key), None),
    timers.Timer: lambda node, _: NodeSettings(
        {"node": "flow/wait", "with": {"seconds": float(node.duration)}}, remark=_CLOCK
    ),
}
PLAYED = "flow/play_statuses"
ENDS = {
    "flow/succeed": {"success": "success"},
    "flow/wait": {"success": "success"},
    "flow/set": {"success": "success"},
    "flow/fail": {"failure": "failure"},
}
"""What the leaves that behaviours of py_trees become can end with."""


def class_for(node: model.AnyNode) -> tuple[str, dict[str, object]] | None:
    """Return the class of py_trees that does what a container does, and its settings; None where no class does."""
    match node:
        case model.Sequence() | model.Fallback():
            return ("Selector" if node.kind == "fallback" else "Sequence"), {"memory": node.memory}
        case model.Retry(times=times):
            return ("FailureIsRunning", {}) if times is None else ("Retry", {"num_failures": times})
        case model.Repeat(times=times):
            return "Repeat", {"num_success": times or -1}
        case model.Timeout(seconds=seconds, child_first=True):
            return "Timeout", {"duration": seconds}
        case model.Guard(if_="true"):
            return "PassThrough", {}
        case model.Invert():
            return "Inverter", {}
        case model.Force(as_=forced):
            return ("FailureIsSuccess" if forced == "success" else "SuccessIsFailure"), {}
    return None


SAID: dict[type, tuple[str, ...]] = {
    **dict.fromkeys((model.Sequence, model.Fallback), ("memory",)),
    **dict.fromkeys((model.Retry, model.Repeat), ("times",)),
    model.Timeout: ("seconds", "child_first"),
    model.Guard: ("if_",),
    model.Invert: (),
    model.Force: ("as_",),
}
"""What `class_for` looks at."""


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
    """Refuse a node that sees variables, which only the whole task declares. Raises NoEquivalentError."""
    asks = isinstance(document, model.Kind) and (document.reads or any(document.expressions()))
    if asks or document.precondition or any(getattr(document, keys, None) for keys in ("in_", "out", "data")):
        why = "which those are only the compiled task knows; give that to `to_task`, not its root"
        raise NoEquivalentError(f"it sees variables, and {why}")
