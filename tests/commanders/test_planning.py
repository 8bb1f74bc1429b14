import dataclasses
import itertools

import numpy as np
import pytest
from table_top import (
    endless_request,
    joined,
    named,
    place_things,
    robot_model,
    room,
    side_grasp,
    side_grasps,
    situation,
)

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import (
    CanceledError,
    GoalInCollisionError,
    NoGraspError,
    NoIkError,
    OutOfLimitsError,
    PathInvalidError,
    StartInCollisionError,
)
from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.paths import interpolated
from grip_bt.commanders.planning.requests import ChooseGrasp, PlanStraight, PlanTo
from grip_bt.commanders.settings import PLANNERS, PlanningSettings


def never():
    return False


def table(seed=3):
    """A scene with three things, and a grasp of the first of them that is known to be feasible."""
    model, rng = robot_model(), np.random.default_rng(seed)
    scene = room(model)
    things = place_things(scene, rng)
    return model, scene, things, rng


def with_settings(state, **changes):
    return dataclasses.replace(state, settings=state.settings.model_copy(update=changes))


@pytest.fixture(scope="module")
def chosen():
    model, scene, things, rng = table()
    candidates = [g for thing in things for g in side_grasps(thing, rng)]
    return answer(model, ChooseGrasp(situation(model, scene.snapshot()), tuple(candidates)), never)


def assert_free(model, scene, trajectory, count=10_000):
    """Check `count` samples of a trajectory, evenly over its points."""
    chain = model.chain("arm", named(model, "hand", "open"))
    checker = CollisionChecker(chain, scene, "right_hand")
    span = np.linspace(0, len(trajectory.positions) - 1, count)
    columns = [np.interp(span, np.arange(len(trajectory.positions)), c) for c in trajectory.positions.T]
    assert checker.free_each(np.stack(columns, axis=1)).all()


def test_none_of_ten_thousand_samples_of_a_returned_path_collides(chosen):
    model, scene, *_ = table()
    snapshot = scene.snapshot()
    for seed in range(4):
        request = PlanTo(situation(model, snapshot, seed=seed), chosen.at_pre_grasp)
        assert_free(model, snapshot, answer(model, request, never).trajectory)


def test_the_direct_way_really_is_blocked_where_a_planner_is_needed(chosen):
    """Otherwise the test above would show nothing."""
    model, scene, *_ = table()
    checker = CollisionChecker(model.chain("arm"), scene.snapshot(), "right_hand")
    line = np.stack([named(model, "arm", "home").position, chosen.at_pre_grasp.position])
    assert not checker.all_free(interpolated(line, 0.01))


def test_the_same_request_gives_the_same_plan_whatever_was_asked_before(chosen):
    model, scene, *_ = table()
    first, other = (PlanTo(situation(model, scene.snapshot(), seed=s), chosen.at_pre_grasp) for s in (5, 6))
    one = answer(model, first, never).trajectory
    different = answer(model, other, never).trajectory
    assert answer(model, first, never).trajectory == one
    assert different != one


def test_a_pose_goal_is_reached_and_hints_come_first(chosen):
    model, scene, *_ = table()
    request = PlanTo(situation(model, scene.snapshot()), chosen.grasp.pre_grasp, (chosen.at_pre_grasp,))
    end = answer(model, request, never).trajectory.end()
    assert model.grasp_pose(end).matrix() == pytest.approx(chosen.grasp.pre_grasp.matrix(), abs=1e-3)
    assert end.position == pytest.approx(chosen.at_pre_grasp.position, abs=1e-2)


@pytest.mark.parametrize("planner", ["RRTConnect", "KPIECE1", "LBKPIECE1", "BITstar", "PRM"])
def test_planners_are_chosen_by_name(chosen, planner):
    model, scene, *_ = table()
    start = with_settings(situation(model, scene.snapshot()), planner=planner, planning_time=600.0)
    plan = answer(model, PlanTo(start, chosen.at_pre_grasp), never)
    assert plan.planner == planner
    assert_free(model, scene.snapshot(), plan.trajectory)


def test_an_unknown_planner_lists_those_that_exist(chosen):
    model, scene, *_ = table()
    assert "RRTConnect" in PLANNERS
    start = with_settings(situation(model, scene.snapshot()), planner="RRTconnect")
    with pytest.raises(UnknownNameError, match="did you mean 'RRTConnect'"):
        answer(model, PlanTo(start, chosen.at_pre_grasp), never)


