"""Motions of several parts: begun together, ended together, and none goes on alone."""

from __future__ import annotations

import numpy as np
import pytest
from timed import ManualClock, OnClock, TimedArm, TimedExecutor

from grip_bt.base.failures import CanceledError, ExecutionAbortedError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.commanders.joined import JoinedExecutor, all_of, execute_together


@pytest.fixture
def clock():
    return ManualClock()


def arm(clock, y, **more):
    return TimedArm("arm", Pose((0.3, y, 0.5)), OnClock(clock), **more)


def test_two_arms_end_at_the_same_time_where_they_were_sent(clock):
    left, right = arm(clock, 0.4), arm(clock, -0.4)
    near, far = left.grasp_pose().moved((0, 0, 0.1)), right.grasp_pose().moved((0, 0, 0.5))
    plans = {"left": (left, left.plan(near).result()), "right": (right, right.plan(far).result())}
    together = execute_together(plans)
    clock.advance(0.99)
    assert not together.done()
    assert left.grasp_pose().position[2] == pytest.approx(0.5 + 0.099)
    clock.advance(0.02)
    ends = together.result()
    assert ends["left"].position[:3] == pytest.approx(near.position)
    assert ends["right"].position[:3] == pytest.approx(far.position)


def test_when_one_arm_fails_the_other_holds_before_the_whole_ends(clock):
    left = arm(clock, 0.4, script={"execute": [ExecutionAbortedError("stuck")]})
    right = arm(clock, -0.4)
    goals = {"left": (left, (0, 0, 0.2)), "right": (right, (0, 0, 0.5))}
    together = execute_together({n: (a, a.plan(a.grasp_pose().moved(way)).result()) for n, (a, way) in goals.items()})
    clock.advance(0.5)
    assert not together.done(), "the other arm still brakes"
    clock.advance(0.6)
    with pytest.raises(ExecutionAbortedError, match="stuck"):
        together.result()
    held = right.grasp_pose()
    clock.advance(1.0)
    assert right.grasp_pose() == held


def test_cancelling_stops_all(clock):
    left, right = arm(clock, 0.4), arm(clock, -0.4)
    together = execute_together({a: (a, a.plan(a.grasp_pose().moved((0, 0, 0.2))).result()) for a in (left, right)})
    clock.advance(0.2)
    together.cancel()
    clock.advance(0.5)
    with pytest.raises(CanceledError):
        together.result()
    held = left.grasp_pose().position[2], right.grasp_pose().position[2]
    clock.advance(1)
    assert (left.grasp_pose().position[2], right.grasp_pose().position[2]) == held


def test_what_cannot_be_started_cancels_what_was():
    begun = Operation()

    def broken():
        raise ValueError("no")

    whole = all_of({"a": lambda: begun, "b": broken, "c": lambda: pytest.fail("must not be started")})
    with pytest.raises(ValueError, match="no"):
        whole.result()
    assert begun.cancel_asked
    assert all_of({}).result() == {}


def test_a_joined_executor_is_one_executor_of_all_joints(clock):
    first = TimedExecutor(JointState(("a", "b"), [0.0, 1.0]), OnClock(clock))
    second = TimedExecutor(JointState(("c",), [2.0]), OnClock(clock))
    joined = JoinedExecutor(first, second)
    assert isinstance(joined, Executor)
    assert joined.state().position.tolist() == [0.0, 1.0, 2.0]
    # The columns come in another order than the joints.
    way = Trajectory(("c", "a", "b"), [0.0, 1.0], [[2.0, 0.0, 1.0], [2.5, 0.1, 1.2]])
    moving = joined.execute(way)
    clock.advance(1.0)
    assert moving.result().as_mapping() == pytest.approx({"a": 0.1, "b": 1.2, "c": 2.5})
    with pytest.raises(ValueError, match="moves"):
        joined.execute(Trajectory(("a",), [0.0], [[0.0]]))
    with pytest.raises(ValueError, match="same joint"):
        JoinedExecutor(first, first)


def test_a_joined_motion_stops_altogether(clock):
    first = TimedExecutor(JointState(("a",), [0.0]), OnClock(clock))
    second = TimedExecutor(JointState(("b",), [0.0]), OnClock(clock), script=[ExecutionAbortedError("stuck")])
    joined = JoinedExecutor(first, second)
    moving = joined.execute(Trajectory(("a", "b"), [0.0, 2.0], [[0.0, 0.0], [1.0, 1.0]]))
    clock.advance(1.0)
    assert not moving.done(), "the other joint still brakes"
    clock.advance(0.5)
    with pytest.raises(ExecutionAbortedError):
        moving.result()
    held = joined.state().position
    clock.advance(2.0)
    assert joined.state().position.tolist() == held.tolist()
    assert held == pytest.approx([0.56, 0.5], abs=0.01)


def test_a_stretched_trajectory_is_the_same_path_slower():
    path = Trajectory(("a",), [0.0, 1.0], [[0.0], [2.0]], [[1.0], [3.0]], [[4.0], [4.0]])
    slow = path.stretched(2.0)
    assert slow.duration == 2.0
    assert slow.positions.tolist() == path.positions.tolist()
    assert slow.velocities.tolist() == [[0.5], [1.5]]
    assert slow.accelerations.tolist() == [[1.0], [1.0]]
    assert path.stretched(0.5) is path
    assert np.isfinite(Trajectory(("a",), [0.0], [[0.0]]).stretched(1.0).times).all()
