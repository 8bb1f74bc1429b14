"""The arm commander over a fake executor, with plans made in this process."""

from dataclasses import replace

import numpy as np
import pytest
from table_top import named, place_things, robot_model, room, side_grasps

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import (
    ExecutionAbortedError,
    ExpectedError,
    OutOfLimitsError,
    PathInvalidError,
    StartInCollisionError,
)
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Plan, Pose, Trajectory
from grip_bt.commanders.arm import ArmCommander, ArmSetup
from grip_bt.commanders.fake import FakeExecutor
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import PlanTo
from grip_bt.commanders.settings import PlanningSettings


class PlansHere:
    """Plans in this process, at once, and keeps the requests."""

    def __init__(self, model):
        self.model, self.requests = model, []

    def submit(self, request):
        self.requests.append(request)
        try:
            return Operation.finished(answer(self.model, request, lambda: False))
        except ExpectedError as error:
            return Operation.failed(error)


class Rig:
    def __init__(self, executor=None):
        self.model = robot_model()
        self.executor = executor or FakeExecutor(named(self.model, "arm", "home"))
        self.posture = named(self.model, "hand", "open")
        self.scene = room(self.model, hand=lambda: self.arm.grasp_pose())
        self.planner = PlansHere(self.model)
        self.arm = ArmCommander(
            ArmSetup("right", hand="right_hand", settings=PlanningSettings(planning_time=600.0)),
            self.model,
            self.planner,
            self.executor,
            self.scene,
            lambda: [self.posture],
        )


@pytest.fixture
def rig():
    return Rig()


class Sloppy(FakeExecutor):
    """Says that it succeeded, short of the end."""

    def execute(self, trajectory):
        super().execute(trajectory)
        self._position = self._position - 0.1
        return Operation.finished(self.state())


def go(arm, goal):
    return arm.plan(goal).then(arm.execute).result()


def test_the_result_of_a_motion_is_what_was_measured(rig):
    away = rig.arm.named_states()["home"].position + [0.4, 0, 0, 0, 0, 0, 0]
    measured = go(rig.arm, JointState(rig.executor.joint_names, away))
    assert measured == rig.executor.state()
    assert rig.arm.grasp_pose() == rig.model.grasp_pose(measured)


def test_a_motion_that_ends_elsewhere_is_aborted_with_the_errors(rig):
    rig = Rig(Sloppy(named(robot_model(), "arm", "home")))
    goal = rig.arm.named_states()["home"].position + [0.4, 0, 0, 0, 0, 0, 0]
    with pytest.raises(ExecutionAbortedError, match="0.100 rad") as caught:
        go(rig.arm, JointState(rig.executor.joint_names, goal))
    assert set(caught.value.data["errors"]) == set(rig.executor.joint_names)


def test_a_plan_made_elsewhere_is_not_executed(rig):
    plan = rig.arm.plan(JointState(("panda_joint1",), [0.6])).result()
    go(rig.arm, JointState(("panda_joint1",), [0.2]))
    with pytest.raises(ExecutionAbortedError):
        rig.arm.execute(plan).result()


def test_what_is_planned_is_known_until_it_or_a_later_plan_is_begun(rig):
    first, there, back = (rig.arm.plan(JointState(("panda_joint1",), [turn])).result() for turn in (0.1, 0.2, -0.2))
    assert [way is plan.trajectory for way, plan in zip(rig.arm.ways.planned, (first, there, back), strict=True)] == [
        True
    ] * 3
    assert rig.arm.ways.follows is None
    begun = []
    run = rig.executor.execute
    rig.executor.execute = lambda way: begun.append(rig.arm.ways.planned) or run(way)
    slow = replace(there, trajectory=there.trajectory.stretched(60.0))
    rig.arm.execute(slow).result()
    assert begun == [(back.trajectory,)]
    assert rig.arm.ways.planned == (back.trajectory,)
    assert rig.arm.ways[:2] == (slow.trajectory, False)


def test_each_plan_sees_the_scene_and_the_hand_as_they_are_when_it_is_asked(rig):
    rig.arm.plan("home").result()
    rig.posture = named(rig.model, "hand", "closed")
    rig.scene.set_box("block", (0.1, 0.1, 0.1), Pose(rig.arm.grasp_pose().position))
    with pytest.raises(StartInCollisionError, match="block"):
        rig.arm.plan("home").result()
    first, second = rig.planner.requests
    assert "block" not in first.situation.scene.objects
    hand = rig.posture.as_mapping()
    assert {n: p for n, p in second.situation.start.as_mapping().items() if n in hand} == hand


