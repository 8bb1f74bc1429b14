"""What every `ports.HandPort` does."""

from __future__ import annotations

import numpy as np
import pytest
from on_the_way import SLOW, let_stand

from grip_bt.base.failures import CanceledError
from grip_bt.base.ports import HandPort


def position(rig):
    return rig.port.state().ordered(rig.open.names)


def test_it_satisfies_the_protocol(hand_port_rig):
    assert isinstance(hand_port_rig.port, HandPort)
    assert set(hand_port_rig.port.joint_names) == set(hand_port_rig.open.names)


def test_free_fingers_reach_their_posture_and_touch_nothing(hand_port_rig):
    measured = hand_port_rig.wait(hand_port_rig.port.move(hand_port_rig.closed, 1.0)).result()
    assert measured.ordered(hand_port_rig.closed.names) == pytest.approx(hand_port_rig.closed.position, abs=0.1)
    assert not hand_port_rig.port.contacts()


def test_fingers_stop_at_a_thing_and_the_motion_still_ends_well(hand_port_rig):
    hand_port_rig.offer()
    measured = hand_port_rig.wait(hand_port_rig.port.move(hand_port_rig.closed, 1.0, 0.5)).result()
    short = hand_port_rig.closed.position - measured.ordered(hand_port_rig.closed.names)
    assert np.abs(short).max() > 0.1
    contacts = hand_port_rig.port.contacts()
    assert contacts
    assert all(force > 0 for force in contacts.values())


def test_opening_lets_go(hand_port_rig):
    hand_port_rig.offer()
    hand_port_rig.wait(hand_port_rig.port.move(hand_port_rig.closed, 1.0))
    hand_port_rig.wait(hand_port_rig.port.move(hand_port_rig.open, 1.0))
    let_stand(hand_port_rig)
    assert position(hand_port_rig) == pytest.approx(hand_port_rig.open.position, abs=0.1)


@pytest.mark.parametrize("how", ["cancel", "stop"])
def test_stopped_fingers_hold(hand_port_rig, how):
    rig = hand_port_rig
    rig.slow_down()
    operation = rig.port.move(rig.closed, SLOW)
    began = position(rig)
    while np.abs(position(rig) - began).max() < 0.05:
        assert not operation.done()
        rig.let_pass(0.05)
    operation.cancel() if how == "cancel" else rig.port.stop()
    with pytest.raises(CanceledError):
        rig.wait(operation).result()
    let_stand(rig)
    held = position(rig)
    rig.let_pass(0.5)
    assert position(rig) == pytest.approx(held, abs=0.01)
    assert np.abs(held - rig.closed.ordered(rig.open.names)).max() > 0.2
