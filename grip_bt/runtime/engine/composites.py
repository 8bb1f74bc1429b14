"""Ticks of compiled composites and decorators of py_trees, line by line what their generators do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from py_trees.common import ParallelPolicy, Status

from .guard import Changed
from .halting import FRESH, Compiled, Reset, Stop, Tick, halt_all
from .known import VALID, F, R, S, overrides, plain_validation
from .leaves import rejected


class Look(NamedTuple):
    """How an inner node sees at the beginning of a tick whether it is as it was compiled.

    Attributes:
        changed: tells whether it isn't.
        changed_below: tells whether anything below it isn't either, which is looked at when an activation begins.
        outdated: ticks it by its own generator then, and has the tree compiled anew before the next tick.
    """

    changed: Changed
    changed_below: Changed
    outdated: Tick


_ALL = ParallelPolicy.SuccessOnAll
_PLAIN_POLICIES = (_ALL, ParallelPolicy.SuccessOnOne)


def steps_of(parts: Sequence[Compiled]) -> list[tuple[Any, Tick | None]]:
    """Return each child with its tick; None for a leaf that is nothing but its `update`, which is called in place."""
    return [(part.node, None if part.only_updates else part.tick) for part in parts]


def sequence(node: Any, look: Look, parts: Sequence[Compiled], stop: Stop, reset: Reset) -> Tick:
    """`Sequence.tick`."""
    changed, changed_below, outdated = look
    kids = [part.node for part in parts]
    pairs = [(part.node, part.halt) for part in parts]
    following = [*kids[1:], *kids[-1:]]
    steps = [(*step, successor) for step, successor in zip(steps_of(parts), following, strict=True)]
    first = kids[0] if kids else None
    memory, initialises, terminates = node.memory, overrides(node, "initialise"), overrides(node, "terminate")
    quick = not terminates  # it may end without `stop`

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        todo = steps
        if node.status is not R:
            node.current_child = first
            if known is not FRESH:
                known = reset(known)
            if initialises:
                node.initialise()
        else:
            at = node.current_child if memory else None
            node.current_child = first if at is None else at
            todo = steps if at is None else steps[kids.index(at) :]
        for kid, advance, successor in todo:
            if advance is None:
                said = kid.update()
                valid = said is S or said is F or said is R or said in VALID
                kid.status = status = said if valid else rejected(kid, said)
            else:
                status = advance(known)
            if status is not S:
                if not memory:
                    halt_all(pairs[kids.index(kid) + 1 :])
                if status is R:
                    node.status = R
                else:
                    stop(status)
                return status
            node.current_child = successor
        if quick:
            node.status = S
        else:
            stop(S)
        return S

    return tick if kids else _childless(node, look, stop, S)


def selector(node: Any, look: Look, parts: Sequence[Compiled], stop: Stop) -> Tick:
    """`Selector.tick`."""
    changed, changed_below, outdated = look
    kids = [part.node for part in parts]
    pairs = [(part.node, part.halt) for part in parts]
    steps = steps_of(parts)
    first, last = (kids[0], kids[-1]) if kids else (None, None)
    memory, initialises, terminates = node.memory, overrides(node, "initialise"), overrides(node, "terminate")
    quick = not terminates

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        if node.status is not R:
            node.current_child = first
            if initialises:
                node.initialise()
        previous, todo = node.current_child, steps
        if memory and previous is not first:
            assert previous is not None
            start = kids.index(previous)
            halt_all(pairs[:start])
            todo = steps[start:]
        for kid, attempt in todo:
            if attempt is None:
                said = kid.update()
                valid = said is S or said is F or said is R or said in VALID
                kid.status = status = said if valid else rejected(kid, said)
            else:
                status = attempt(known)
            if status is R or status is S:
                node.current_child = kid
                if previous is not kid:
                    halt_all(pairs[kids.index(kid) + 1 :])
                if status is R:
                    node.status = R
                else:
                    stop(S)
                return status
        if quick:
            node.status = F
        else:
            stop(F)
        node.current_child = last
        return F

    return tick if kids else _childless(node, look, stop, F)


def _childless(node: Any, look: Look, stop: Stop, status: Status) -> Tick:
    """The tick of a sequence or selector without children, which ends at once."""
    changed, changed_below, outdated = look
    initialises = overrides(node, "initialise")

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        if node.status is not R:
            node.current_child = None
            if initialises:
                node.initialise()
        node.current_child = None
        stop(status)
        return status

    return tick


def parallel(node: Any, look: Look, parts: Sequence[Compiled], stop: Stop, reset: Reset) -> Tick:
    """`Parallel.tick`; its policy is looked at in every tick."""
    changed, changed_below, outdated = look
    kids = [part.node for part in parts]
    steps = steps_of(parts)
    initialises, validates = overrides(node, "initialise"), not plain_validation(node)
    quick, count, last = not overrides(node, "terminate"), len(kids), kids[-1] if kids else None

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        policy = node.policy
        if validates or type(policy) not in _PLAIN_POLICIES:
            node.validate_policy_configuration()
        if node.status is not R:
            if known is not FRESH:
                known = reset(known)
            node.current_child = None
            if initialises:
                node.initialise()
        synchronise = policy.synchronise
        for kid, advance in steps:
            if synchronise and kid.status is S:
                continue
            if advance is None:
                said = kid.update()
                valid = said is S or said is F or said is R or said in VALID
                kid.status = said if valid else rejected(kid, said)
            else:
                advance(known)
        if not kids:
            node.current_child = None
            stop(S)
            return S
        if quick and type(policy) is _ALL and len([kid for kid in kids if kid.status is S]) == count:
            node.current_child, node.status = last, S
            return S
        status = settle(node, kids)
        if status is not R:
            stop(status)
        node.status = status
        return status

    return tick


def settle(node: Any, kids: Sequence[Any]) -> Status:
    """Return what a parallel's policy makes of its children, and point to the child that decided."""
    complete = True
    for kid in kids:
        status = kid.status
        if status is F:
            node.current_child = kid
            return F
        if status is not S:
            complete = False
    node.current_child = kids[-1]
    policy = node.policy
    if isinstance(policy, ParallelPolicy.SuccessOnAll):
        return S if complete else R
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


def decorator(node: Any, look: Look, part: Compiled, stop: Stop) -> Tick:
    """`Decorator.tick`; `update` is the node's own."""
    changed, changed_below, outdated = look
    advance = part.tick
    initialises = overrides(node, "initialise")

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        if node.status is not R:
            if initialises:
                node.initialise()
        advance(known)
        status: Status = node.update()
        if status is not R:
            if status is not S and status is not F and status not in VALID:
                status = rejected(node, status)
            stop(status)
        node.status = status
        return status

    return tick
