"""What a pick-and-place run did, attempt by attempt, with the referee's word beside the task's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from grip_bt.base.values import Failure, Grasp
from grip_bt.nodes.observer import Silent

Truth = Callable[[], Mapping[str, Any]]
"""Asks the referee: object -> something with `.status` (`held`, `placed`, ...) and `.pose`."""


@dataclass
class Attempt:
    """One turn of the task's attempt node.

    Attributes:
        number: counted from 1.
        target: the object nearest to the chosen grasp, None while none was chosen.
        steps: leaf -> outcome (and failure code), in order of their ends.
        outcome: how the attempt node ended; None when it was interrupted.
        failure: why.
        where: path of the leaf that failed first.
        held: objects that the referee saw in the hand when the task checked.
        duration: on the run's clock [s].
    """

    number: int
    target: str | None = None
    steps: list[tuple[str, str]] = field(default_factory=list)
    outcome: str | None = None
    failure: Failure | None = None
    where: str = ""
    held: tuple[str, ...] = ()
    duration: float = 0.0


class AttemptRecorder(Silent):
    """An observer that gathers attempts.

    Args:
        attempt: path of the node that is one attempt.
        check: path of the leaf before which the referee is asked what is held.
        clock: the run's clock.
        truth: asks the referee, or None where there is none.
        on_end: called with each attempt that ended.
        meaning: of the attempt node's outcomes.
    """

    def __init__(
        self,
        attempt: str,
        check: str,
        clock: Callable[[], float],
        truth: Truth | None = None,
        on_end: Callable[[Attempt], None] = lambda attempt: None,
        meaning: Mapping[str, str] = MappingProxyType({"failure": "failure"}),
    ):
        self._path, self._check, self._clock, self._truth, self._on_end = attempt, check, clock, truth, on_end
        self.attempts: list[Attempt] = []
        self._meaning = meaning
        self._began = 0.0
        self._first: Failure | None = None

    def entered(self, path: str) -> None:
        """Begin an attempt, or ask what is held before the task checks it."""
        if path == self._path:
            self._began, self._first = self._clock(), None
            self.attempts.append(Attempt(len(self.attempts) + 1))
        elif path == self._check and self.attempts:
            self.attempts[-1].held = self._with("held")

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """Take note of which object a chosen grasp is for."""
        if isinstance(value, Grasp) and self._truth is not None and self.attempts:
            truth = self._truth()
            point = value.pose.position + value.pose.rotation()[:, 2] * 0.04
            flat = {n: float(np.linalg.norm(t.pose.position[:2] - point[:2])) for n, t in truth.items()}
            self.attempts[-1].target = min(flat, key=flat.__getitem__, default=None)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Record a step, or end the attempt."""
        if path == self._path:
            self._end(outcome, failure)
        elif path.startswith(self._path + "/") and self.attempts:
            attempt, step = self.attempts[-1], path.removeprefix(self._path + "/")
            attempt.steps.append((step, outcome if failure is None else f"{outcome}.{failure.code}"))
            if outcome == "success" and attempt.where.startswith(step + "/"):
                attempt.where, self._first = "", None  # it has been dealt with, as by an `invert`
            if failure is not None and not attempt.where:
                attempt.where, self._first = step, failure

    def interrupted(self, path: str) -> None:
        """End the attempt without an outcome."""
        if path == self._path:
            self._end(None, None)

    def _end(self, outcome: str | None, failure: Failure | None) -> None:
        attempt = self.attempts[-1]
        attempt.outcome = outcome
        # A recovery that succeeded leaves a failed attempt without a reason of its own: what it recovered from is it.
        attempt.failure = failure or (self._first if self._meaning.get(outcome or "") == "failure" else None)
        attempt.duration = self._clock() - self._began
        self._on_end(attempt)

    def _with(self, status: str) -> tuple[str, ...]:
        if self._truth is None:
            return ()
        return tuple(sorted(n for n, t in self._truth().items() if t.status == status))
