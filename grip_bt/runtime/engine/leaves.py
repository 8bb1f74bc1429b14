"""Ticks of compiled leaves, py_trees' own and ours with their errors and observers, and of nodes left to py_trees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError

from .halting import Stop, Tick
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
