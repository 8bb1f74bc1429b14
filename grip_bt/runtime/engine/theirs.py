"""Ticks of py_trees' own leaves, composites and decorators, line by line what their generators do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from .halting import Compiled, Stop, Tick, halt_all
from .known import INVALID, VALID, F, R, S, overrides


@dataclass(frozen=True)
class Verdict:
    """What a parent makes of a child that yields, which matters for children that are ticked by their own generator.

    At a status in `leave` the parent leaves the child's generator for good; one that was never left has said `onward`.
    """

    leave: tuple[Status, ...] = ()
    onward: Status = S


def by_generator(node: Behaviour, verdict: Verdict) -> Tick:
    """Tick by the node's own generator."""

    def tick() -> Status:
        for yielded in node.tick():
            if yielded is node and node.status in verdict.leave:
                return node.status
        return verdict.onward if verdict.leave else node.status

    return tick


def checked(node: Behaviour, status: Any) -> Status:
    """Return what `update` returned; INVALID with a complaint, as py_trees does, of what isn't a status."""
    if status is S or status is F or status is R or status in VALID:
        return status
    node.logger.error(f"A behaviour returned an invalid status, setting to INVALID [{status}][{node.name}]")
    return INVALID


def leaf(node: Any) -> Tick:
    """`Behaviour.tick`."""
    initialises, terminates = overrides(node, "initialise"), overrides(node, "terminate")

    def tick() -> Status:
        if initialises and node.status is not R:
            node.initialise()
        status: Status = node.update()
        if status is not S and status is not F and status is not R:
            status = checked(node, status)
        if terminates and status is not R:
            node.terminate(status)
        node.status = status
        return status

    return tick


def sequence(node: Any, parts: Sequence[Compiled], stop: Stop) -> Tick:
    """`Sequence.tick`."""
    kids = [part.node for part in parts]
    following = [*kids[1:], *kids[-1:]]
    steps = [(*part.step, successor) for part, successor in zip(parts, following, strict=True)]
    first = kids[0] if kids else None
    memory, initialises = node.memory, overrides(node, "initialise")

    def tick() -> Status:
        todo = steps
        if node.status is not R:
            node.current_child = first
            halt_all(parts)
            if initialises:
                node.initialise()
        else:
            at = node.current_child if memory else None
            node.current_child = first if at is None else at
            todo = steps if at is None else steps[kids.index(at) :]
        for kid, advance, successor in todo:
            if advance is None:
                status = kid.update()
                kid.status = status = status if status is S or status is F or status is R else checked(kid, status)
            else:
                status = advance()
            if status is not S:
                if not memory:
                    halt_all(parts[kids.index(kid) + 1 :])
                if status is R:
                    node.status = R
                else:
                    stop(status)
                return status
            node.current_child = successor
        stop(S)
        return S

    return tick


def selector(node: Any, parts: Sequence[Compiled], stop: Stop) -> Tick:
    """`Selector.tick`."""
    kids = [part.node for part in parts]
    steps = [part.step for part in parts]
    first, last = (kids[0], kids[-1]) if kids else (None, None)
    memory, initialises = node.memory and bool(kids), overrides(node, "initialise")

    def tick() -> Status:
        if node.status is not R:
            node.current_child = first
            if initialises:
                node.initialise()
        previous, todo = node.current_child, steps
        if memory and previous is not first:
            assert previous is not None
            start = kids.index(previous)
            halt_all(parts[:start])
            todo = steps[start:]
        for kid, attempt in todo:
            if attempt is None:
                status = kid.update()
                kid.status = status = status if status is S or status is F or status is R else checked(kid, status)
            else:
                status = attempt()
            if status is R or status is S:
                node.current_child = kid
                if previous is not kid:
                    halt_all(parts[kids.index(kid) + 1 :])
                if status is R:
                    node.status = R
                else:
                    stop(S)
                return status
        if not kids:
            node.current_child = None
        stop(F)
        node.current_child = last
        return F

    return tick


def parallel(node: Any, parts: Sequence[Compiled], stop: Stop) -> Tick:
    """`Parallel.tick`; its policy is looked at in every tick."""
    kids = [part.node for part in parts]
    steps = [part.step for part in parts]
    initialises, validates = overrides(node, "initialise"), overrides(node, "validate_policy_configuration")
    quiet, succeeded = not overrides(node, "terminate"), [S] * len(kids)  # it may end without `stop`

    def tick() -> Status:
        policy = node.policy
        if validates or type(policy) is ParallelPolicy.SuccessOnSelected:
            node.validate_policy_configuration()
        if node.status is not R:
            halt_all(parts)
            node.current_child = None
            if initialises:
                node.initialise()
        synchronise = policy.synchronise
        for kid, advance in steps:
            if synchronise and kid.status is S:
                continue
            if advance is None:
                status = kid.update()
                kid.status = status if status is S or status is F or status is R else checked(kid, status)
            else:
                advance()
        if not kids:
            node.current_child = None
            stop(S)
            return S
        if quiet and type(policy) is ParallelPolicy.SuccessOnAll and [kid.status for kid in kids] == succeeded:
            node.current_child, node.status = kids[-1], S
            return S
        status = settle(node, kids)
        if status is not R:
            stop(status)
        node.status = status
        return status

    return tick


def settle(node: Any, kids: Sequence[Any]) -> Status:
    """Return what a parallel's policy makes of its children, and point to the child that decided."""
    node.current_child, policy = kids[-1], node.policy
    statuses = [kid.status for kid in kids]
    if F in statuses:
        node.current_child = kids[statuses.index(F)]
        return F
    if isinstance(policy, ParallelPolicy.SuccessOnAll):
        return S if statuses.count(S) == len(kids) else R
    if isinstance(policy, ParallelPolicy.SuccessOnOne):
        for kid in reversed(kids):
            if kid.status is S:
                node.current_child = kid
                return S
        return R
    if isinstance(policy, ParallelPolicy.SuccessOnSelected):
        if all([kid.status is S for kid in policy.children]):
            node.current_child = policy.children[-1]
            return S
        return R
    raise RuntimeError(f"this parallel has been configured with an unrecognised policy [{type(policy)}]") from None


def decorator(node: Any, part: Compiled, stop: Stop) -> Tick:
    """`Decorator.tick`; `update` is the node's own."""
    advance, initialises = part.tick, overrides(node, "initialise")

    def tick() -> Status:
        if initialises and node.status is not R:
            node.initialise()
        advance()
        status = checked(node, node.update())
        if status is not R:
            stop(status)
        node.status = status
        return status

    return tick
