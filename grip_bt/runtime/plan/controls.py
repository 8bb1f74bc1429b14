"""Ticks of compiled decorators, and of the composites that are ours alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from py_trees.common import Status

from grip_bt.base.errors import LivelockError, NodeError
from grip_bt.nodes.control.dispatch import MAX_TRANSITIONS

from .composites import halt_all
from .hooks import Ended
from .kinds import overrides
from .parts import INVALID, VALID, F, Part, R, S, Visit, rejected
from .stopping import Stop

Tick = Callable[[], Status]


def decorator(node: Any, part: Part, stop: Stop, visit: Visit | None, ended: Ended | None) -> Tick:
    """`Decorator.tick`."""
    kid, advance = part.node, part.tick
    initialises = overrides(node, "initialise")

    def tick() -> Status:
        if initialises and node.status is not R:
            node.initialise()
        advance()
        if ended is not None and ended(kid):
            return node.status
        status = node.update()
        if status is not R:
            if status is not S and status is not F and status not in VALID:
                status = rejected(node, status)
            stop(status)
        node.status = status
        if visit is not None:
            visit(node)
        return node.status

    return tick


def rounds(node: Any, parts: Sequence[Part], stop: Stop, visit: Visit | None, ended: Ended) -> Tick:
    """The tick of our parallel: every unfinished child, or with `retick` every child, then the rule."""
    pairs = [(part.node, part.halt) for part in parts]
    steps = [(part.node, part.tick) for part in parts]
    initialises = overrides(node, "initialise")

    def tick() -> Status:
        if node.status is not R:
            halt_all(pairs)
            node.current_child = None
            if initialises:
                node.initialise()
        for kid, advance in steps:
            if node.retick or (kid.status is not S and kid.status is not F):
                advance()
                ended(kid)
        status = node.settle()
        if status is not R:
            stop(status)
        node.status = status
        if visit is not None:
            visit(node)
        return node.status

    return tick


def transitions(node: Any, parts: Sequence[Part], visit: Visit | None, ended: Ended) -> Tick:
    """The tick of our state machine: the active child, and along its edge when it ends."""
    ticks = {id(part.node): part.tick for part in parts}
    initialises = overrides(node, "initialise")

    def tick() -> Status:
        if node.status is not R:
            node.current_child = node.initial
            if initialises:
                node.initialise()
        for _ in range(MAX_TRANSITIONS):
            kid = node.current_child
            ticks[id(kid)]()
            ended(kid)
            if kid.status is R:
                break
            successor = node.follow(kid)
            if successor is None:
                return seen()
            node.current_child = successor
            if not node.run_to_completion:
                node.context.wake()
                break
        else:
            raise LivelockError(node.path, MAX_TRANSITIONS)
        node.status = R
        return seen()

    def seen() -> Status:
        if visit is not None:
            visit(node)
        return node.status

    return tick


def turns(node: Any, parts: Sequence[Part], visit: Visit | None, ended: Ended) -> Tick:
    """The tick of our switch, loop, for_each and cooldown: the chosen child, one choice a tick."""
    ticks = {id(part.node): part.tick for part in parts}

    def tick() -> Status:
        if node.status is not R:
            node.current_child = None
            node.rule.begin()
        if node.current_child is not None or node.chosen():
            kid = node.current_child
            assert kid is not None, "somebody was chosen"
            ticks[id(kid)]()
            if ended(kid):
                return node.status
            node.follow(kid)
        if visit is not None:
            visit(node)
        return node.status

    return tick


def gate(node: Any, inner: Tick, stop: Stop, visit: Visit | None) -> Tick:
    """The tick of our guard and timeout: that of a decorator while it is open."""

    def tick() -> Status:
        if node.open():
            return inner()
        stop(F)
        if visit is not None:
            visit(node)
        return node.status

    return tick


def conditional(node: Any, inner: Tick, visit: Visit | None) -> Tick:
    """`Conditional.tick`: look at the precondition before an activation begins."""

    def tick() -> Status:
        if node.status is R:
            return inner()
        try:
            holds = node.precondition.holds()
        except Exception as error:
            node.begin()
            node.stop(INVALID)
            raise NodeError(node.path, error) from error
        if holds:
            return inner()
        node.begin()
        node._refuse()
        if visit is not None:
            visit(node)
        return node.status

    return tick
