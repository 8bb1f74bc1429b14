"""What every `ports.Executor` does."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.errors import CanceledError, ExecutionAbortedError
from grip_bt.ports import Executor, Steerable
from grip_bt.values import Trajectory


def towards(rig, duration=1.0):
    names = rig.port.joint_names
    start, goal = rig.port.state().ordered(names), rig.goal.ordered(names)
    part = np.linspace(0, 1, 41)
    smooth = part * part * (3 - 2 * part)
    return Trajectory(names, part * duration, start + (goal - start) * smooth[:, None])


def test_it_satisfies_the_protocol(executor_rig):
    assert isinstance(executor_rig.port, Executor)
    assert executor_rig.port.state().names == executor_rig.port.joint_names


def test_a_motion_ends_with_the_measured_state_near_its_last_point(executor_rig):
    trajectory = towards(executor_rig)
    operation = executor_rig.port.execute(trajectory)
    assert not operation.done()
    measured = executor_rig.wait(operation).result()
    assert measured.names == trajectory.names
    assert measured.position == pytest.approx(trajectory.positions[-1], abs=0.02)
    assert executor_rig.port.state().position == pytest.approx(measured.position, abs=0.01)


def test_joints_are_on_their_way_in_the_middle_of_a_motion(executor_rig):
    trajectory = towards(executor_rig)
    operation = executor_rig.port.execute(trajectory)
    executor_rig.let_pass(0.5)
    assert not operation.done()
    span = np.abs(trajectory.positions[-1] - trajectory.positions[0]).max()
    from_start = np.abs(executor_rig.port.state().position - trajectory.positions[0]).max()
    assert 0.1 * span < from_start < 0.9 * span
    executor_rig.wait(operation)


def test_a_motion_that_begins_elsewhere_is_refused(executor_rig):
    trajectory = towards(executor_rig)
    moved = Trajectory(trajectory.names, trajectory.times, trajectory.positions + 0.4)
    before = executor_rig.port.state().position
    with pytest.raises(ExecutionAbortedError):
        executor_rig.wait(executor_rig.port.execute(moved)).result()
    assert executor_rig.port.state().position == pytest.approx(before, abs=0.02)


@pytest.mark.parametrize("how", ["cancel", "stop"])
def test_a_stopped_motion_ends_as_cancelled_and_the_joints_hold(executor_rig, how):
    trajectory = towards(executor_rig)
    operation = executor_rig.port.execute(trajectory)
    executor_rig.let_pass(0.5)
    operation.cancel() if how == "cancel" else executor_rig.port.stop()
    with pytest.raises(CanceledError):
        executor_rig.wait(operation).result()
    executor_rig.let_pass(0.3)
    held = executor_rig.port.state().position
    executor_rig.let_pass(0.5)
    assert executor_rig.port.state().position == pytest.approx(held, abs=0.01)
    assert np.abs(held - trajectory.positions[-1]).max() > 0.05


def test_stopping_at_rest_changes_nothing(executor_rig):
    before = executor_rig.port.state().position
    executor_rig.port.stop()
    executor_rig.port.stop()
    executor_rig.let_pass(0.2)
    assert executor_rig.port.state().position == pytest.approx(before, abs=0.01)


def test_a_motion_after_a_stop_begins_where_the_joints_are(executor_rig):
    first = executor_rig.port.execute(towards(executor_rig))
    executor_rig.let_pass(0.4)
    executor_rig.port.stop()
    executor_rig.wait(first)
    executor_rig.let_pass(0.3)
    second = executor_rig.wait(executor_rig.port.execute(towards(executor_rig))).result()
    names = executor_rig.port.joint_names
    assert second.ordered(names) == pytest.approx(executor_rig.goal.ordered(names), abs=0.02)


# --- those that can be steered ---


def ramp(names, begin, speed, hold, brake=0.2):
    """Evenly on with a speed for a while, and then to rest."""
    on, rest = np.linspace(0.0, hold, 21), np.linspace(0.0, brake, 11)[1:]
    way = np.concatenate([on, hold + rest - rest**2 / (2 * brake)])
    pace = np.concatenate([np.ones(21), 1 - rest / brake])
    times = np.concatenate([on, hold + rest])
    return Trajectory(names, times, begin + np.outer(way, speed), np.outer(pace, speed))


@pytest.fixture
def steered(executor_rig):
    """A rig whose executor can be steered, a motion of it, and what goes on with that from 0.4 s on."""
    if not isinstance(executor_rig.port, Steerable):
        pytest.skip("this executor's motions can't be changed while they are under way")
    rig, names = executor_rig, executor_rig.port.joint_names
    start = rig.port.state().ordered(names)
    speed = (rig.goal.ordered(names) - start) / 3.0
    first = ramp(names, start, speed, 0.4)
    return rig, first, ramp(names, first.at(0.4), speed, 0.6)


def test_a_motion_that_is_gone_on_with_does_not_stop_and_ends_once(steered):
    rig, first, tail = steered
    assert rig.port.passed() is None
    operation = rig.port.execute(first)
    rig.port.expect(0.4)
    rig.let_pass(0.2)
    passed = rig.port.passed()
    assert 0.0 < passed <= 0.4
    assert rig.port.amend(tail, 0.4)
    rig.port.expect(None)
    measured = rig.wait(operation).result()
    assert measured.ordered(tail.names) == pytest.approx(tail.positions[-1], abs=0.02)
    assert rig.port.passed() is None


def test_what_comes_too_late_or_jumps_changes_nothing(steered):
    rig, first, tail = steered
    operation = rig.port.execute(first)
    rig.let_pass(0.1)
    jump = Trajectory(tail.names, tail.times, tail.positions + 0.2, tail.velocities)
    with pytest.raises(Exception, match="rad away"):
        rig.port.amend(jump, 0.4)
    rig.let_pass(0.4)
    assert not rig.port.amend(tail, 0.4)
    measured = rig.wait(operation).result()
    assert measured.ordered(first.names) == pytest.approx(first.positions[-1], abs=0.02)
    assert not rig.port.amend(tail, 0.4)
