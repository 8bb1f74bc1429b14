"""The referee's word beside the task's: where the objects of a simulated world are in the end, and what contradicts it.

A task can't ask the referee. It contradicts a success in two cases: the project states what has to be true where the
task has succeeded (`goals` in `grip.yaml`), and it isn't; or `arm/place` has put down more than lies in the crate.
A task that neither has a goal nor places anything claims nothing about objects, and is never contradicted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from typing import get_args

from grip_bt.base.errors import DocumentError, EvaluationError, ExpressionError, GripError, nearest
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.base.values import Failure
from grip_bt.nodes.node import Observer
from grip_bt.runtime import RunResult
from grip_bt.runtime.control import RunEnd
from grip_sim.referee import Status

from .execute import Session

STATES: tuple[str, ...] = get_args(Status)
"""What a referee may say of an object."""
PLACE = "grip_bt.nodes.place:Place"


class Verdict(Observer):
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

    def facts(self, result: RunResult) -> RunEnd:
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
        said: RunEnd = {"contradiction": why, "message": f"the referee contradicts: {why}"} if why else {}
        return {"truth": dict(truth), **said}

    def _contradiction(self, truth: Mapping[str, str]) -> str:
        counts = Counter(truth.values())
        self._values = {state: counts[state] for state in STATES} | {"objects": len(truth)}
        if self._compute is not None:
            return "" if self._compute() else f"`{self._goal}` is false; {words(truth)}"
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
                raise DocumentError(f"{where}: unknown name {unknown[0]!r}{near} (available: {there})", file)
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