def test_planning_settings_reach_the_planner():
    rig = Rig()
    settings = PlanningSettings(planner="KPIECE1", speed=0.2, seed=4, planning_time=600.0)
    setup = ArmSetup("a", hand="right_hand", settings=settings)
    arm = ArmCommander(setup, rig.model, rig.planner, rig.executor, rig.scene, lambda: [rig.posture])
    plan = arm.plan(JointState(("panda_joint1",), [0.4])).result()
    fast = rig.arm.plan(JointState(("panda_joint1",), [0.4])).result()
    assert plan.planner == "KPIECE1"
    assert plan.trajectory.duration > 1.5 * fast.trajectory.duration


def test_named_states_are_goals_and_unknown_ones_list_them(rig):
    assert isinstance(rig.arm.plan("home").result(), Plan)
    with pytest.raises(UnknownNameError, match="home"):
        rig.arm.plan("hoem")


def test_a_grasp_is_approached_by_the_joint_positions_that_made_it_feasible(rig):
    rng = np.random.default_rng(3)
    things = place_things(rig.scene, rng)
    grasp = rig.arm.choose_grasp([g for t in things for g in side_grasps(t, rng)]).result()
    measured = go(rig.arm, grasp.pre_grasp)
    request = rig.planner.requests[-1]
    assert isinstance(request, PlanTo)
    assert measured.position == pytest.approx(request.hints[0].position, abs=1e-2)
    assert rig.arm.grasp_pose().matrix() == pytest.approx(grasp.pre_grasp.matrix(), abs=1e-3)


def test_a_thing_is_taken_lifted_carried_and_the_scene_follows(rig):
    """Choose, go, approach, attach, lift, home: what the leaves of a pick ask for, one after the other."""
    rng = np.random.default_rng(3)
    things = place_things(rig.scene, rng)
    grasp = rig.arm.choose_grasp([g for t in things for g in side_grasps(t, rng)]).result()
    target = rig.scene.snapshot().around(grasp.pose.position + 0.033 * grasp.pose.rotation()[:, 2], 0.03)[0]
    size, pose = rig.scene.box(target)
    go(rig.arm, grasp.pre_grasp)
    rig.scene.remove(target)
    rig.arm.plan_straight([grasp.pose]).then(rig.arm.execute).result()
    rig.scene.set_box(target, size, pose)
    rig.scene.attach(target, "right_hand")
    rig.arm.plan_straight([grasp.post_grasp]).then(rig.arm.execute).result()
    assert rig.scene.box(target)[1].position == pytest.approx(pose.position + [0, 0, 0.15], abs=2e-3)
    go(rig.arm, "home")
    held = rig.scene.box(target)[1]
    assert np.linalg.norm(held.position - rig.arm.grasp_pose().position) < 0.08
    assert abs(held.rotation()[2, 2]) > 0.99, "home carries an upright thing upright"


# --- trajectories that somebody else made ---


def swung(rig, joint, by, seconds):
    """Return a trajectory of one joint that turns by an angle [rad] and back, and how it was named."""
    here = rig.arm.state().as_mapping()[joint]
    return Trajectory((joint,), [0.0, seconds, 2 * seconds], [[here], [here + by], [here]])


def test_a_given_trajectory_becomes_a_plan_for_all_joints(rig):
    first = rig.arm.state().names[0]
    plan = rig.arm.plan_from_trajectory(swung(rig, first, 0.3, 2.0)).result()
    assert (plan.group, plan.trajectory.names) == ("arm", rig.arm.state().names)
    assert plan.trajectory.positions[1] - rig.arm.state().position == pytest.approx([0.3, *[0.0] * 6])
    assert rig.arm.execute(plan).result().position == pytest.approx(rig.arm.state().position)


def test_a_given_trajectory_that_is_too_fast_says_how_much_longer_it_has_to_last(rig):
    first = rig.arm.state().names[0]
    with pytest.raises(OutOfLimitsError, match=rf"velocity of {first} = -?45\.\d+ .* times as long") as caught:
        rig.arm.plan_from_trajectory(swung(rig, first, 0.3, 0.01)).result()
    assert caught.value.data["joints"] == (first,)


