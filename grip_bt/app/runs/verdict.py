"""The referee's word beside the task's: where the objects of a simulated world are in the end, and what contradicts it.

A task can't ask the referee. It contradicts a success in two cases: the project states what has to be true where the
task has succeeded (`goals` in `grip.yaml`), and it isn't; or `arm/place` has put down more than lies in the crate.
A task that neither has a goal nor places anything claims nothing about objects, and is never contradicted. What the
world's own `judge` finds is told beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial

from grip_bt.app.project.worlds import STATES, Counts, WorldCondition, counted
from grip_bt.app.runs.execute import Session
from grip_bt.base.errors import GripError
from grip_bt.base.values import Failure
from grip_bt.nodes.node import Observer
from grip_bt.runtime import RunResult
from grip_bt.runtime.control import RunEnd
from grip_sim.referee import ObjectTruth
from grip_sim.specs import WorldSpec

PLACE = "grip_bt.nodes.place:Place"


class Verdict(Observer):
    """Observes a run, and asks the referee in its end; see `WorldCondition` for goals that are wrong."""

    def __init__(self, session: Session):
        self._referee = session.resources.referee
        spec = session.resources.world.spec if session.resources.world is not None else WorldSpec(regions=())
        self._regions = tuple(region.name for region in spec.regions)
        condition = partial(WorldCondition, regions=self._regions, measures=spec.measures)
        name, file = session.document.task.name, str(session.project.folder / "grip.yaml")
        goal = session.project.file.goals.get(name, "") if self._referee is not None else ""  # it may name its measures
        self._goal = condition(goal, where=f"goals/{name}", file=file) if goal else None
        world = f"world {session.project.file.world}"
        self._judge = {n: condition(text, where=f"judge/{n}", file=world) for n, text in spec.judge.items()}
        there = session.runner.compiled.leaves.items()
        self._places = {path for path, leaf in there if leaf.manifest.implementation == PLACE and leaf.params["target"]}
        self._placed = 0
        session.runner.observe(self)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Count what was put down."""
        self._placed += path in self._places and failure is None

    def facts(self, result: RunResult) -> RunEnd:
        """Return `truth` (object -> the referee's word) and, where it contradicts, `contradiction` and `message`.

        `judged` (name -> whether it is true) is the world's own judgement. Nothing where there is no referee, or where
        the simulator has gone, which is why the run has ended.
        """
        if self._referee is None:
            return {}
        try:
            found, measures = self._referee.truth().values(), self._referee.measures()
        except GripError:
            return {}
        counts = counted(found, self._regions, measures)
        why = self._contradiction(found, counts) if result.status == "success" else ""
        said: RunEnd = {"contradiction": why, "message": f"the referee contradicts: {why}"} if why else {}
        if self._judge:
            said["judged"] = {name: condition.holds(counts) for name, condition in self._judge.items()}
        return {"truth": _states(found), **said}

    def _contradiction(self, found: Iterable[ObjectTruth], counts: Counts) -> str:
        told = words(_states(found))
        if self._goal is not None:
            return "" if self._goal.holds(counts) else f"`{self._goal.text}` is false; {told}"
        if self._placed > counts["placed"]:
            return f"the task has placed {self._placed}, {counts['placed']} are in the crate; {told}"
        return ""


def _states(found: Iterable[ObjectTruth]) -> dict[str, str]:
    return {thing.name: thing.status for thing in found}


def words(truth: Mapping[str, str]) -> str:
    """Return where the objects are, in a line: `placed: box_0, box_2; standing: cylinder_1`."""
    found = {state: [name for name, status in truth.items() if status == state] for state in STATES}
    return "; ".join(f"{state}: {', '.join(names)}" for state, names in found.items() if names) or "no objects"
