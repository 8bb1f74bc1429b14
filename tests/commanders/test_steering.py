"""Steered motions: continuous, within limits, and free to their end before they begin."""

import numpy as np
import pytest
from table_top import named, robot_model, room
from timed import ManualClock, OnClock, TimedExecutor

from grip_bt.base.failures import ExpectedError, NoIkError, OutOfLimitsError, PathInvalidError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Steerable
from grip_bt.base.values import Pose, Trajectory
from grip_bt.commanders.arm import ArmCommander, ArmSetup
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import PlanServoStep
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.commanders.steering import HOLD, SAMPLING, approaching, spliced, steered

TICK = 0.05


class Later:
    """Plans in this process; answers when it is told to, at once by default."""

    def __init__(self, model):
        self.model, self.requests, self.held, self.waiting = model, [], False, []

    def submit(self, request):
        self.requests.append(request)
        operation = Operation()
        self.waiting.append((request, operation))
        if not self.held:
            self.tell()
        return operation

    def tell(self):
        waiting, self.waiting = self.waiting, []
        for request, operation in waiting:
            try:
                operation.succeed(answer(self.model, request, lambda: False))
            except ExpectedError as error:
                operation.fail(error)


class Rig:
    def __init__(self, executor=TimedExecutor, speed=0.6):
        self.model, self.clock = robot_model(), ManualClock()
        self.executor = executor(named(self.model, "arm", "home"), OnClock(self.clock))
        self.scene = room(self.model, hand=lambda: self.arm.grasp_pose())
        self.planner, posture = Later(self.model), named(self.model, "hand", "open")
        self.arm = ArmCommander(
            ArmSetup("right", hand="right_hand", settings=PlanningSettings(speed=speed, planning_time=600.0)),
            self.model,
            self.planner,
            self.executor,
            self.scene,
            lambda: [posture],
        )

    def steer(self, seconds, ask):
        """Ask every 50 ms; return the operation, the joints and the places of the grasp frame, tick by tick."""
        joints, places = [], []
        for _ in range(round(seconds / TICK)):
            operation = ask()
            self.clock.advance(TICK)
            joints.append(self.arm.state().position)
            places.append(self.arm.grasp_pose().position)
            if operation.done():
                break
        return operation, np.stack(joints), np.stack(places)


@pytest.fixture
def rig():
    return Rig()


def test_a_steered_hand_moves_on_a_line_at_its_speed_without_a_stop(rig):
    begin = rig.arm.grasp_pose()
    operation, _, places = rig.steer(2.0, lambda: rig.arm.steer((0.0, 0.1, 0.0)))
    assert not operation.done()
    speeds = np.diff(places, axis=0) / TICK
    assert speeds[4:] == pytest.approx(np.tile([0.0, 0.1, 0.0], (len(speeds) - 4, 1)), abs=0.004)
    assert places[:, [0, 2]] == pytest.approx(np.tile(begin.position[[0, 2]], (len(places), 1)), abs=2e-3)
    assert rig.arm.grasp_pose().quaternion == pytest.approx(begin.quaternion, abs=5e-3)
    assert all(isinstance(request, PlanServoStep) for request in rig.planner.requests)


def test_limits_of_velocity_and_acceleration_are_kept_over_every_splice(rig):
    turns = iter([(0.0, 0.25, 0.0), (0.0, -0.25, 0.0), (0.1, 0.0, 0.1)] * 40)
    rig.steer(3.0, lambda: rig.arm.steer(next(turns)))
    limits = rig.model.limits("arm")
    whole = rig.executor.executed[0]
    began = [0.0]
    for step in rig.executor.executed[1:]:
        began.append(began[-1] + HOLD)
        whole = spliced(whole, step, began[-1])
    assert len(began) > 8
    assert np.abs(whole.velocities / (0.6 * limits.velocity)).max() <= 1 + 1e-9
    change = np.diff(whole.velocities, axis=0) / np.diff(whole.times)[:, None]
    assert np.abs(change / (0.6 * limits.acceleration)).max() <= 1 + 1e-6
    moved = np.diff(whole.positions, axis=0)
    mean = (whole.velocities[1:] + whole.velocities[:-1]) / 2 * np.diff(whole.times)[:, None]
    assert moved == pytest.approx(mean, abs=1e-9), "velocities are those of the positions"


