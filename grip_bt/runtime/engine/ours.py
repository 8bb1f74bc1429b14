"""Ticks of our own nodes: leaves with their errors, preconditions, and one for every kind of container."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.task.kinds.base import Run

from .halting import Compiled, Stop, Tick, halt_all
from .known import INVALID, F, R, overrides
from .theirs import checked


def our_leaf(node: Any, stop: Stop) -> Tick:
    """`Leaf.tick`: an activation is reported, and what `update` raises becomes a NodeError."""
    initialises = overrides(node, "initialise")

    def tick() -> Status:
        try:
            if node.status is not R:
                node.inputs_read = {}
                node.begin()
                if initialises:
                    node.initialise()
            status = checked(node, node.update())
            if status is not R:
                stop(status)
            node.status = status
            if status is INVALID:
                raise TypeError("update() has to return SUCCESS, FAILURE or RUNNING")
        except Exception as error:
            node._abandon(error)
            raise NodeError(node.path, error) from error
        return status

    return tick


def conditional(node: Any, inner: Tick) -> Tick:
    """`Conditional.tick`: look at the precondition before an activation begins."""

    def tick() -> Status:
        if node.status is R:
            return inner()
        try:
            holds = node.precondition.holds()
        except Exception as error:
            node.begin()
            node.stop(Status.INVALID)
            raise NodeError(node.path, error) from error
        if holds:
            return inner()
        node.begin()
        node._refuse()
        return F

    return tick


def automaton(node: Any, parts: Sequence[Compiled], stop: Stop) -> Tick:
    """The tick of a container, whatever its kind: `KindNode.tick`, without its generators."""
    kids, ticks, kind = [part.node for part in parts], [part.tick for part in parts], node.kind
    reset = partial(halt_all, parts)
    reactive, patient, again = kind.reactive, kind.concurrent or not kind.settles, kind.again

    def tick() -> Status:
        before, step = node.running, None
        if node.status is not R or node.resting or not before:
            step, before = node.opening(reset), node.running
        elif reactive:
            step = again(node.state, before, node.answers)
        while step is None or type(step) is Run:
            if step is None:
                run = before
            elif step[0] == before and not kind.concurrent:
                run, node.state = before, step[1]
            else:
                run = node.run(step)
            step, going = None, patient and run is before
            for i in run:
                if ticks[i]() is not R:
                    going = False
                    step = node.after(i, kids[i])
                    if step is not None:
                        break
            if going:
                node.status = R
                return R
            if step is None:
                step = node.ticked(run)
        node.land(step, stop)
        return node.status

    return tick
