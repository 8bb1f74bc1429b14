"""Motions through way points: what holds of every rounded corner, and what becomes of radii that don't fit."""

from itertools import pairwise

import numpy as np
import pytest
from table_top import named, robot_model, room, situation

from grip_bt.base.failures import (
    CanceledError,
    GoalInCollisionError,
    NoIkError,
    PathInvalidError,
    StartInCollisionError,
)
from grip_bt.base.values import JointState, Pose, WayPoint
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.paths import interpolated
from grip_bt.commanders.planning.requests import PlanThrough


def planned(goals, radii, straight=True, scene=None, model=None):
    model = model or robot_model()
    scene = scene or room(model)
    points = tuple(WayPoint(goal, radius, straight) for goal, radius in zip(goals, [*radii, 0.0], strict=True))
    return answer(model, PlanThrough(situation(model, scene.snapshot()), points), lambda: False)


def home_pose():
    return robot_model().grasp_pose(named(robot_model(), "arm", "home"))


def origins(plan):
    model, trajectory = robot_model(), plan.trajectory
    return np.stack([model.grasp_pose(JointState(trajectory.names, q)).position for q in trajectory.positions])


def off_the_lines(at, corners):
    """How far a point is from the nearest of the lines between corners [m]."""
    distances = []
    for one, other in pairwise(corners):
        part = np.clip((at - one) @ (other - one) / ((other - one) @ (other - one)), 0.0, 1.0)
        distances.append(np.linalg.norm(one + part * (other - one) - at))
    return min(distances)


def speeds(plan):
    return np.abs(plan.trajectory.velocities).max(axis=1)


def random_way(seed):
    """Three or four poses, 8 to 16 cm apart, near home, no line nearly back along the one before, and radii."""
    rng = np.random.default_rng(seed)
    goals, here, before = [], home_pose(), np.zeros(3)
    for _ in range(rng.integers(3, 5)):
        while True:
            way = rng.normal(size=3)
            way /= np.linalg.norm(way)
            step = way * rng.uniform(0.08, 0.16)
            off = here.moved(step).position - home_pose().position
            if way @ before > -0.5 and np.all(np.abs(off - [0.0, 0.0, 0.04]) < [0.1, 0.15, 0.08]):
                break
        before = way
        turn = np.array([1.0, *rng.uniform(-0.1, 0.1, 3)])
        here = Pose(here.moved(step).position, here.quaternion) @ Pose([0, 0, 0], turn / np.linalg.norm(turn))
        goals.append(here)
    return goals, [float(rng.uniform(0.01, 0.06)) for _ in goals[1:]]