def test_what_is_in_the_way_is_not_touched_and_the_arm_rests_before_it(rig):
    start = rig.arm.grasp_pose().position
    rig.scene.set_box("wall", (0.6, 0.02, 1.0), Pose(start + [0.0, 0.45, 0.0]))
    operation, joints, places = rig.steer(6.0, lambda: rig.arm.steer((0.0, 0.2, 0.0)))
    with pytest.raises(PathInvalidError, match="would collide.*wall"):
        operation.result()
    assert places[-1][1] - start[1] > 0.05, "it went as far as was free"
    situation = rig.planner.requests[-1].situation
    chain = rig.model.chain("arm", situation.start)
    checker = CollisionChecker(chain, situation.scene, situation.hand)
    assert checker.all_free(joints)
    rest = rig.arm.state()
    rig.clock.advance(1.0)
    assert rig.arm.state().position.tolist() == rest.position.tolist()


def test_something_that_appears_meanwhile_stops_the_arm(rig):
    rig.steer(1.0, lambda: rig.arm.steer((0.0, 0.15, 0.0)))
    here = rig.arm.grasp_pose().position
    rig.scene.set_box("block", (0.5, 0.02, 1.0), Pose(here + [0.0, 0.4, 0.0]))
    operation, _, places = rig.steer(5.0, lambda: rig.arm.steer((0.0, 0.15, 0.0)))
    with pytest.raises(PathInvalidError, match="block"):
        operation.result()
    assert places[-1][1] - here[1] < 0.4


def test_a_plan_that_comes_too_late_lets_the_arm_rest_where_it_was_checked(rig):
    first = rig.arm.steer((0.0, 0.2, 0.0))
    rig.clock.advance(TICK)
    rig.planner.held = True
    rig.arm.steer((0.0, 0.2, 0.0))
    assert rig.planner.waiting
    rig.clock.advance(2.0)
    end = rig.executor.executed[0].positions[-1]
    assert first.result().position == pytest.approx(end)
    rig.planner.tell()
    assert rig.arm.state().position == pytest.approx(end)
    assert len(rig.executor.executed) == 1
    rig.planner.held = False
    again = rig.arm.steer((0.0, 0.2, 0.0))
    assert again is not first
    assert len(rig.executor.executed) == 2


def test_a_pose_is_reached_without_going_beyond_it(rig):
    target = rig.arm.grasp_pose().moved((0.0, 0.2, 0.05))
    _, _, places = rig.steer(4.0, lambda: rig.arm.steer_to(target, 0.2))
    assert places[-1] == pytest.approx(target.position, abs=2e-3)
    assert places[:, 1].max() < target.position[1] + 2e-3


def test_a_stop_brings_a_steered_motion_to_rest(rig):
    operation, _, _ = rig.steer(1.0, lambda: rig.arm.steer((0.0, 0.1, 0.0)))
    rig.arm.stop()
    rig.clock.advance(0.5)
    assert operation.done()
    held = rig.arm.state().position
    rig.clock.advance(1.0)
    assert rig.arm.state().position.tolist() == held.tolist()


def test_an_executor_that_knows_no_going_on_rests_after_each_step():
    class Plain:
        def __init__(self, *given):
            self.inner = TimedExecutor(*given)
            self.joint_names, self.state = self.inner.joint_names, self.inner.state
            self.execute, self.stop = self.inner.execute, self.inner.stop

    rig = Rig(Plain)
    assert not isinstance(rig.executor, Steerable)
    ends = []
    begin = rig.arm.grasp_pose().position
    for _ in range(100):
        operation = rig.arm.steer((0.0, 0.1, 0.0))
        rig.clock.advance(TICK)
        if operation.done():
            ends.append(operation.result())
        if len(ends) == 3:
            break
    assert rig.arm.grasp_pose().position[1] - begin[1] > 0.1
    assert len(rig.executor.inner.executed) == 3


