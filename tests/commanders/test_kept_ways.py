"""Motions through way points that keep to something all along, rounded corners and searched segments included."""

from __future__ import annotations

import numpy as np
import pytest
from table_top import named, robot_model, situation

from grip_bt.base.failures import ConstraintBrokenError
from grip_bt.base.values import JointState, PathConstraint, Pose, WayPoint
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.paths import CONSTRAINT_SLACK
from grip_bt.commanders.planning.requests import PlanThrough
from grip_bt.commanders.scene_state import SceneSnapshot


def home() -> Pose:
    return robot_model().grasp_pose(named(robot_model(), "arm", "home"))


def level(tolerance: float = 0.1) -> PathConstraint:
    return PathConstraint(Pose(quaternion=home().quaternion), (tolerance, tolerance, np.inf))


def way(straight=True, radius=0.04):
    """To the side, up and on: a hand's breadth each."""
    goals = [home().moved(offset) for offset in ([0, 0.12, 0], [0, 0.12, 0.1], [-0.05, 0.2, 0.1])]
    return tuple(WayPoint(goal, 0.0 if goal is goals[-1] else radius, straight) for goal in goals)


def planned(points, constraint, seed=0):
    model = robot_model()
    request = PlanThrough(situation(model, SceneSnapshot(), seed=seed), points, constraint)
    return answer(model, request, lambda: False)


def poses(plan):
    model, trajectory = robot_model(), plan.trajectory
    times = np.arange(0.0, trajectory.duration, 0.005)
    return [model.grasp_pose(JointState(trajectory.names, trajectory.at(t))) for t in times]


@pytest.mark.parametrize("straight", [True, False], ids=["lines", "searched"])
def test_the_whole_way_keeps_to_it(straight):
    plan = planned(way(straight), level())
    assert all(level().kept_by(pose, CONSTRAINT_SLACK) for pose in poses(plan))
    if straight:
        assert min(plan.radii) > 0


def test_a_searched_way_goes_where_the_constraint_lets_it():
    # Without it, the joints go straight, and the hand tilts on its way.
    far = home().moved([0.15, 0.45, -0.1])
    points = (WayPoint(far, straight=False),)
    tight = level(0.04)
    free, kept = planned(points, None), planned(points, tight)
    assert not all(tight.kept_by(pose, CONSTRAINT_SLACK) for pose in poses(free))
    assert all(tight.kept_by(pose, CONSTRAINT_SLACK) for pose in poses(kept))


@pytest.mark.parametrize(
    ("box", "words"),
    [
        ([0, 0, 3], "the start violates the path constraint"),
        ([0, 0, 0], "segment 1 of 3: the straight way leaves what the motion must keep to; search it"),
    ],
)
def test_what_breaks_it_is_told_with_the_segment(box, words):
    constraint = PathConstraint(box=home().moved(box), size=(0.2, 0.2, 0.2))
    with pytest.raises(ConstraintBrokenError, match=words):
        planned(way(), constraint)
