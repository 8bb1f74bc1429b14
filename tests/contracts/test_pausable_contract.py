"""What every executor does that can be held in the middle of a motion: `ports.Executor` and `ports.Pausable`."""

from __future__ import annotations

import pytest
from on_the_way import begun, came, let_come, let_stand, towards

from grip_bt.base.failures import CanceledError
from grip_bt.base.ports import Executor, Pausable


def test_it_satisfies_both_protocols(pausable_rig):
    assert isinstance(pausable_rig.port, Executor)
    assert isinstance(pausable_rig.port, Pausable)


def test_a_motion_stands_still_in_the_middle_and_goes_on_to_its_end(pausable_rig):
    rig, trajectory = pausable_rig, towards(pausable_rig, 6.0)
    operation = rig.port.execute(trajectory)
    let_come(rig, trajectory, 0.1)
    rig.port.pause()
    rig.port.pause()
    let_stand(rig)
    assert 0.05 < came(rig, trajectory) < 0.95
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
        let_stand(rig)
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
    rig = pausable_rig
    _, operation = begun(rig)
    rig.port.pause()
    stood = let_stand(rig)
    operation.cancel() if how == "cancel" else rig.port.stop()
    with pytest.raises(CanceledError):
        rig.wait(operation).result()
    rig.port.resume()
    assert let_stand(rig) == pytest.approx(stood, abs=0.02)


def test_a_motion_that_is_asked_for_in_a_pause_waits_for_its_end(pausable_rig):
    rig, trajectory = pausable_rig, towards(pausable_rig)
    rig.port.pause()
    operation = rig.port.execute(trajectory)
    let_stand(rig)
    assert abs(came(rig, trajectory)) < 0.02
    assert not operation.done()
    rig.port.resume()
    assert rig.wait(operation).result().position == pytest.approx(trajectory.positions[-1], abs=0.02)
