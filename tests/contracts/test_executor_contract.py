"""What every `ports.Executor` does."""

from __future__ import annotations

import numpy as np
import pytest
from on_the_way import begun, came, let_stand, towards

from grip_bt.base.failures import CanceledError, ExecutionAbortedError
from grip_bt.base.ports import Executor, Steerable
from grip_bt.base.values import Trajectory


def test_it_satisfies_the_protocol(executor_rig):
    assert isinstance(executor_rig.port, Executor)
    assert executor_rig.port.state().names == executor_rig.port.joint_names


def test_a_motion_ends_with_the_measured_state_near_its_last_point(executor_rig):
    trajectory = towards(executor_rig)
    measured = executor_rig.wait(executor_rig.port.execute(trajectory)).result()
    assert measured.names == trajectory.names
    assert measured.position == pytest.approx(trajectory.positions[-1], abs=0.02)
    assert executor_rig.port.state().position == pytest.approx(measured.position, abs=0.01)


def test_joints_are_on_their_way_in_the_middle_of_a_motion(executor_rig):
    trajectory, operation = begun(executor_rig)
    assert 0.04 < came(executor_rig, trajectory) < 0.96
    operation.cancel()
    executor_rig.wait(operation)


def test_a_motion_that_begins_elsewhere_is_refused(executor_rig):
    trajectory = towards(executor_rig)
    moved = Trajectory(trajectory.names, trajectory.times, trajectory.positions + 0.4)
    before = executor_rig.port.state().position
    with pytest.raises(ExecutionAbortedError):
        executor_rig.wait(executor_rig.port.execute(moved)).result()
    assert executor_rig.port.state().position == pytest.approx(before, abs=0.02)


def test_stopping_at_rest_changes_nothing(executor_rig):
    before = executor_rig.port.state().position
    executor_rig.port.stop()
    executor_rig.port.stop()
    executor_rig.let_pass(0.2)
    assert executor_rig.port.state().position == pytest.approx(before, abs=0.01)


def test_a_motion_after_a_stop_begins_where_the_joints_are(executor_rig):
    _, first = begun(executor_rig)
    executor_rig.port.stop()
    executor_rig.wait(first)
    let_stand(executor_rig)
    second = executor_rig.wait(executor_rig.port.execute(towards(executor_rig))).result()
    names = executor_rig.port.joint_names
    assert second.ordered(names) == pytest.approx(executor_rig.goal.ordered(names), abs=0.02)


def test_a_trajectory_of_other_joints_is_refused_and_nothing_moves(executor_rig):
    before = executor_rig.port.state().position
    for names in (("elsewhere",), (*executor_rig.port.joint_names[:-1], "elsewhere")):
        with pytest.raises(ValueError, match="elsewhere"):
            executor_rig.port.execute(Trajectory(names, np.array([0.0, 1.0]), np.zeros((2, len(names)))))
    assert executor_rig.port.state().position == pytest.approx(before, abs=0.01)


def test_a_second_motion_takes_the_place_of_the_first_which_ends_as_cancelled(executor_rig):
    first = executor_rig.port.execute(towards(executor_rig, 120.0))
    executor_rig.let_pass(0.3)
    assert not first.done()
    second = executor_rig.port.execute(towards(executor_rig, 1.0))
    with pytest.raises(CanceledError):
        executor_rig.wait(first).result()
    names = executor_rig.port.joint_names
    measured = executor_rig.wait(second).result()
    assert measured.ordered(names) == pytest.approx(executor_rig.goal.ordered(names), abs=0.02)


def test_what_is_cancelled_twice_or_after_its_end_ends_once(executor_rig):
    _, operation = begun(executor_rig)
    operation.cancel()
    operation.cancel()
    with pytest.raises(CanceledError):
        executor_rig.wait(operation).result()
    operation.cancel()
    executor_rig.port.stop()
    with pytest.raises(CanceledError):
        operation.result()


