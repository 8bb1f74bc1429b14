"""What every executor does that can be held in the middle of a motion: `ports.Executor` and `ports.Pausable`."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.errors import CanceledError
from grip_bt.ports import Executor, Pausable
from grip_bt.values import Trajectory


def towards(rig, duration=1.0):
    names = rig.port.joint_names
    start, goal = rig.port.state().ordered(names), rig.goal.ordered(names)
    part = np.linspace(0, 1, 41)
    smooth = part * part * (3 - 2 * part)
    return Trajectory(names, part * duration, start + (goal - start) * smooth[:, None])


def came(rig, trajectory):
    """How much of the way the first joint has come, 0 to 1."""
    start, end = trajectory.positions[0][0], trajectory.positions[-1][0]
    return (rig.port.state().ordered(trajectory.names)[0] - start) / (end - start)


def let_come(rig, trajectory, part):
    """Let time pass until so much of the way is done."""
    passed = 0.0
    while came(rig, trajectory) < part:
        assert passed < 20.0, "the joints don't move"
        rig.let_pass(0.05)
        passed += 0.05


def let_stand(rig, trajectory):
    """Let time pass until the joints stand, and return how far they have come."""
    passed, before = 0.0, came(rig, trajectory)
    while True:
        rig.let_pass(0.3)
        now = came(rig, trajectory)
        if abs(now - before) < 1e-3:
            return now
        before, passed = now, passed + 0.3
        assert passed < 20.0, "the joints don't stand"


def test_it_satisfies_both_protocols(pausable_rig):
    assert isinstance(pausable_rig.port, Executor)
    assert isinstance(pausable_rig.port, Pausable)


def test_a_motion_stands_still_in_the_middle_and_goes_on_to_its_end(pausable_rig):
    rig, trajectory = pausable_rig, towards(pausable_rig, 2.0)
    operation = rig.port.execute(trajectory)
    let_come(rig, trajectory, 0.1)
    rig.port.pause()
    rig.port.pause()
    stood = let_stand(rig, trajectory)
    assert 0.05 < stood < 0.95
    assert not operation.done()
    rig.port.resume()
    rig.port.resume()
    measured = rig.wait(operation).result()
    assert measured.position == pytest.approx(trajectory.positions[-1], abs=0.02)


def test_it_may_be_held_again_and_again(pausable_rig):
    rig, trajectory = pausable_rig, towards(pausable_rig, 1.5)
    operation = rig.port.execute(trajectory)
    for part in (0.1, 0.3, 0.5):
        let_come(rig, trajectory, part)
        rig.port.pause()
        let_stand(rig, trajectory)
        rig.port.resume()
    assert rig.wait(operation).result().position == pytest.approx(trajectory.positions[-1], abs=0.02)


def test_a_short_pause_loses_nothing(pausable_rig):
    rig, trajectory = pausable_rig, towards(pausable_rig)
    operation = rig.port.execute(trajectory)
    rig.let_pass(0.3)
    rig.port.pause()
    rig.port.resume()
    rig.port.pause()
    rig.port.resume()
    assert rig.wait(operation).result().position == pytest.approx(trajectory.positions[-1], abs=0.02)


@pytest.mark.parametrize("how", ["cancel", "stop"])
def test_a_held_motion_can_be_stopped_and_stays_where_it_is(pausable_rig, how):
    rig, trajectory = pausable_rig, towards(pausable_rig)
    operation = rig.port.execute(trajectory)
    let_come(rig, trajectory, 0.1)
    rig.port.pause()
    stood = let_stand(rig, trajectory)
    operation.cancel() if how == "cancel" else rig.port.stop()
    with pytest.raises(CanceledError):
        rig.wait(operation).result()
    rig.port.resume()
    assert let_stand(rig, trajectory) == pytest.approx(stood, abs=0.02)


def test_a_motion_that_is_asked_for_in_a_pause_waits_for_its_end(pausable_rig):
    rig, trajectory = pausable_rig, towards(pausable_rig)
    rig.port.pause()
    operation = rig.port.execute(trajectory)
    assert abs(let_stand(rig, trajectory)) < 0.02
    assert not operation.done()
    rig.port.resume()
    assert rig.wait(operation).result().position == pytest.approx(trajectory.positions[-1], abs=0.02)
