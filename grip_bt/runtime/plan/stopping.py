"""`stop` of compiled nodes: py_trees' own order of callbacks, without its logging and its generators."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from py_trees.common import Status

from .kinds import DECORATORS, Kind, ours, overrides
from .parts import INVALID, F, Part, R, S

Stop = Callable[[Status], None]


def make_stop(node: Any, kind: Kind, kids: Sequence[Part], changed: Callable[[], bool]) -> Stop:
    """Return what does `node.stop(status)`.

    Args:
        node: what is stopped.
        kind: its rules; not FOREIGN.
        kids: its compiled children.
        changed: tells whether `kids` is out of date; then the node's own `stop` is called.
    """
    if kind is Kind.LEAF:
        stop = _leaf(node)
    elif kind in DECORATORS:
        stop = _decorator(node, kids[0])
    else:
        stop = _composite(node, kids, sweeps=kind in (Kind.PARALLEL, Kind.ROUNDS))
    if ours(node):
        stop = _reporting(node, stop)
    return stop if kind is Kind.LEAF else _guarded(node, stop, changed)


def make_halt(stop: Stop) -> Callable[[], None]:
    """Return what does `node.stop(INVALID)`."""

    def halt() -> None:
        stop(INVALID)

    return halt


def _guarded(node: Any, stop: Stop, changed: Callable[[], bool]) -> Stop:
    def guarded(status: Status) -> None:
        if changed():
            node.stop(status)
        else:
            stop(status)

    return guarded


def _leaf(node: Any) -> Stop:
    if overrides(node, "terminate"):

        def stop(status: Status) -> None:
            node.terminate(status)
            node.status = status

    else:

        def stop(status: Status) -> None:
            node.status = status

    return stop


def _composite(node: Any, kids: Sequence[Part], sweeps: bool) -> Stop:
    """`Composite.stop`; a parallel first stops what still runs."""
    pairs = [(kid.node, kid.halt) for kid in kids]
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        if sweeps:
            for kid, halt in pairs:
                if kid.status is R:
                    halt()
        if status is INVALID:
            node.current_child = None
            for kid, halt in pairs:
                if kid.status is not INVALID:
                    halt()
        if terminates:
            node.terminate(status)
        node.status = status

    return stop


def _decorator(node: Any, part: Part) -> Stop:
    kid, halt = part.node, part.halt
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        if terminates:
            node.terminate(status)
        if status is INVALID:
            halt()
        if kid.status is R:
            halt()
        node.status = status

    return stop


def _reporting(node: Any, inner: Stop) -> Stop:
    """`Node.stop`: settle the labelled end before, tell the observer after."""

    def stop(status: Status) -> None:
        if status is S or status is F:
            node.conclude(status)
        else:
            node.outcome = node.failure = None
        try:
            inner(status)
        finally:
            if node.active:
                node.active = False
                if node.outcome is None:
                    node.observer.interrupted(node.path)
                else:
                    node.observer.ended(node.path, node.outcome, node.failure)

    return stop
