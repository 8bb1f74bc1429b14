"""Driving one behaviour to its end: the loop that a whole tree and a state of a machine have in common."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Protocol

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.values import Failure
from grip_bt.nodes.node import halt


class Halted(BaseException):
    """The run was stopped. It passes every `except Exception`, so that nothing recovers from it."""


class Pacer(Protocol):
    """Says when to tick. It may be asked from several threads at once."""

    def turn(self) -> int:
        """Return when it is time to tick, with a number for `rest`; this is where a pause holds.

        Raises:
            Halted: the run was stopped.
        """

    def rest(self, seen: int) -> None:
        """Return when there may be something to look at since `turn` returned `seen`."""

    def wake(self) -> None:
        """Have every `rest` return."""


def alone(count: int) -> list[AbstractContextManager[object]]:
    """Return what threads enter that work as they like, `count` of them."""
    return [nullcontext() for _ in range(count)]


class Rushing:
    """A pacer that never waits, for leaves that need no time."""

    def turn(self) -> int:
        """Tick at once."""
        return 0

    def rest(self, seen: int) -> None:
        """Don't wait."""

    def wake(self) -> None:
        """Nobody rests."""


def drive(node: Behaviour, pacer: Pacer, tick: Callable[[], object] | None = None) -> Status:
    """Tick `node` until it ends; whatever interrupts this halts everything below it first.

    Args:
        node: what to tick.
        pacer: says when.
        tick: does what `node.tick_once` does, which is the default.

    Raises:
        Halted: the run was stopped.
        NodeError: a leaf raised.
    """
    tick, running = node.tick_once if tick is None else tick, Status.RUNNING
    try:
        while True:
            seen = pacer.turn()
            tick()
            if node.status is not running:
                return node.status
            pacer.rest(seen)
    except BaseException as error:
        halt_after(error, node)
        raise


def halt_after(error: BaseException, node: Behaviour) -> None:
    """Halt everything below `node`; note with the error what else went wrong meanwhile."""
    for path, trouble in halt(node):
        error.add_note(f"while stopping {path}: {type(trouble).__name__}: {trouble}")


@dataclass(frozen=True)
class TaskEnd:
    """How a task has ended: its outcome, success or failure, and the reason of a failure."""

    outcome: str
    meaning: str
    failure: Failure | None
