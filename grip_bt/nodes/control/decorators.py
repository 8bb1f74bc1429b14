"""Decorators: py_trees' own where it has them, on the run's clock, with labelled ends and reasons."""

from __future__ import annotations

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.values import Failure

from ..node import STATUS
from .container import Container, Face

FOREVER = -1
"""What py_trees' Repeat takes for a number without limit."""


class Retry(Container, decorators.Retry):
    """The child again until it succeeds, at most `times` times in all; one attempt a tick.

    When all attempts have failed it fails with the reason of the last one.
    """

    def __init__(self, face: Face, child: Behaviour, times: int):
        decorators.Retry.__init__(self, face.name, child, times)
        self.take(face)

    def update(self) -> Status:
        """Count, and have the next attempt ticked soon."""
        return _next_attempt(self, decorators.Retry.update(self))


class Repeat(Container, decorators.Repeat):
    """The child again, `times` times in all or until it fails; without `times`, for ever. One attempt a tick."""

    def __init__(self, face: Face, child: Behaviour, times: int | None = None):
        decorators.Repeat.__init__(self, face.name, child, FOREVER if times is None else times)
        self.take(face)

    def update(self) -> Status:
        """Count, and have the next attempt ticked soon."""
        return _next_attempt(self, decorators.Repeat.update(self))


def _next_attempt(node: Retry | Repeat, status: Status) -> Status:
    if status == Status.RUNNING and node.decorated.status != Status.RUNNING:
        node.context.wake()
    return status


class Timeout(Container, decorators.Timeout):
    """Fails with the reason `time_out` when its child still runs `seconds` [s] of the run's clock after it began.

    The time is looked at after the child was ticked: a child that finishes at the deadline has finished.
    """

    def __init__(self, face: Face, child: Behaviour, seconds: float):
        decorators.Timeout.__init__(self, face.name, child, seconds)
        self.take(face)
        self.timed_out = False

    def initialise(self) -> None:
        """Set the deadline and ask to be ticked then."""
        self.timed_out = False
        self.finish_time = self.context.clock.now() + self.duration
        self.context.wake_at(self.finish_time)

    def update(self) -> Status:
        """Pass on what the child ended with, or interrupt it when its time is over."""
        if self.decorated.status != Status.RUNNING:
            return self.decorated.status
        if self.context.clock.now() < self.finish_time:
            return Status.RUNNING
        self.timed_out = True
        self.decorated.stop(Status.INVALID)
        return Status.FAILURE

    def reason(self) -> Failure | None:
        """Return `time_out`, or the child's reason when it failed in time."""
        if not self.timed_out:
            return super().reason()
        return time_out(self.decorated.name, self.duration)


def time_out(child: str, seconds: float) -> Failure:
    """Return the reason of a timeout."""
    return Failure("time_out", f"{child} was still running after {seconds:g} s")


class Invert(Container, decorators.Inverter):
    """Success becomes failure and failure becomes success; neither has a reason."""

    def __init__(self, face: Face, child: Behaviour):
        decorators.Inverter.__init__(self, face.name, child)
        self.take(face)


class Force(Container, decorators.Decorator):
    """Ends with a given outcome, whatever the child ended with; a forced failure keeps the child's reason."""

    def __init__(self, face: Face, child: Behaviour, outcome: str):
        decorators.Decorator.__init__(self, face.name, child)
        self.take(face)
        self.forced = outcome

    def update(self) -> Status:
        """Wait for the child's end."""
        if self.decorated.status == Status.RUNNING:
            return Status.RUNNING
        return STATUS[self.meaning[self.forced]]
