"""Ticks of compiled containers of ours: one for every kind, which is asked what follows what."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.task.kinds.base import Run

from .composites import Look
from .halting import Compiled, Tick
from .known import F, R


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
