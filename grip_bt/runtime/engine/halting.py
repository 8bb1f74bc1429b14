"""`stop` of compiled nodes: py_trees' own order of callbacks, without its logging and its generators.

Statuses are reset at once, not when the next tick comes to them: whoever looks sees what py_trees leaves. Where nobody
below has anything to say about it, a whole sub-tree is reset in two loops.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from py_trees.common import Status

from grip_bt.nodes.node import SILENT, STATUS

from .guard import Changed
from .known import INVALID, F, R, Rules, S, ours, overrides, plain_activation

NOTHING, LOOKED, FRESH = range(3)
"""What a node knows of all that is below it when it is ticked: nothing; that it is as it was compiled; that it is so,
and that a node above has just made all of it INVALID, so that there is nothing to reset."""

Tick = Callable[[int], Status]
"""Does what a node's `tick` does, and returns the status that its parent goes by."""

Stop = Callable[[Status], None]
"""Does what a node's `stop` does."""

Halt = Callable[[], None]
"""Does what a node's `stop(INVALID)` does."""

Reset = Callable[[int], int]
"""Stops the children that aren't INVALID; takes and returns what is known of all below."""

Pair = tuple[Any, Halt]

_status = attrgetter("status")


@dataclass(frozen=True)
class Silent:
    """A sub-tree that nobody is told of when it is reset: composites and leaves of py_trees without `terminate`."""

    composites: Sequence[Any] = ()
    leaves: Sequence[Any] = ()


@dataclass(frozen=True)
class Compiled:
    """A compiled node.

    Attributes:
        node: what was compiled.
        tick: ticks it.
        halt: halts it.
        silent: what it is reset with, where that says nothing to anybody.
        inner: nodes of the sub-tree whose children were compiled.
        nodes: all of the sub-tree.
        only_updates: it is a leaf of py_trees that overrides `update` alone.
    """

    node: Any
    tick: Tick
    halt: Halt
    nodes: Sequence[Any]
    inner: Sequence[Any] = ()
    silent: Silent | None = None
    only_updates: bool = False


def halt_all(pairs: Sequence[Pair]) -> None:
    """Stop those that aren't INVALID already."""
    for kid, halt in pairs:
        if kid.status is not INVALID:
            halt()


def silent(node: object, rules: Rules, kids: Sequence[Compiled]) -> Silent | None:
    """Return what can be reset in one go, the node included; None where somebody has to be told."""
    if ours(node) or overrides(node, "terminate"):
        return None
    if rules is Rules.LEAF:
        return Silent(leaves=[node])
    below = [kid.silent for kid in kids if kid.silent is not None]
    if rules not in (Rules.SEQUENCE, Rules.SELECTOR, Rules.PARALLEL) or len(below) < len(kids):
        return None
    return Silent(
        [node, *(inner for part in below for inner in part.composites)],
        [leaf for part in below for leaf in part.leaves],
    )


def make_reset(kids: Sequence[Compiled], changed: Changed) -> Reset:
    """Return what stops children that aren't INVALID; `changed` tells whether anything below was edited."""
    pairs = [(kid.node, kid.halt) for kid in kids]
    below = [kid.silent for kid in kids if kid.silent is not None]
    composites = [inner for part in below for inner in part.composites]
    leaves = [leaf for part in below for leaf in part.leaves]

    def one_by_one(known: int) -> int:
        halt_all(pairs)
        return known

    def in_one_go(known: int) -> int:
        # What is INVALID isn't stopped, and nor is what is below it.
        if INVALID in map(_status, composites) or (composites and not known and changed()):
            return one_by_one(known)
        for composite in composites:
            composite.current_child = None
            composite.status = INVALID
        for leaf in leaves:
            leaf.status = INVALID
        return FRESH

    return in_one_go if len(below) == len(kids) else one_by_one


def make_stop(node: object, rules: Rules, kids: Sequence[Compiled], reset: Reset) -> Stop:
    """Return what does `node.stop(status)`."""
    if rules is Rules.LEAF:
        if ours(node) and plain_activation(node) and not overrides(node, "terminate"):
            return _silent_leaf(node)
        stop = _leaf(node)
    elif rules is Rules.DECORATOR:
        stop = _decorator(node, kids[0])
    else:
        stop = _composite(node, kids, reset, sweeps=rules is Rules.PARALLEL)
    return _reporting(node, stop) if ours(node) else stop


def make_halt(node: Any, stop: Stop, changed: Changed | None) -> Halt:
    """Return what does `node.stop(INVALID)`."""

    def halt() -> None:
        if changed is not None and changed():
            node.stop(INVALID)
        else:
            stop(INVALID)

    return halt


def _leaf(node: Any) -> Stop:
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        if terminates:
            node.terminate(status)
        node.status = status

    return stop


def _silent_leaf(node: Any) -> Stop:
    """`Node.stop` of a leaf of ours that nobody tells of its end: the same as `_reporting(node, _leaf(node))`."""

    def stop(status: Status) -> None:
        if status is INVALID:
            node.outcome = node.failure = None
        elif node.outcome is None or STATUS.get(node.meaning.get(node.outcome, "")) is not status:
            node.conclude(status)
        node.status = status
        if node.active:
            report(node)

    return stop


def _composite(node: Any, kids: Sequence[Compiled], reset: Reset, sweeps: bool) -> Stop:
    """`Composite.stop`; a parallel first stops what still runs."""
    pairs = [(kid.node, kid.halt) for kid in kids] if sweeps else []
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        for kid, halt in pairs:
            if kid.status is R:
                halt()
        if status is INVALID:
            node.current_child = None
            reset(NOTHING)
        if terminates:
            node.terminate(status)
        node.status = status

    return stop


def _decorator(node: Any, kid: Compiled) -> Stop:
    child, halt = kid.node, kid.halt
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        if terminates:
            node.terminate(status)
        if status is INVALID:
            halt()
        if child.status is R:
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
                report(node)

    return stop


def report(node: Any) -> None:
    """Tell the observer how an activation that was under way is over."""
    node.active = False
    if node.observer is SILENT:
        return
    if node.outcome is None:
        node.observer.interrupted(node.path)
    else:
        node.observer.ended(node.path, node.outcome, node.failure)
