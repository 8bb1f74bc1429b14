"""Ticks of compiled composites of py_trees, line by line what their generators do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from py_trees.common import ParallelPolicy, Status

from .hooks import Ended
from .kinds import overrides
from .parts import INVALID, F, Part, R, S, Visit
from .stopping import Stop

Tick = Callable[[], Status]


def halt_all(pairs: Sequence[tuple[Any, Callable[[], None]]]) -> None:
    """Stop those that aren't INVALID already."""
    for kid, halt in pairs:
        if kid.status is not INVALID:
            halt()


def sequence(node: Any, parts: Sequence[Part], stop: Stop, visit: Visit | None, ended: Ended | None) -> Tick:
    """`Sequence.tick`."""
    kids = [part.node for part in parts]
    pairs = [(part.node, part.halt) for part in parts]
    steps = [(i, part.node, part.tick) for i, part in enumerate(parts)]
    first, last = (kids[0] if kids else None), len(kids) - 1
    memory, initialises = node.memory, overrides(node, "initialise")

    def tick() -> Status:
        todo = steps
        if node.status is not R:
            node.current_child = first
            halt_all(pairs)
            if initialises:
                node.initialise()
        elif memory and node.current_child is not None:
            todo = steps[kids.index(node.current_child) :]
        else:
            node.current_child = first
        for i, kid, advance in todo:
            status = advance()
            if ended is not None and ended(kid):
                return node.status
            if status is not S:
                if not memory:
                    halt_all(pairs[i + 1 :])
                return finish(kid.status)
            if i < last:
                node.current_child = kids[i + 1]
        if first is None:
            node.current_child = None
        return finish(S)

    def finish(status: Status) -> Status:
        if status is R:
            node.status = status
        else:
            stop(status)
        if visit is not None:
            visit(node)
        return node.status

    return tick


def selector(node: Any, parts: Sequence[Part], stop: Stop, visit: Visit | None, ended: Ended | None) -> Tick:
    """`Selector.tick`."""
    kids = [part.node for part in parts]
    pairs = [(part.node, part.halt) for part in parts]
    steps = [(i, part.node, part.tick) for i, part in enumerate(parts)]
    first = kids[0] if kids else None
    memory, initialises = node.memory, overrides(node, "initialise")

    def tick() -> Status:
        if node.status is not R:
            node.current_child = first
            if initialises:
                node.initialise()
        if first is None:
            node.current_child = None
            return finish(F)
        todo = steps
        if memory:
            assert node.current_child is not None
            start = kids.index(node.current_child)
            halt_all(pairs[:start])
            todo = steps[start:]
        previous = node.current_child
        for i, kid, attempt in todo:
            status = attempt()
            if ended is not None and ended(kid):
                return node.status
            if status is R or status is S:
                node.current_child = kid
                if previous is not kid:
                    halt_all(pairs[i + 1 :])
                return finish(kid.status)
        stop(F)
        node.current_child = kids[-1]
        return seen()

    def finish(status: Status) -> Status:
        if status is S or first is None:
            stop(status)
        else:
            node.status = status
        return seen()

    def seen() -> Status:
        if visit is not None:
            visit(node)
        return node.status

    return tick


def parallel(node: Any, parts: Sequence[Part], stop: Stop, visit: Visit | None) -> Tick:
    """`Parallel.tick`."""
    kids = [part.node for part in parts]
    pairs = [(part.node, part.halt) for part in parts]
    steps = [(part.node, part.tick) for part in parts]
    initialises = overrides(node, "initialise")

    def tick() -> Status:
        node.validate_policy_configuration()
        if node.status is not R:
            halt_all(pairs)
            node.current_child = None
            if initialises:
                node.initialise()
        if not kids:
            node.current_child = None
            stop(S)
        else:
            for kid, advance in steps:
                if not (node.policy.synchronise and kid.status is S):
                    advance()
            status = settle(node, kids)
            if status is not R:
                stop(status)
            node.status = status
        if visit is not None:
            visit(node)
        return node.status

    return tick


def settle(node: Any, kids: Sequence[Any]) -> Status:
    """Return what a parallel's policy makes of its children, and point to the child that decided."""
    node.current_child = kids[-1]
    for kid in kids:
        if kid.status is F:
            node.current_child = kid
            return F
    policy = node.policy
    if isinstance(policy, ParallelPolicy.SuccessOnAll):
        return S if all(kid.status is S for kid in kids) else R
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