def test_a_start_in_collision_names_what_touches():
    model, scene, *_ = table()
    hand = model.grasp_pose(named(model, "arm", "home"))
    scene.set_box("in_the_way", (0.1, 0.1, 0.1), Pose(hand.position))
    with pytest.raises(StartInCollisionError, match="in_the_way") as caught:
        answer(model, PlanTo(situation(model, scene.snapshot()), named(model, "arm", "home")), never)
    assert all("in_the_way" in pair for pair in caught.value.data["pairs"])


def test_a_goal_in_collision_names_what_touches(chosen):
    model, scene, *_ = table()
    with pytest.raises(GoalInCollisionError) as caught:
        answer(model, PlanTo(situation(model, scene.snapshot()), chosen.at_grasp), never)
    assert {b for _, b in caught.value.data["pairs"]} <= set(scene.names())


def test_a_pose_in_the_table_is_a_goal_in_collision():
    model, scene, *_ = table()
    pose = side_grasp(table()[2][0], 0.0, 1.0).pose
    low = pose.moved([0, 0, 0.01 - pose.position[2]])
    with pytest.raises(GoalInCollisionError, match="touches"):
        answer(model, PlanTo(situation(model, scene.snapshot()), low), never)


def test_a_pose_out_of_reach_is_no_ik():
    model, scene, *_ = table()
    with pytest.raises(NoIkError):
        answer(model, PlanTo(situation(model, scene.snapshot()), Pose([2.0, 0, 0.5])), never)


def test_a_goal_out_of_limits_names_joint_and_limits():
    model, scene, *_ = table()
    with pytest.raises(OutOfLimitsError, match=r"panda_joint2 = 3\.000 \(allowed") as caught:
        answer(model, PlanTo(situation(model, scene.snapshot()), JointState(("panda_joint2",), [3.0])), never)
    assert caught.value.data["joints"] == ("panda_joint2",)


@pytest.mark.parametrize("position", [np.nan, np.inf])
def test_a_goal_that_is_not_finite_is_refused(position):
    model, scene, *_ = table()
    with pytest.raises(OutOfLimitsError, match="panda_joint2"):
        answer(model, PlanTo(situation(model, scene.snapshot()), JointState(("panda_joint2",), [position])), never)


def test_joints_that_a_goal_does_not_name_stay_and_unknown_ones_are_refused():
    model, scene, *_ = table()
    start = situation(model, scene.snapshot())
    goal = answer(model, PlanTo(start, JointState(("panda_joint7",), [0.1])), never).trajectory.end()
    home = named(model, "arm", "home").as_mapping() | {"panda_joint7": 0.1}
    assert goal.as_mapping() == pytest.approx(home)
    with pytest.raises(UnknownNameError, match="panda_joint7"):
        answer(model, PlanTo(start, JointState(("panda_joint77",), [0.1])), never)


@pytest.mark.parametrize("planner", ["RRTConnect", "AORRTC", "BiTRRT"])
def test_who_cancels_may_say_so_as_numpy_does(planner):
    """A comparison of an array's elements isn't Python's bool, which OMPL's bindings insist on."""
    asked = itertools.count()
    with pytest.raises(CanceledError):
        answer(robot_model(), endless_request(planner), lambda: np.bool_(next(asked) > 50))


def test_a_cancelled_plan_ends_as_cancelled(chosen):
    model, scene, *_ = table()
    request = PlanTo(situation(model, scene.snapshot()), chosen.at_pre_grasp)
    with pytest.raises(CanceledError):
        answer(model, request, lambda: True)


def test_a_straight_motion_keeps_to_its_line_and_attitude(chosen):
    model, scene, *_ = table()
    start = model.grasp_pose(chosen.at_pre_grasp)
    goal = start.moved([0.0, 0.0, 0.15])
    begin = situation(model, scene.snapshot(), chosen.at_pre_grasp)
    trajectory = answer(model, PlanStraight(begin, (goal,)), never).trajectory
    for q in trajectory.positions:
        pose = model.grasp_pose(JointState(trajectory.names, q))
        assert pose.position[:2] == pytest.approx(start.position[:2], abs=2e-3)
        assert pose.rotation() == pytest.approx(start.rotation(), abs=5e-3)
    assert model.grasp_pose(trajectory.end()).matrix() == pytest.approx(goal.matrix(), abs=1e-3)


def test_a_straight_motion_into_the_table_tells_what_it_touches_and_how_far_it_got(chosen):
    model, scene, *_ = table()
    begin = situation(model, scene.snapshot(), chosen.at_pre_grasp)
    pose = model.grasp_pose(chosen.at_pre_grasp)
    with pytest.raises(PathInvalidError, match="table") as caught:
        answer(model, PlanStraight(begin, (pose.moved([0, 0, -pose.position[2]]),)), never)
    assert 0 < caught.value.data["fraction"] < 1