def test_a_given_trajectory_out_of_limits_says_where(rig):
    first = rig.arm.state().names[0]
    with pytest.raises(OutOfLimitsError, match=rf"20\.00 s into the trajectory, .* out of limits: {first} = "):
        rig.arm.plan_from_trajectory(swung(rig, first, 9.0, 20.0)).result()


def test_a_given_trajectory_with_something_in_its_way_says_when_and_what(rig):
    home = rig.arm.state()
    down = np.array(home.position)
    down[1] += 1.2  # the shoulder leans forward, into the table
    given = Trajectory(home.names, [0.0, 5.0], [home.position, down])
    with pytest.raises(PathInvalidError, match=r"\d\.\d s into the trajectory, .* touches") as caught:
        rig.arm.plan_from_trajectory(given).result()
    assert 0.0 < caught.value.data["time"] < 5.0
    backward = Trajectory(home.names, [0.0, 5.0], [down, home.position])
    with pytest.raises(PathInvalidError, match="the trajectory starts in collision: .* touches"):
        rig.arm.plan_from_trajectory(backward).result()


def test_a_given_trajectory_is_looked_at_where_a_controller_draws_it_between_its_points(rig):
    home = rig.arm.state()
    rows, velocities = np.tile(home.position, (4, 1)), np.zeros((4, 7))
    rows[1:3, 1] += 0.3  # the shoulder leans forward, far above the table
    rig.arm.plan_from_trajectory(Trajectory(home.names, [0.0, 1.5, 3.5, 5.0], rows, velocities)).result()
    velocities[1:3, 1] = [1.5, -1.5]  # through the same points, and into the table between the inner ones
    swung = Trajectory(home.names, [0.0, 1.5, 3.5, 5.0], rows, velocities)
    with pytest.raises(PathInvalidError, match=r"into the trajectory, .* touches") as caught:
        rig.arm.plan_from_trajectory(swung).result()
    assert 1.5 < caught.value.data["time"] < 3.5


def abrupt(rig):
    """A motion of 0.2 s within its limits of velocity, and twice as hard as its acceleration may be."""
    first, limits = rig.arm.state().names[0], rig.model.limits("arm")
    return swung(rig, first, 2.0 * limits.acceleration[0] * 0.2**2 / 6, 0.2)


def test_a_given_trajectory_that_accelerates_too_hard_is_refused_and_can_be_given_more_time(rig):
    given, limits = abrupt(rig), rig.model.limits("arm")
    with pytest.raises(OutOfLimitsError, match=r"acceleration of panda_joint1 = .*1\.41\d times.*slow_down") as caught:
        rig.arm.plan_from_trajectory(given).result()
    assert abs(caught.value.data["value"]) == pytest.approx(2.0 * limits.acceleration[0], rel=1e-3)
    assert abs(caught.value.data["limit"]) == limits.acceleration[0]
    plan = rig.arm.plan_from_trajectory(given, slow_down=True).result()
    assert plan.trajectory.positions[:, 0] == pytest.approx(given.positions[:, 0])
    speed, times = PlanningSettings().speed, np.linspace(0.0, plan.trajectory.duration, 1001)
    hardest = np.abs(plan.trajectory.sampled(times)[2]).max(axis=0)[0]
    assert hardest == pytest.approx(limits.acceleration[0] * speed, rel=1e-3)
    assert rig.arm.execute(plan).result().position == pytest.approx(rig.arm.state().position)


@pytest.mark.parametrize("made", ["elsewhere", "RRTConnect"])
def test_a_plan_that_is_beyond_limits_moves_nothing_whoever_is_said_to_have_made_it(rig, made):
    first = rig.arm.state()
    slow = rig.arm.plan_from_trajectory(swung(rig, first.names[0], 0.3, 2.0)).result()
    hasty = slow.trajectory
    hasty = Trajectory(hasty.names, hasty.times / 10, hasty.positions, hasty.velocities * 10)
    with pytest.raises(OutOfLimitsError, match="of panda_joint1 = "):
        rig.arm.execute(Plan("arm", hasty, made)).result()
    jumping = Trajectory(hasty.names, [0.0, 5.0, 10.0], hasty.positions)
    with pytest.raises(OutOfLimitsError, match="without velocities"):
        rig.arm.execute(Plan("arm", jumping, made)).result()
    assert rig.arm.state().position == pytest.approx(first.position)
    assert rig.arm.execute(Plan("arm", hasty, "move_group")).result() == rig.arm.state()  # its controllers' business