def test_ways_that_cannot_be_gone_are_named(rig):
    with pytest.raises(ValueError, match="finite"):
        rig.arm.steer((np.nan, 0.0, 0.0))
    rig.steer(20.0, lambda: rig.arm.steer((0.0, 0.0, 0.25)))
    operation = rig.arm.steer((0.25, 0.0, 0.25))
    for _ in range(400):
        if operation.done():
            break
        operation = rig.arm.steer((0.25, 0.0, 0.25))
        rig.clock.advance(TICK)
    with pytest.raises((NoIkError, OutOfLimitsError, PathInvalidError)):
        operation.result()


# --- the pure parts ---


def test_a_step_begins_as_it_should_and_ends_at_rest():
    rng = np.random.default_rng(0)
    for _ in range(50):
        n = int(rng.integers(1, 8))
        q, v, goal = rng.normal(size=n), rng.normal(size=n), rng.normal(size=n)
        hardest = rng.uniform(0.5, 10, n)
        step = steered([f"j{k}" for k in range(n)], q, v, lambda _, goal=goal: goal, hardest)
        assert step.positions[0].tolist() == q.tolist()
        assert step.velocities[0].tolist() == v.tolist()
        assert step.velocities[-1] == pytest.approx(np.zeros(n), abs=1e-12)
        change = np.diff(step.velocities, axis=0) / np.diff(step.times)[:, None]
        assert (np.abs(change) <= hardest * (1 + 1e-6)).all()
        assert step.times[round(HOLD / SAMPLING)] == pytest.approx(HOLD)


def test_with_limits_of_jerk_steps_go_over_into_each_other_without_acceleration():
    rng = np.random.default_rng(1)
    for _ in range(20):
        n, whole, began = int(rng.integers(1, 8)), None, 0.0
        q, v, hardest = rng.normal(size=n), np.zeros(n), rng.uniform(0.5, 10, n)
        sharpest = hardest * rng.uniform(5, 300)
        for _ in range(6):
            goal = rng.normal(size=n)
            step = steered([f"j{k}" for k in range(n)], q, v, lambda _, goal=goal: goal, hardest, jerk=sharpest)
            assert step.times[round(HOLD / SAMPLING)] == pytest.approx(HOLD)
            assert step.velocities[-1] == pytest.approx(np.zeros(n), abs=1e-12)
            whole = step if whole is None else spliced(whole, step, began)
            began += HOLD
            q, v = (rows[round(HOLD / SAMPLING)] for rows in (step.positions, step.velocities))
        accelerations = whole.sampled(np.arange(0.0, whole.duration, 1e-3))[2]
        assert (np.abs(accelerations) <= hardest * (1 + 1e-6)).all()
        assert (np.abs(np.diff(accelerations, axis=0)) * 1e3 <= sharpest * (1 + 1e-4)).all()


def test_a_splice_that_jumps_or_moves_other_joints_is_refused():
    one = Trajectory(("a",), [0.0, 1.0], [[0.0], [1.0]])
    assert spliced(one, Trajectory(("a",), [0.0, 1.0], [[0.5], [0.0]]), 0.5).at(1.5) == pytest.approx([0.0])
    with pytest.raises(ValueError, match="rad away"):
        spliced(one, Trajectory(("a",), [0.0], [[0.7]]), 0.5)
    with pytest.raises(ValueError, match="can't continue"):
        spliced(one, Trajectory(("b",), [0.0], [[0.5]]), 0.5)


def test_an_approach_gets_slower_near_its_target():
    far, _ = approaching(Pose(), Pose((1.0, 0.0, 0.0)), 0.15, HOLD)
    near, _ = approaching(Pose(), Pose((0.01, 0.0, 0.0)), 0.15, HOLD)
    assert far == pytest.approx([0.15, 0.0, 0.0])
    assert near == pytest.approx([0.01 / (2 * HOLD), 0.0, 0.0])
