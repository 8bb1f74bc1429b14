"""BiTRRT keeps clear of things, CBiRRT keeps to constraints, and a goal may be any of several poses."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from ik_search import solve
from table_top import joined, named, robot_model

from grip_bt.base.failures import ConstraintBrokenError, NoIkError, TimeOutError
from grip_bt.base.values import JointState, PathConstraint, Pose
from grip_bt.base.values.solids import Box
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.damped_least_squares import Target
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.budget import Budget
from grip_bt.commanders.planning.paths import CONSTRAINT_SLACK, excess, interpolated, kept
from grip_bt.commanders.planning.requests import PlanTo, Situation
from grip_bt.commanders.planning.search import Search
from grip_bt.commanders.planning.tree_planners import CLEARANCES, Tree, costs
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings

LEVEL = pin.rpy.rpyToMatrix(0, np.pi / 2, 0)
"""A grasp frame whose z axis points forward, level."""
SCENE = SceneSnapshot(
    {
        "table": SceneObject("table", Box((0.7, 1.2, 0.1)), Pose((0.65, 0.0, -0.05)), fixed=True),
        "post": SceneObject("post", Box((0.06, 0.06, 0.7)), Pose((0.62, 0.0, 0.35)), fixed=True),
    }
)


@pytest.fixture(scope="module")
def model():
    return robot_model()


@pytest.fixture(scope="module")
def checker(model):
    return CollisionChecker(model.chain("arm", named(model, "hand", "open")), SCENE, "hand")


def level_at(checker, *position, turn=0.0):
    rotation = pin.rpy.rpyToMatrix(0, 0, turn) @ LEVEL
    q = solve(
        checker.chain, Target(pin.SE3(rotation, np.array(position))), np.random.default_rng(1), accept=checker.free
    )
    assert q is not None
    return q


def situation(model, checker, start, **settings):
    state = joined(JointState(checker.chain.joints, start), named(model, "hand", "open"))
    return Situation("arm", state, SCENE, "hand", PlanningSettings(**{"planning_time": 600.0, **settings}))


def pose(rotation, *position):
    return Pose.from_matrix(pin.SE3(rotation, np.array(position)).homogeneous)


def level():
    return PathConstraint(pose(LEVEL, 0, 0, 0), tolerance=(np.inf, 0.15, 0.15), axes="own")


def searched(checker, start, goal, planner, seed):
    settings = PlanningSettings(planner=planner, seed=seed)
    return Search(checker, settings, None, lambda: False).path(start, goal, Budget(600.0))


def test_a_tree_gives_the_way_back_to_its_root():
    tree = Tree(np.zeros(2))
    first = tree.add(np.array([1.0, 0.0]), 0)
    tree.add(np.array([0.0, 5.0]), 0)
    last = tree.add(np.array([2.0, 0.0]), first)
    assert tree.branch(last).tolist() == [[0, 0], [1, 0], [2, 0]]
    assert tree.nearest(np.array([0.1, 4.0])) == 2


def test_cost_falls_in_steps_with_clearance(checker):
    rows = np.random.default_rng(0).uniform(checker.chain.limits.lower, checker.chain.limits.upper, (300, 7))
    rows = rows[checker.free_each(rows)]
    cost = costs(checker, rows)
    assert set(cost) <= {k / len(CLEARANCES) for k in range(len(CLEARANCES) + 1)}
    assert checker.clear_each(rows[cost == 0], CLEARANCES[0]).all()
    assert not checker.clear_each(rows[cost == 1], CLEARANCES[-1]).any()


def test_bitrrt_comes_less_close_than_rrt_connect_and_repeats(checker):
    one, other = level_at(checker, 0.5, -0.3, 0.3), level_at(checker, 0.5, 0.3, 0.3)

    def mean_cost(planner, seed):
        path = searched(checker, one, other, planner, seed)
        fine = interpolated(path, 0.004)
        assert checker.all_free(fine)
        assert path[0] == pytest.approx(one)
        assert path[-1] == pytest.approx(other)
        return costs(checker, fine[::10]).mean(), path

    careful = [mean_cost("BiTRRT", seed)[0] for seed in range(4)]
    plain = [mean_cost("RRTConnect", seed)[0] for seed in range(4)]
    assert np.mean(careful) < np.mean(plain)
    assert np.array_equal(mean_cost("BiTRRT", 1)[1], mean_cost("BiTRRT", 1)[1])


def test_a_constrained_motion_keeps_the_hand_level_round_an_obstacle(model, checker):
    one, other = level_at(checker, 0.5, -0.3, 0.3), level_at(checker, 0.5, 0.3, 0.3)
    request = PlanTo(situation(model, checker, one), JointState(checker.chain.joints, other), constraint=level())
    positions = answer(model, request, lambda: False).trajectory.positions
    assert checker.all_free(interpolated(positions, 0.004))
    assert kept(level(), checker.chain, positions, CONSTRAINT_SLACK)
    for q in positions:
        forward = checker.chain.grasp_pose(q).rotation @ LEVEL.T
        assert abs(pin.log3(forward)[1]) < 0.2
    free = answer(model, dataclasses.replace(request, constraint=None), lambda: False).trajectory.positions
    assert not kept(level(), checker.chain, free, CONSTRAINT_SLACK)


def test_a_constrained_motion_stays_in_its_box(model, checker):
    box = PathConstraint(box=pose(np.eye(3), 0.4, 0.0, 0.4), size=(0.5, 0.9, 0.4))
    one, other = level_at(checker, 0.45, -0.3, 0.3), level_at(checker, 0.45, 0.3, 0.3)
    begin = situation(model, checker, one, planning_time=600.0)
    request = PlanTo(begin, JointState(checker.chain.joints, other), constraint=box)
    for q in answer(model, request, lambda: False).trajectory.positions:
        offset = checker.chain.grasp_pose(q).translation - [0.4, 0.0, 0.4]
        assert (np.abs(offset) <= np.array([0.25, 0.45, 0.2]) + CONSTRAINT_SLACK).all()


def test_rrt_connect_grows_in_short_steps(checker, monkeypatch):
    one, other = level_at(checker, 0.5, -0.3, 0.3), level_at(checker, 0.5, 0.3, 0.3)
    monkeypatch.setattr("grip_bt.commanders.planning.search.shortened", lambda path, *_: path)
    for seed in range(4):
        path = searched(checker, one, other, "RRTConnect", seed)
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= 0.25 * np.sqrt(7) + 1e-6


@pytest.mark.parametrize("end", ["start", "goal"])
def test_an_end_that_breaks_the_constraint_is_named(model, checker, end):
    level_one, tilted = level_at(checker, 0.5, -0.3, 0.3), named(model, "arm", "home").position
    assert not kept(level(), checker.chain, tilted[None, :])
    start, goal = (tilted, level_one) if end == "start" else (level_one, tilted)
    request = PlanTo(situation(model, checker, start), JointState(checker.chain.joints, goal), constraint=level())
    with pytest.raises(ConstraintBrokenError, match=f"the {end} violates"):
        answer(model, request, lambda: False)


def test_a_constraint_that_nothing_can_keep_ends_in_time(model, checker):
    one, other = level_at(checker, 0.5, -0.3, 0.3), level_at(checker, 0.5, 0.3, 0.3)
    tight = PathConstraint(box=pose(np.eye(3), 0.5, 0.0, 0.3), size=(0.02, 0.62, 0.02))  # straight through the post
    request = PlanTo(
        situation(model, checker, one, planning_time=0.5, attempts=1),
        JointState(checker.chain.joints, other),
        constraint=tight,
    )
    with pytest.raises(TimeOutError, match="CBiRRT"):
        answer(model, request, lambda: False)


@pytest.mark.parametrize("fields", [{"tolerance": (0.1, 0, 0.1)}, {"size": (1, -1, 1)}])
def test_tolerances_and_lengths_are_positive(fields):
    with pytest.raises(ValueError, match="3 positive numbers"):
        PathConstraint(**fields)


@pytest.mark.parametrize("axes", ["own", "world"])
def test_the_excess_has_the_derivative_that_it_says(checker, axes):
    constraint = PathConstraint(
        pose(LEVEL, 0, 0, 0), (0.05, 0.05, 0.05), axes, pose(LEVEL, 0.5, 0.5, 0.9), (0.1, 0.1, 0.1)
    )
    q = level_at(checker, 0.5, 0.2, 0.3) + 0.1
    value, jacobian = excess(constraint, checker.chain, q)
    columns = [(excess(constraint, checker.chain, q + 1e-6 * row)[0] - value) / 1e-6 for row in np.eye(7)]
    changing = value != 0
    assert changing.sum() >= 4
    assert np.column_stack(columns)[changing] == pytest.approx(jacobian[changing], abs=1e-4)


def test_of_several_poses_one_that_can_be_reached_is_taken(model, checker):
    start = level_at(checker, 0.5, -0.3, 0.3)
    far, near = pose(LEVEL, 3.0, 0.0, 0.3), pose(LEVEL, 0.45, -0.25, 0.35)
    positions = answer(model, PlanTo(situation(model, checker, start), (far, near)), lambda: False).trajectory.positions
    assert checker.chain.grasp_pose(positions[-1]).translation == pytest.approx([0.45, -0.25, 0.35], abs=1e-3)
    with pytest.raises(NoIkError, match="any of 2 poses"):
        answer(model, PlanTo(situation(model, checker, start), (far, far)), lambda: False)


def test_a_free_axis_lets_the_hand_turn_about_it(model, checker):
    start = level_at(checker, 0.5, -0.3, 0.3)
    goal = pose(LEVEL, 0.45, 0.25, 0.35)
    request = PlanTo(situation(model, checker, start), goal, free="orientation")
    end = answer(model, request, lambda: False).trajectory.positions[-1]
    assert checker.chain.grasp_pose(end).translation == pytest.approx(goal.position, abs=1e-3)


def test_acceleration_has_its_own_factor(model, checker):
    start, goal = level_at(checker, 0.5, -0.3, 0.3), level_at(checker, 0.45, -0.25, 0.35)
    limits = model.limits("arm")

    def strongest(**settings):
        request = PlanTo(situation(model, checker, start, **settings), JointState(checker.chain.joints, goal))
        return (np.abs(answer(model, request, lambda: False).trajectory.accelerations) / limits.acceleration).max()

    assert strongest(speed=0.8, acceleration=0.1) <= 0.11
    assert strongest(speed=0.8) > 0.2


@pytest.mark.parametrize("wrong", [{"speed": 0.0}, {"acceleration": 1.5}, {"attempts": 0}, {"planning_time": 0.0}])
def test_settings_say_what_is_allowed(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        PlanningSettings(**wrong)
