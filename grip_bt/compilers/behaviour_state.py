"""A behaviour as one state of a machine, and the loop that drives one to its end, which whole trees have too."""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Protocol

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.ports import Context
from grip_bt.base.values import Failure
from grip_bt.compilers.binding import prepare
from grip_bt.nodes.node import AskedContext, Node, halt
from grip_bt.smach_compat import State


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
        return 0

    def rest(self, seen: int) -> None:
        """Don't wait."""

    def wake(self) -> None:
        """Nobody rests."""


def drive(node: Behaviour, pacer: Pacer, tick: Callable[[], object] | None = None) -> Status:
    """Tick `node` until it ends; whatever interrupts this halts everything below it first.

    Args:
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
        for path, raised in halt(node):
            error.add_note(f"while stopping {path}: {type(raised).__name__}: {raised}")
        raise


@dataclass(frozen=True)
class TaskEnd:
    """How a task has ended: its outcome, success or failure, and the reason of a failure."""

    outcome: str
    meaning: str
    failure: Failure | None


Refined = Collection[tuple[str, str]]
"""(outcome, failure code) pairs that have a label of their own, `outcome.code`."""


MakeTicker = Callable[[Node], Callable[[], object]]


class MachineRun:
    """What the states of one machine share while it runs; the pacer of each of them.

    Attributes:
        make_ticker: makes, for a behaviour, what does its `tick_once`; None for that itself.
        error: the first exception raised below. smach wraps exceptions, so that the original is kept here; the states
            in other threads end because of it.
    """

    def __init__(self) -> None:
        self.pacer: Pacer = Rushing()
        self.make_ticker: MakeTicker | None = None
        self.error: BaseException | None = None

    def turn(self) -> int:
        seen = self.pacer.turn()
        if self.error is not None:
            raise Halted
        return seen

    def rest(self, seen: int) -> None:
        self.pacer.rest(seen)

    def wake(self) -> None:
        self.pacer.wake()

    def fork(self, count: int) -> list[AbstractContextManager[object]]:
        fork = getattr(self.pacer, "fork", alone)  # a pacer may say in which order they work
        return fork(count)

    def joined(self) -> AbstractContextManager[object]:
        joined: Callable[[], AbstractContextManager[object]] = getattr(self.pacer, "joined", nullcontext)
        return joined()

    def fail(self, error: BaseException) -> None:
        """Keep the first error and have the other states end."""
        self.error = self.error or error
        self.pacer.wake()


class TaskState(State):
    """Mixed into states and containers that stand for a node: what they ended with, and why.

    Attributes:
        outcome: the label of the last end, without a code.
    """

    path: str
    outcome: str | None = None
    failure: Failure | None = None


def labels(outcomes: Collection[str], refined: Refined) -> list[str]:
    """Return the outcomes of a state: the node's own, and one for each refinement by a failure code."""
    return [*outcomes, *(f"{outcome}.{code}" for outcome, code in sorted(refined))]


def label(outcome: str, failure: Failure | None, refined: Refined) -> str:
    """Return the outcome that a state returns for this end."""
    if refined and failure is not None and (outcome, failure.code) in refined:
        return f"{outcome}.{failure.code}"
    return outcome


class BehaviourState(TaskState):
    """Ticks a behaviour until it ends, waiting for what it waits for, and returns the label of its end."""

    def __init__(self, node: Node, run: MachineRun, refined: Refined = ()):
        State.__init__(self, labels(node.meaning, refined))
        self.node, self.run, self.refined = node, run, frozenset(refined)
        self.path = node.path
        self._tick: Callable[[], object] = node.tick_once
        self._make_ticker: MakeTicker | None = None

    def prepare(self, context: Context) -> None:
        """Give every node below its context, in which a preempt request of this state is seen."""
        prepare(self.node.iterate(), AskedContext(context, self.preempt_requested))

    def execute(self, userdata: object) -> str:
        run, node = self.run, self.node
        if self._make_ticker is not run.make_ticker:
            self._make_ticker = run.make_ticker
            self._tick = node.tick_once if self._make_ticker is None else self._make_ticker(node)
        try:
            drive(node, run, self._tick)
        except BaseException as error:
            run.fail(error)
            raise
        self.outcome = outcome = node.outcome
        self.failure = failure = node.failure
        assert outcome is not None, "a behaviour that ended has an outcome"
        return label(outcome, failure, self.refined) if self.refined else outcome
