"""Which grasp an arm can really do, asked of move_group: reach it, approach and lift straight, touch nothing else.

The questions are those of `commanders.planning.grasps`, one candidate after the other, with MoveIt's kinematics and
collision checks for answers.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from grip_bt.base.failures import (
    GoalInCollisionError,
    NoGraspError,
    NoIkError,
    NoPlanError,
    PathInvalidError,
    StartInCollisionError,
    TimeOutError,
)
from grip_bt.base.values import Grasp, JointState
from grip_bt.commanders.planning.grasps import target_of
from grip_bt.commanders.planning.requests import ChooseGrasp, ChosenGrasp, PlanTo, Situation

from ..steps import Steps

if TYPE_CHECKING:
    from .planner import MoveGroupPlanner

_UNFIT = (NoIkError, PathInvalidError, NoPlanError, TimeOutError, GoalInCollisionError)


def choose(planner: MoveGroupPlanner, request: ChooseGrasp) -> Steps[ChosenGrasp]:
    """Return the first feasible grasp, by falling quality.

    Raises:
        NoGraspError: none is; `data['reasons']` counts why, `data['candidates']` how many there were.
    """
    reasons: Counter[str] = Counter()
    for grasp in sorted(request.grasps, key=lambda g: -g.quality):
        trial = _Trial(planner, request.situation, grasp)
        try:
            pre, at = yield from trial.run()
        except _UNFIT:
            reasons[trial.stage] += 1
        else:
            return ChosenGrasp(grasp, pre, at, dict(reasons))
    counts = ", ".join(f"{count} {reason}" for reason, count in reasons.most_common())
    raise NoGraspError(
        f"none of {len(request.grasps)} grasps is feasible" + (f": {counts}" if counts else ""),
        reasons=dict(reasons),
        candidates=len(request.grasps),
    )


class _Trial:
    """One candidate; `stage` says how far it got, in the words of `commanders.planning.grasps`."""

    def __init__(self, planner: MoveGroupPlanner, situation: Situation, grasp: Grasp):
        self._planner, self._grasp = planner, grasp
        posture = grasp.pre_posture or planner.robot.opened(situation.group)
        self._situation = replace(situation, start=_with(situation.start, posture))
        self._target = target_of(grasp, situation.scene)
        self.stage = "no_ik"

    def run(self) -> Steps[tuple[JointState, JointState]]:
        """Return the arm's joints at the pre-grasp and at the grasp; ends with one of `_UNFIT`."""
        planner, whole, grasp = self._planner, self._situation, self._grasp
        free = whole if self._target is None else replace(whole, scene=whole.scene.without([self._target]))
        yield from planner.show(free)
        at = yield from self._at_grasp(free)
        self.stage = "approach_blocked"
        away = yield from planner.straight(free, _with(whole.start, at), (grasp.pre_grasp,))
        pre = away.end()
        if self._target is not None:
            self.stage = "lift_blocked"
            held = replace(whole, scene=whole.scene.attaching(self._target, whole.hand, grasp.pose))
            yield from planner.show(held)
        self.stage = "lift_blocked"
        yield from planner.straight(whole, _with(whole.start, at), (grasp.post_grasp,))
        self.stage = "no_plan"
        yield from planner.show(whole)
        try:
            yield from planner.free(PlanTo(whole, pre))
        except StartInCollisionError:
            pass  # the plan itself will tell that the start is in collision
        return pre, at

    def _at_grasp(self, free: Situation) -> Steps[JointState]:
        try:
            return (yield from self._planner.inverse(free, free.start, self._grasp.pose, collisions=True))
        except NoIkError:
            yield from self._planner.inverse(free, free.start, self._grasp.pose, collisions=False)
            self.stage = "in_collision"
            raise


def _with(state: JointState, other: JointState) -> JointState:
    """Return a state with some joints at other positions."""
    positions = {**state.as_mapping(), **other.as_mapping()}
    return JointState(tuple(positions), np.array(list(positions.values())), time=state.time)