def test_a_straight_motion_out_of_reach_tells_how_far_it_got():
    model, scene, *_ = table()
    pose = model.grasp_pose(named(model, "arm", "home"))
    poses = (pose.moved([0, 0, 0.02]), pose.moved([0, -2.0, 0]))
    with pytest.raises(NoIkError, match="line 2 of 2") as caught:
        answer(model, PlanStraight(situation(model, scene.snapshot()), poses), never)
    assert 0 < caught.value.data["fraction"] < 1


def test_a_chosen_grasp_has_a_free_approach_and_lift(chosen):
    model, scene, *_ = table()
    grasp = chosen.grasp
    assert model.grasp_pose(chosen.at_grasp).matrix() == pytest.approx(grasp.pose.matrix(), abs=1e-3)
    target = scene.snapshot().around(grasp.pose.position + 0.033 * grasp.pose.rotation()[:, 2], 0.03)[0]
    rest = scene.snapshot().without([target])
    approach = PlanStraight(situation(model, rest, chosen.at_pre_grasp), (grasp.pose,))
    assert_free(model, rest, answer(model, approach, never).trajectory, 2000)
    held = scene.snapshot().attaching(target, "right_hand", grasp.pose)
    lift = PlanStraight(situation(model, held, chosen.at_grasp), (grasp.post_grasp,))
    assert_free(model, held, answer(model, lift, never).trajectory, 2000)


def test_the_better_of_two_feasible_grasps_is_chosen(chosen):
    model, scene, *_ = table()
    better = dataclasses.replace(chosen.grasp, quality=9.0, provenance="better")
    worse = dataclasses.replace(chosen.grasp, quality=1.0, provenance="worse")
    found = answer(model, ChooseGrasp(situation(model, scene.snapshot()), (worse, better)), never)
    assert found.grasp.provenance == "better"


def test_refused_grasps_are_counted_by_reason(chosen):
    model, scene, things, _ = table()
    far = dataclasses.replace(chosen.grasp, pose=chosen.grasp.pose.moved([1.0, 0, 0]))
    low = dataclasses.replace(chosen.grasp, pose=chosen.grasp.pose.moved([0, 0, -0.09]))
    lifts_far = dataclasses.replace(chosen.grasp, post_grasp=chosen.grasp.post_grasp.moved([0, 0, 1.5]))
    with pytest.raises(NoGraspError, match="none of 3 grasps is feasible") as caught:
        answer(model, ChooseGrasp(situation(model, scene.snapshot()), (far, low, lifts_far)), never)
    assert caught.value.data["reasons"] == {"no_ik": 1, "in_collision": 1, "lift_blocked": 1}
    assert caught.value.data["candidates"] == 3


def test_another_thing_beside_the_target_blocks_the_approach(chosen):
    model, scene, *_ = table()
    middle = (chosen.grasp.pose.position + chosen.grasp.pre_grasp.position) / 2
    scene.set_box("post", (0.02, 0.02, 0.4), Pose([*middle[:2], 0.2]))
    with pytest.raises(NoGraspError) as caught:
        answer(model, ChooseGrasp(situation(model, scene.snapshot()), (chosen.grasp,)), never)
    assert set(caught.value.data["reasons"]) <= {"approach_blocked", "in_collision", "pre_grasp_in_collision"}


@pytest.mark.parametrize("wrong", [{"speed": 0.0}, {"speed": 1.5}, {"planning_time": 0.0}, {"margin": -0.1}])
def test_settings_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        PlanningSettings(**wrong)


def test_the_hands_posture_is_an_obstacle_too():
    """Flat fingers reach where bent ones don't."""
    model, scene, *_ = table()
    home = named(model, "arm", "home")
    flat = model.grasp_pose(home).apply([[0.15, 0.0, -0.011]])[0]
    scene.set_box("pin", (0.01, 0.01, 0.01), Pose(flat))
    bent = PlanTo(situation(model, scene.snapshot(), hand="open"), home)
    assert answer(model, bent, never).trajectory.duration == 0
    with pytest.raises(StartInCollisionError, match="pin"):
        answer(model, PlanTo(situation(model, scene.snapshot(), hand="flat"), home), never)


def test_a_start_may_be_a_hair_outside_the_limits():
    model, scene, *_ = table()
    home = named(model, "arm", "home").as_mapping()
    upper = float(model.limits("arm").upper[6])
    start = JointState.from_mapping(home | {"panda_joint7": upper + 0.01})
    begin = dataclasses.replace(situation(model, scene.snapshot()), start=joined(start, named(model, "hand", "open")))
    plan = answer(model, PlanTo(begin, JointState(("panda_joint7",), [upper - 0.5])), never)
    assert plan.trajectory.positions[0, 6] == pytest.approx(upper)