def test_what_the_other_side_gives_up_is_aborted_and_the_joints_hold(executor_rig):
    rig = executor_rig
    if rig.spoil is None:
        pytest.skip("nothing that this executor asks gives a motion up")
    rig.spoil()
    trajectory = towards(rig, 1.5)
    with pytest.raises(ExecutionAbortedError) as caught:
        rig.wait(rig.port.execute(trajectory)).result()
    assert caught.value.message
    let_stand(rig)
    held = rig.port.state().ordered(trajectory.names)
    assert np.abs(held - trajectory.positions[-1]).max() > 0.05
    rig.let_pass(0.5)
    assert rig.port.state().ordered(trajectory.names) == pytest.approx(held, abs=0.02)
    back = Trajectory(trajectory.names, np.array([0.0, 1.0]), np.stack([held, trajectory.positions[0]]))
    measured = rig.wait(rig.port.execute(back)).result()
    assert measured.ordered(back.names) == pytest.approx(back.positions[-1], abs=0.02)


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
    """A rig whose executor can be steered, a motion of it, from when on that is changed [s], and what it goes on with.

    Where time is the wall's, that is long after the change is asked for.
    """
    if not (isinstance(executor_rig.port, Steerable) and executor_rig.port.steerable):
        pytest.skip("this executor's motions can't be changed while they are under way")
    rig, names = executor_rig, executor_rig.port.joint_names
    at = 1.0 if rig.exact else 4.0
    start = rig.port.state().ordered(names)
    speed = (rig.goal.ordered(names) - start) / (3.0 * at)
    first = ramp(names, start, speed, at)
    return rig, first, at, ramp(names, first.at(at), speed, 0.6 * at)


def under_way(rig, motion):
    """Begin a motion, and return it when it is followed; that takes a moment where the controller is elsewhere."""
    operation = rig.port.execute_steered(motion)
    while not rig.port.passed():
        assert not operation.done()
        rig.let_pass(0.05)
    return operation


def test_a_motion_that_is_gone_on_with_does_not_go_back_and_ends_once(steered):
    rig, first, at, tail = steered
    assert rig.port.passed() is None
    operation = under_way(rig, first)
    assert 0.0 < rig.port.passed() <= at
    assert rig.port.amend(tail, at)
    column = int(np.abs(tail.positions[-1] - first.positions[0]).argmax())
    begin, end = first.positions[0][column], tail.positions[-1][column]
    where = []
    while not operation.done():
        where.append((rig.port.state().ordered(first.names)[column] - begin) / (end - begin))
        rig.let_pass(0.1)
    assert np.diff(where).min(initial=0.0) > -2e-3
    if rig.exact:  # else a change that comes late finds the joints at rest
        on_the_way = np.array([part for part in where if part < 0.9])
        assert (on_the_way[4:] - on_the_way[:-4]).min() > 0.01
    measured = rig.wait(operation).result()
    assert measured.ordered(tail.names) == pytest.approx(tail.positions[-1], abs=0.02)
    assert rig.port.passed() is None


def test_what_comes_too_late_or_jumps_changes_nothing(steered):
    rig, first, at, tail = steered
    operation = under_way(rig, first)
    jump = Trajectory(tail.names, tail.times, tail.positions + 0.2, tail.velocities)
    with pytest.raises(Exception, match="rad away"):
        rig.port.amend(jump, at)
    rig.let_pass(0.3)
    passed = 0.2  # a while ago, by now
    late = Trajectory(tail.names, tail.times, tail.positions - tail.positions[0] + first.at(passed), tail.velocities)
    assert not rig.port.amend(late, passed)
    measured = rig.wait(operation).result()
    assert measured.ordered(first.names) == pytest.approx(first.positions[-1], abs=0.02)
    assert not rig.port.amend(tail, at)


def test_a_stop_ends_a_motion_that_was_changed(steered):
    rig, first, at, tail = steered
    operation = under_way(rig, first)
    assert rig.port.amend(tail, at)
    rig.let_pass(0.2)
    rig.port.stop()
    with pytest.raises(CanceledError):
        rig.wait(operation).result()
    assert rig.port.passed() is None
    let_stand(rig)
    held = rig.port.state().ordered(first.names)
    rig.let_pass(0.5)
    assert rig.port.state().ordered(first.names) == pytest.approx(held, abs=0.01)
    assert np.abs(held - tail.positions[-1]).max() > 0.05
