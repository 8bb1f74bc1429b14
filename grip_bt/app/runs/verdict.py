"""The referee's word beside the task's: where the objects of a simulated world are in the end, and what contradicts it.

A task can't ask the referee. It contradicts a success in two cases: the project states what has to be true where the
task has succeeded (`goals` in `grip.yaml`), and it isn't; or `arm/place` has put down more than lies in the crate.
A task that neither has a goal nor places anything claims nothing about objects, and is never contradicted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any, get_args

import numpy as np

from grip_bt.base.errors import DocumentError, EvaluationError, ExpressionError, GripError, nearest
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.base.values import Failure, Grasp
from grip_bt.nodes.node import Silent
from grip_bt.runtime import RunResult
from grip_sim.referee import Status

from .execute import Session

STATES: tuple[str, ...] = get_args(Status)
"""What a referee may say of an object."""
PLACE = "grip_bt.nodes.place:Place"


class Verdict(Silent):
    """Observes a run, and asks the referee in its end.

    Args:
        session: with a runner that wasn't begun; it is told of the observer.

    Raises:
        DocumentError: the project's goal for the task isn't a condition over what a referee says.
    """

    def __init__(self, session: Session):
        self._referee = session.resources.referee
        self._goal = session.project.file.goals.get(session.document.task.name, "")
        self._compute: Callable[[], bool] | None = None
        self._values: Mapping[str, int] = {}
        if self._goal:
            where = f"goals/{session.document.task.name}"
            self._compute = self._condition(where, str(session.project.folder / "grip.yaml"))
        leaves = session.runner.compiled.leaves.items()
        self._places = {
            path for path, leaf in leaves if leaf.manifest.implementation == PLACE and leaf.params["target"]
        }
        self._placed = 0
        session.runner.observe(self)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Count what was put down."""
        self._placed += path in self._places and failure is None

    def facts(self, result: RunResult) -> dict[str, Any]:
        """Return `truth` (object -> the referee's word) and, where it contradicts, `contradiction` and `message`.

        Nothing where there is no referee, or where the simulator has gone, which is why the run has ended.
        """
        if self._referee is None:
            return {}
        try:
            truth = {name: state.status for name, state in self._referee.truth().items()}
        except GripError:
            return {}
        why = self._contradiction(truth) if result.status == "success" else ""
        said = {"contradiction": why, "message": f"the referee contradicts: {why}"} if why else {}
        return {"truth": truth, **said}

    def _contradiction(self, truth: Mapping[str, str]) -> str:
        counts = Counter(truth.values())
        self._values = {state: counts[state] for state in STATES} | {"objects": len(truth)}
        if self._compute is not None:
            return "" if self._compute() else f"`{self._goal}` isn't so; {words(truth)}"
        if self._placed > counts["placed"]:
            return f"the task has placed {self._placed}, {counts['placed']} are in the crate; {words(truth)}"
        return ""

    def _condition(self, where: str, file: str) -> Callable[[], bool]:
        known = ("objects", *STATES)
        try:
            parsed = parse_expression(self._goal)
            unknown = [name for name in parsed.names if name not in known]
            if unknown:
                near, there = nearest(unknown[0], known), ", ".join(known)
                raise DocumentError(f"{where}: nothing is known of {unknown[0]!r}{near} (available: {there})", file)
            self._values = dict.fromkeys(known, 0)
            compute = condition_of(parsed, {name: partial(self._value, name) for name in parsed.names})
            compute()
        except (ExpressionError, EvaluationError) as error:
            raise DocumentError(f"{where}: {error}", file) from error
        return compute

    def _value(self, name: str) -> int:
        return self._values[name]


def words(truth: Mapping[str, str]) -> str:
    """Return where the objects are, in a line: `placed: box_0, box_2; standing: cylinder_1`."""
    found = {state: [name for name, status in truth.items() if status == state] for state in STATES}
    return "; ".join(f"{state}: {', '.join(names)}" for state, names in found.items() if names) or "no objects"


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


def attempt_line(attempt: Attempt) -> str:
    """Return one attempt in a line."""
    what = attempt.target or ("nothing left" if attempt.outcome == "nothing_left" else "no object")
    if attempt.outcome is None:
        how = "stopped"
    elif attempt.failure is not None:
        how = f"failed at {attempt.where or 'the task'}: {attempt.failure}"
    elif attempt.outcome == "success":
        how = (
            "held, and put into the crate" if attempt.held else "put into the crate, says the task; the hand was empty"
        )
    else:
        how = attempt.outcome.replace("_", " ")
    return f"attempt {attempt.number:<2} {attempt.duration:6.1f} s  {what:<12} {how}"


def object_table(truth: Mapping[str, Any], attempts: Sequence[Attempt]) -> list[str]:
    """Return a line per object: attempts, why they failed, and what the referee says."""
    rows = [("object", "attempts", "held", "placed", "time [s]", "why attempts failed")]
    for name, state in truth.items():
        mine = [a for a in attempts if a.target == name]
        why = "; ".join(f"{a.where}: {a.failure.code}" for a in mine if a.failure is not None) or "-"
        held = "yes" if any(name in a.held for a in mine) else "no"
        placed = "yes" if state.status == "placed" else f"no ({state.status})"
        rows.append((name, str(len(mine)), held, placed, f"{sum(a.duration for a in mine):.1f}", why))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    return ["  ".join([*(c.ljust(w) for c, w in zip(row[:-1], widths, strict=True)), row[-1]]) for row in rows]
