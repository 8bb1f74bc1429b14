"""Decorators: py_trees' own where it has them, on the run's clock, with labelled ends and reasons."""

from __future__ import annotations

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.values import Failure

from ..node import STATUS
from .container import Container, Face
from .guard import _Gate

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


class Timeout(Container, _Gate, decorators.Timeout):
    """Fails with the reason `time_out` when its child still runs `seconds` [s] of the run's clock after it began.

    The clock is looked at once a tick, before the child: from the deadline on the child is halted, and nothing in it
    begins or is ticked any more. With `child_first` it is looked at after the child, as py_trees' own does.
    """

    finish_time: float
    initialise = Behaviour.initialise  # py_trees' would set another deadline, by the wall's clock

    def __init__(self, face: Face, child: Behaviour, seconds: float, child_first: bool = False):
        decorators.Timeout.__init__(self, face.name, child, seconds)
        self.take(face)
        self.child_first, self.timed_out = child_first, False

    def open(self) -> bool:
        """Set the deadline on entry, and ask to be ticked then; look at the clock, unless the child comes first."""
        if self.status != Status.RUNNING:
            self.finish_time = self.context.clock.now() + self.duration
            self.context.wake_at(self.finish_time)
        self.timed_out = not self.child_first and self.over()
        return not self.timed_out

    def over(self) -> bool:
        """Tell whether the deadline is reached."""
        return self.context.clock.now() >= self.finish_time

    def update(self) -> Status:
        """Pass on what the child ended with; with `child_first` interrupt it when its time is over."""
        if self.decorated.status != Status.RUNNING or not self.child_first or not self.over():
            return self.decorated.status
        self.timed_out = True
        return Status.FAILURE

    def reason(self) -> Failure | None:
        """Return `time_out`, or the child's reason when it failed in time."""
        if not self.timed_out:
            return super().reason()
        return Failure("time_out", f"{self.decorated.name} was still running after {self.duration:g} s")


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
