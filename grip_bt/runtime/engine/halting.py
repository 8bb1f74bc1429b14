"""`stop` of compiled nodes: py_trees' own order of callbacks, without its logging and its generators."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from py_trees.common import Status

from .known import INVALID, F, R, Rules, S, ours, overrides

Tick = Callable[[], Status]
"""Does what a node's `tick` does, and returns the status that its parent goes by."""

Stop = Callable[[Status], None]
"""Does what a node's `stop` does."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """A compiled node.

    Attributes:
        plain: it is a leaf of py_trees that overrides `update` alone: parents call that, and reset it, in place.
    """

    node: Any
    tick: Tick
    stop: Stop
    plain: bool = False

    @property
    def step(self) -> tuple[Any, Tick | None]:
        """The node with its tick; None for a plain one."""
        return self.node, None if self.plain else self.tick


def halt_all(parts: Sequence[Compiled]) -> None:
    """Stop those that aren't INVALID already."""
    for part in parts:
        node = part.node
        if node.status is not INVALID:
            if part.plain:
                node.status = INVALID
            else:
                part.stop(INVALID)


def make_stop(node: object, rules: Rules, parts: Sequence[Compiled]) -> Stop:
    """Return what does `node.stop(status)`."""
    if rules is Rules.LEAF:
        stop = _leaf(node)
    elif rules is Rules.DECORATOR:
        stop = _decorator(node, parts[0])
    else:
        stop = _composite(node, parts, sweeps=rules is Rules.PARALLEL)
    return _reporting(node, stop) if ours(node) else stop


def _leaf(node: Any) -> Stop:
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        if terminates:
            node.terminate(status)
        node.status = status

    return stop


def _composite(node: Any, parts: Sequence[Compiled], sweeps: bool) -> Stop:
    """`Composite.stop`; a parallel first stops what still runs."""
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        if sweeps:
            for part in parts:
                if part.node.status is R:
                    part.stop(INVALID)
        if status is INVALID:
            node.current_child = None
            halt_all(parts)
        if terminates:
            node.terminate(status)
        node.status = status

    return stop


def _decorator(node: Any, part: Compiled) -> Stop:
    child, halt = part.node, part.stop
    terminates = overrides(node, "terminate")

    def stop(status: Status) -> None:
        if terminates:
            node.terminate(status)
        if status is INVALID:
            halt(INVALID)
        if child.status is R:
            halt(INVALID)
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
            node.report()

    return stop