@pytest.mark.parametrize("seed", range(8))
def test_a_blended_way_keeps_to_its_balls_its_lines_and_its_limits_and_does_not_stop(seed):
    goals, radii = random_way(seed)
    plan = planned(goals, radii)
    ways, trajectory = origins(plan), plan.trajectory
    corners = [home_pose().position, *(goal.position for goal in goals)]
    outside = np.ones(len(ways), dtype=bool)
    assert len(plan.radii) == len(radii)
    for corner, radius, asked in zip(corners[1:-1], plan.radii, radii, strict=True):
        away = np.linalg.norm(ways - corner, axis=1)
        inside = away <= radius
        assert 0 < radius <= asked + 1e-9
        assert inside.any()
        assert speeds(plan)[inside].min() > 0.02
        outside &= ~inside
    resting = max(off_the_lines(at, corners) for at in origins(planned(goals, [0.0] * len(radii))))
    assert max(off_the_lines(at, corners) for at in ways[outside]) < resting + 5e-4
    assert resting < 3e-3
    limits = robot_model().chain("arm").limits
    assert np.all(trajectory.positions >= limits.lower)
    assert np.all(trajectory.positions <= limits.upper)
    assert np.all(np.abs(trajectory.velocities) <= limits.velocity + 1e-6)
    assert np.all(np.abs(trajectory.accelerations) <= limits.acceleration + 1e-6)
    assert speeds(plan)[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert ways[-1] == pytest.approx(goals[-1].position, abs=1e-3)


def test_a_point_without_radius_is_reached_at_rest_and_the_others_take_less_time():
    here = home_pose()
    goals = [here.moved([0.12, 0, 0]), here.moved([0.12, 0.12, 0]), here.moved([0.12, 0.12, -0.1])]
    stopping, half, blended = (planned(goals, radii) for radii in ([0, 0], [0, 0.04], [0.04, 0.04]))
    assert stopping.radii == (0.0, 0.0)
    assert half.radii == (0.0, pytest.approx(0.04))
    for plan, corners in ((stopping, goals[:2]), (half, goals[:1])):
        for corner in corners:
            nearest = np.linalg.norm(origins(plan) - corner.position, axis=1).argmin()
            assert origins(plan)[nearest] == pytest.approx(corner.position, abs=1e-3)
            assert speeds(plan)[nearest] == pytest.approx(0.0, abs=1e-6)
    assert stopping.trajectory.duration > half.trajectory.duration > blended.trajectory.duration


def test_a_radius_takes_no_more_than_half_of_a_segment_and_blends_do_not_overlap():
    here = home_pose()
    goals = [here.moved([0.12, 0, 0]), here.moved([0.12, 0.1, 0]), here.moved([0.12, 0.1, -0.12])]
    plan = planned(goals, [0.5, 0.5])
    assert 0.045 < min(plan.radii)
    assert max(plan.radii) < 0.055
    assert sum(plan.radii) <= 0.1 + 1e-3


def test_an_arm_comes_to_rest_where_it_only_turns_on_the_spot():
    here = home_pose()
    turned = here @ Pose([0, 0, 0], [np.cos(0.1), 0, 0, np.sin(0.1)])
    plan = planned([turned, turned.moved([0, 0.1, 0])], [0.05])
    assert plan.radii == (0.0,)


def test_a_corner_that_would_touch_something_is_rounded_less():
    model, here = robot_model(), home_pose()
    goals = [here.moved([0.1, 0.30, 0]), here.moved([0.1, 0.30, -0.25])]
    free = planned(goals, [0.12])
    chain = model.chain("arm", named(model, "hand", "open"))
    for rise in np.arange(-0.45, 0.0, 0.005):  # ever higher below the inner side of the corner, until it is in the way
        scene = room(model)
        scene.set_box("post", (0.02, 0.02, 0.1), Pose(here.moved([0.08, 0.16, rise]).position))
        checker = CollisionChecker(chain, scene.snapshot(), "right_hand")
        if not checker.all_free(free.trajectory.positions):
            break
    else:
        pytest.fail("the post is never in the way of the large blend")
    plan = planned(goals, [0.12], scene=scene)
    assert plan.radii[0] in [pytest.approx(free.radii[0] * part) for part in (0.5, 0.25, 0.125, 0.0)]
    assert checker.all_free(interpolated(plan.trajectory.positions, 0.002))


def test_joint_positions_poses_and_searched_segments_go_together():
    model, here = robot_model(), home_pose()
    home = named(model, "arm", "home")
    bent = JointState(home.names, home.position + [0.3, 0, 0, 0.2, 0, 0, 0][: len(home.names)])
    there = model.grasp_pose(bent)
    points = (WayPoint(bent, 0.04), WayPoint(there.moved([0, 0, -0.1]), 0.03), WayPoint(here, 0.0, straight=False))
    plan = answer(model, PlanThrough(situation(model, room(model).snapshot()), points), lambda: False)
    again = answer(model, PlanThrough(situation(model, room(model).snapshot()), points), lambda: False)
    assert plan.trajectory == again.trajectory
    assert all(0 < radius <= asked + 1e-9 for radius, asked in zip(plan.radii, (0.04, 0.03), strict=True))
    assert origins(plan)[-1] == pytest.approx(here.position, abs=1e-3)
    for corner, radius in zip((there, there.moved([0, 0, -0.1])), plan.radii, strict=True):
        assert np.linalg.norm(origins(plan) - corner.position, axis=1).min() <= radius
    moving = plan.trajectory.times[speeds(plan) > 0.01]
    assert np.diff(moving).max() < 0.05  # no rest in between


def test_way_points_that_cannot_be_passed_say_which_and_why():
    here = home_pose()
    with pytest.raises(NoIkError, match="segment 2 of 2"):
        planned([here.moved([0, 0.1, 0]), here.moved([0, -3.0, 0])], [0.05])
    with pytest.raises(PathInvalidError, match="table"):
        planned([here.moved([0.1, 0.3, 0]), here.moved([0.1, 0.3, 0.04 - here.position[2]])], [0.05])
    with pytest.raises(GoalInCollisionError, match="table"):
        planned([here.moved([0, 0.1, 0]), here.moved([0, 0.4, -here.position[2]])], [0.05], straight=False)
    model, scene = robot_model(), room(robot_model())
    scene.set_box("block", (0.1, 0.1, 0.1), here)
    with pytest.raises(StartInCollisionError, match="block"):
        planned([here.moved([0, 0.1, 0])], [], scene=scene, model=model)


def test_a_cancelled_search_between_way_points_ends():
    model, here = robot_model(), home_pose()
    scene = room(model)
    scene.set_box("wall", (0.4, 0.02, 0.4), here.moved([0, 0.3, 0]))
    points = (WayPoint(here.moved([0, 0.6, 0]), straight=False),)
    with pytest.raises(CanceledError):
        answer(model, PlanThrough(situation(model, scene.snapshot()), points), lambda: True)


@pytest.mark.parametrize("radius", [-0.01, float("nan"), float("inf")])
def test_a_radius_is_a_length(radius):
    with pytest.raises(ValueError, match="blend radius"):
        WayPoint(home_pose(), radius)
