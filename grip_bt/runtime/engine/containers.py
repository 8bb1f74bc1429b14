"""Ticks of compiled containers of ours: what they add around those of py_trees, and those that are ours alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from py_trees.common import Status

from grip_bt.base.errors import LivelockError, NodeError
from grip_bt.nodes.control.dispatch import MAX_TRANSITIONS
from grip_bt.task.kinds.base import Run

from .composites import Added, Look, decorator
from .halting import Compiled, Reset, Stop, Tick
from .known import F, R, S, overrides


def added_by(node: Any) -> Added:
    """Return what `Container.tick` does around that of the class of py_trees."""
    at_once = bool(node.exits) and node.exits_at_once

    def begin() -> None:
        node.last_child = None
        node.begin()
        if node.enter is not None:
            node.enter()

    def ended(kid: Any) -> bool:
        if kid.status is not S and kid.status is not F:
            return False
        node.last_child = kid
        label = node.exit_of(kid) if at_once else None
        if label is None:
            return False
        node.leave(label, kid)
        return True

    return Added(begin, ended)


def conditional(node: Any, look: Look | None, inner: Tick) -> Tick:
    """`Conditional.tick`: look at the precondition before an activation begins."""

    def tick(known: int) -> Status:
        if not known and look is not None:
            known = node.status is not R
            if (look.changed_below if known else look.changed)():
                return look.outdated(known)
        if node.status is R:
            return inner(known)
        try:
            holds = node.precondition.holds()
        except Exception as error:
            node.begin()
            node.stop(Status.INVALID)
            raise NodeError(node.path, error) from error
        if holds:
            return inner(known)
        node.begin()
        node._refuse()
        return F

    return tick


def gate(node: Any, look: Look, part: Compiled, stop: Stop, added: Added) -> Tick:
    """The tick of our guard and timeout: that of a decorator while it is open."""
    changed, changed_below, outdated = look
    begin, ended = added
    inner = decorator(node, look, part, stop, Added(_nothing, ended))

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        if node.status is not R:
            begin()
        if node.open():
            return inner(known)
        stop(F)
        return F

    return tick


def _nothing() -> None:
    pass


def rounds(node: Any, look: Look, parts: Sequence[Compiled], stop: Stop, reset: Reset, added: Added) -> Tick:
    """The tick of our parallel: every unfinished child, or with `retick` every child, then the rule."""
    changed, changed_below, outdated = look
    begin, ended = added
    steps = [(part.node, part.tick) for part in parts]
    last = parts[-1].node if parts else None
    initialises = overrides(node, "initialise")

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        if node.status is not R:
            begin()
            reset(known)
            node.current_child = None
            if initialises:
                node.initialise()
        undecided = last is not None
        for kid, advance in steps:
            if node.retick or (kid.status is not S and kid.status is not F):
                if advance(known) is R:
                    continue
                ended(kid)
            undecided = False
        if undecided:  # by no rule, while nobody has ended
            node.current_child, node.status = last, R
            return R
        status: Status = node.settle()
        if status is not R:
            stop(status)
        node.status = status
        return status

    return tick


def transitions(node: Any, look: Look, parts: Sequence[Compiled], added: Added) -> Tick:
    """The tick of our state machine: the active child, and along its edge when it ends."""
    changed, changed_below, outdated = look
    begin, ended = added
    ticks = {id(part.node): part.tick for part in parts}
    initialises = overrides(node, "initialise")

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        if node.status is not R:
            begin()
            node.current_child = node.initial
            if initialises:
                node.initialise()
        for _ in range(MAX_TRANSITIONS):
            kid = node.current_child
            ticks[id(kid)](known)
            if kid.status is R:
                break
            ended(kid)
            successor = node.follow(kid)
            if successor is None:
                return node.status
            node.current_child = successor
            if not node.run_to_completion:
                node.context.wake()
                break
        else:
            raise LivelockError(node.path, MAX_TRANSITIONS)
        node.status = R
        return R

    return tick


def automaton(node: Any, look: Look, parts: Sequence[Compiled]) -> Tick:
    """The tick of a container whose kind is an automaton."""
    changed, changed_below, outdated = look
    ticks = [part.tick for part in parts]
    kids = [part.node for part in parts]

    def tick(known: int) -> Status:
        if not known:
            known = node.status is not R
            if (changed_below if known else changed)():
                return outdated(known)
        step = node.opening()
        while type(step) is Run:
            run = node.run(step)
            following = None
            for i in run:
                ticks[i](known)
                if kids[i].status is not R:
                    following = node.after(i, kids[i])
                    if following is not None:
                        break
            step = following if following is not None else node.ticked(run)
        node.land(step)
        return node.status

    return tick
