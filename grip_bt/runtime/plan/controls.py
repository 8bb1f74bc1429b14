"""Ticks of compiled decorators, and of the composites that are ours alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from py_trees.common import Status

from grip_bt.errors import LivelockError
from grip_bt.nodes.control.dispatch import MAX_TRANSITIONS

from .composites import halt_all
from .hooks import Ended
from .kinds import overrides
from .parts import VALID, F, Part, R, S, Visit, rejected
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
    """The tick of our parallel: every unfinished child, then the rule."""
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
            if kid.status is not S and kid.status is not F:
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
