"""The attempts of a demonstration as the referee sees them: what was taken, what was held when the task checked it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grip_bt.base.values import Failure, Grasp
from grip_bt.nodes.node import Observer
from grip_bt.runtime import RunResult
from grip_sim.referee import ObjectTruth

CHECKS = {"clear_table": "next_object/attempt/check/held", "reactive": "next_object/attempt/check/grasped"}
"""Demonstration -> path of the leaf that checks whether something is held."""

_Truth = Callable[[], Mapping[str, ObjectTruth]]
"""Asks the referee."""


@dataclass
class Attempt:
    """One turn of the task's attempt node.

    Attributes:
        target: the object nearest to the chosen grasp, None while none was chosen.
        steps: leaf -> outcome (and failure code), in order of their ends.
        outcome: how the attempt node ended; None when it was interrupted.
        where: path of the leaf that failed first.
        held: objects that the referee saw in the hand when the task checked.
        said: how the leaf ended that checks it; empty where it wasn't reached.
    """

    number: int
    target: str | None = None
    steps: list[tuple[str, str]] = field(default_factory=list)
    outcome: str | None = None
    failure: Failure | None = None
    where: str = ""
    held: tuple[str, ...] = ()
    said: str = ""
    duration: float = 0.0


@dataclass
class AttemptRecorder(Observer):
    """An observer that gathers attempts; before the leaf `check`, the referee is asked what is held."""

    attempt: str
    check: str
    clock: Callable[[], float]
    truth: _Truth | None = None
    on_end: Callable[[Attempt], None] = lambda attempt: None
    meaning: Mapping[str, str] = field(default_factory=lambda: {"failure": "failure"})
    attempts: list[Attempt] = field(default_factory=list)
    _began: float = 0.0
    _first: Failure | None = None

    def entered(self, path: str) -> None:
        """Begin an attempt, or ask what is held before the task checks it."""
        if path == self.attempt:
            self._began, self._first = self.clock(), None
            self.attempts.append(Attempt(len(self.attempts) + 1))
        elif path == self.check and self.attempts:
            truth = {} if self.truth is None else self.truth()
            self.attempts[-1].held = tuple(sorted(name for name, seen in truth.items() if seen.status == "held"))

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """Take note of which object a chosen grasp is for."""
        if isinstance(value, Grasp) and self.truth is not None and self.attempts:
            truth = self.truth()
            point = value.pose.position + value.pose.rotation()[:, 2] * 0.04
            flat = {n: float(np.linalg.norm(t.pose.position[:2] - point[:2])) for n, t in truth.items()}
            self.attempts[-1].target = min(flat, key=flat.__getitem__, default=None)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Record a step, or end the attempt."""
        if path == self.attempt:
            self._end(outcome, failure)
        elif path.startswith(self.attempt + "/") and self.attempts:
            if path == self.check:
                self.attempts[-1].said = outcome
            attempt, step = self.attempts[-1], path.removeprefix(self.attempt + "/")
            attempt.steps.append((step, outcome if failure is None else f"{outcome}.{failure.code}"))
            if outcome == "success" and attempt.where.startswith(step + "/"):
                attempt.where, self._first = "", None  # it has been dealt with, as by an `invert`
            if failure is not None and not attempt.where:
                attempt.where, self._first = step, failure

    def interrupted(self, path: str) -> None:
        """End the attempt without an outcome."""
        if path == self.attempt:
            self._end(None, None)

    def _end(self, outcome: str | None, failure: Failure | None) -> None:
        attempt = self.attempts[-1]
        attempt.outcome = outcome
        # A recovery that succeeded leaves a failed attempt without a reason of its own: what it recovered from is it.
        attempt.failure = failure or (self._first if self.meaning.get(outcome or "") == "failure" else None)
        attempt.duration = self.clock() - self._began
        self.on_end(attempt)


def summary(result: RunResult, attempts: list[Attempt], placed: int, objects: int, wall: float) -> dict[str, Any]:
    """Return what a demonstration comes to; `wall` is in s."""
    return {
        "status": result.status,
        "outcome": result.outcome,
        "placed": placed,
        "objects": objects,
        "attempts": sum(a.outcome != "nothing_left" for a in attempts),
        "failures": [f"{a.where}: {a.failure.code}" for a in attempts if a.failure is not None],
        "false_placements": sum("place" in dict(a.steps) and not a.held for a in attempts),
        "checks": [{"said": a.said, "held": bool(a.held)} for a in attempts if a.said],
        "simulated": result.duration,
        "wall_in_all": wall,
        "message": str(result.error or result.failure or ""),
    }
