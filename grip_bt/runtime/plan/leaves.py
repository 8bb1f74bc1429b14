"""Ticks of compiled leaves: py_trees' own, and ours with their errors and observers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from grip_bt.base.errors import NodeError

from .builtin import Builtin
from .kinds import overrides
from .parts import INVALID, VALID, F, R, S, Visit, rejected
from .stopping import Stop


def leaf(node: Any, visit: Visit | None, known: Builtin | None) -> Callable[[], Status]:
    """`Behaviour.tick`."""
    initialises, terminates = overrides(node, "initialise"), overrides(node, "terminate")

    quick = None if known is None else known.update

    def plain() -> Status:
        status: Status = node.update() if quick is None else quick()
        if status is not S and status is not F and status is not R and status not in VALID:
            status = rejected(node, status)
        node.status = status
        return status

    if not (initialises or terminates or visit):
        return plain

    def tick() -> Status:
        if initialises and node.status is not R:
            node.initialise()
        status = node.update() if quick is None else quick()
        if status is not R:
            if status is not S and status is not F and status not in VALID:
                status = rejected(node, status)
            if terminates:
                node.terminate(status)
        node.status = status
        if visit is None:
            return status
        visit(node)
        return node.status

    return tick


def our_leaf(node: Any, stop: Stop, visit: Visit | None) -> Callable[[], Status]:
    """`Leaf.tick`: an activation is reported, and what `update` raises becomes a NodeError."""
    initialises = overrides(node, "initialise")

    def activate() -> None:
        if node.status is not R:
            node.inputs_read = {}
            node.begin()
            if initialises:
                node.initialise()
        status = node.update()
        if status is not R:
            if status is not S and status is not F and status not in VALID:
                status = rejected(node, status)
            stop(status)
        node.status = status

    def failed(error: Exception) -> NodeError:
        node._abandon(error)
        return NodeError(node.path, error)

    def tick() -> Status:
        try:
            activate()
        except Exception as error:
            raise failed(error) from error
        if visit is not None:
            visit(node)
        if node.status is INVALID:
            wrong = TypeError("update() has to return SUCCESS, FAILURE or RUNNING")
            raise failed(wrong) from wrong
        return node.status

    return tick
