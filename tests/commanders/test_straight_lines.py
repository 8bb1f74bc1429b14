"""Straight motions stay on their lines, to a millimetre, between the points of a trajectory too."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from table_top import named, robot_model, situation

from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import JointState, Pose, WayPoint
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import PlanStraight, PlanThrough
from grip_bt.commanders.planning.straight import OFF, TURNED
from grip_bt.commanders.scene_state import SceneSnapshot


def moved(pose: Pose, way, turn) -> Pose:
    rotation = pin.exp3(np.array(turn)) @ pose.rotation()
    return Pose.from_matrix(pin.SE3(rotation, pose.position + way).homogeneous)


def random_case(seed: int):
    """Joint positions near home, and one to three poses with lines of up to 30 cm and turns of up to 0.6 rad."""
    rng, model = np.random.default_rng(seed), robot_model()
    home = named(model, "arm", "home")
    start = JointState(home.names, home.position + rng.uniform(-0.3, 0.3, len(home.names)))
    poses = [model.grasp_pose(start)]
    for _ in range(rng.integers(1, 4)):
        axis = rng.normal(size=3)
        turn = axis / np.linalg.norm(axis) * rng.uniform(0, 0.6)
        poses.append(moved(poses[-1], rng.uniform(-0.17, 0.17, 3), turn))
    return start, poses


def samples(trajectory, every=0.003):
    """The grasp frame along the motion as an executor sees it: straight in joint space between the points."""
    model = robot_model()
    times = np.arange(0.0, trajectory.duration + every, every)
    return [model.grasp_pose(JointState(trajectory.names, trajectory.at(min(t, trajectory.duration)))) for t in times]


def off_the_lines(pose: Pose, poses: list[Pose]) -> tuple[float, float]:
    """How far a pose is from the nearest of the lines: metres, and radians from the orientations along that line."""
    found = []
    for one, other in pairwise(poses):
        way = other.position - one.position
        part = np.clip((pose.position - one.position) @ way / (way @ way), 0.0, 1.0)
        turn = pin.log3(one.rotation().T @ other.rotation())
        axis = turn / max(float(np.linalg.norm(turn)), 1e-9)
        there = pin.log3(one.rotation().T @ pose.rotation())
        aside = np.linalg.norm(there - (there @ axis) * axis)
        found.append((float(np.linalg.norm(one.position + part * way - pose.position)), float(aside)))
    return min(found)


def planned(request):
    try:
        return answer(robot_model(), request, lambda: False)
    except ExpectedError:
        return None  # out of reach, or the arm would touch itself


@pytest.mark.parametrize("block", range(3))
def test_random_lines_are_followed_within_a_millimetre(block):
    model, done = robot_model(), 0
    for seed in range(10 * block, 10 * block + 10):
        start, poses = random_case(seed)
        begin = situation(model, SceneSnapshot(), start)
        plan = planned(PlanStraight(begin, tuple(poses[1:])))
        if plan is None:
            continue
        done += 1
        off = np.array([off_the_lines(pose, poses) for pose in samples(plan.trajectory)])
        assert off[:, 0].max() < OFF * 1.1, f"seed {seed}"  # samples between those that were looked at
        assert off[:, 1].max() < TURNED * 1.5, f"seed {seed}"
        assert model.grasp_pose(plan.trajectory.end()).position == pytest.approx(poses[-1].position, abs=2e-4)
    assert done >= 6


def test_lines_that_lead_straight_on_are_one_motion_and_corners_are_rests():
    model = robot_model()
    here = model.grasp_pose(named(model, "arm", "home"))
    begin = situation(model, SceneSnapshot())
    on = answer(model, PlanStraight(begin, (here.moved([0, 0.05, 0]), here.moved([0, 0.1, 0]))), lambda: False)
    times = on.trajectory.times
    middle = np.abs(on.trajectory.velocities[(times > 0.06) & (times < times[-1] - 0.06)]).max(axis=1)
    assert middle.min() > 0.05
    corner = answer(model, PlanStraight(begin, (here.moved([0, 0.1, 0]), here.moved([0, 0.1, 0.1]))), lambda: False)
    at = [np.linalg.norm(p.position - here.moved([0, 0.1, 0]).position) for p in samples(corner.trajectory)]
    assert min(at) < 2e-4
    assert np.abs(corner.trajectory.velocities[3:-3]).max(axis=1).min() < 1e-6


def test_between_blends_a_way_through_points_stays_on_its_lines():
    model, done = robot_model(), 0
    for seed in range(12):
        start, poses = random_case(100 + seed)
        points = tuple(WayPoint(pose, 0.02 if k < len(poses) - 2 else 0.0) for k, pose in enumerate(poses[1:]))
        plan = planned(PlanThrough(situation(model, SceneSnapshot(), start), points))
        if plan is None:
            continue
        done += 1
        for pose in samples(plan.trajectory):
            balls = zip(poses[1:-1], plan.radii, strict=True)
            if not any(np.linalg.norm(pose.position - centre.position) < radius + 3e-4 for centre, radius in balls):
                assert off_the_lines(pose, poses)[0] < OFF * 1.1, f"seed {seed}"
    assert done >= 6
