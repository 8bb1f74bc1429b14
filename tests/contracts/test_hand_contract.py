"""What every `ports.Hand` does."""

from __future__ import annotations

import pytest

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NoContactError
from grip_bt.base.ports import Hand
from grip_bt.nodes.evidence import EvidenceLimits, hand_evidence, holds


def test_it_satisfies_the_protocol(hand_rig):
    assert isinstance(hand_rig.port, Hand)
    assert hand_rig.port.name


def test_closing_on_a_thing_succeeds_with_the_measured_state(hand_rig):
    hand_rig.offer()
    measured = hand_rig.wait(hand_rig.port.close(torque_limit=0.5)).result()
    assert set(measured.names) == set(hand_rig.closed.names)


def test_closing_on_nothing_fails_with_no_contact(hand_rig):
    with pytest.raises(NoContactError):
        hand_rig.wait(hand_rig.port.close()).result()


def test_opening_reaches_the_open_posture_from_anywhere(hand_rig):
    hand_rig.wait(hand_rig.port.close())
    measured = hand_rig.wait(hand_rig.port.open()).result()
    assert measured.ordered(hand_rig.open.names) == pytest.approx(hand_rig.open.position, abs=0.1)


def test_a_posture_can_be_given_instead_of_named(hand_rig):
    measured = hand_rig.wait(hand_rig.port.open(hand_rig.open)).result()
    assert measured.ordered(hand_rig.open.names) == pytest.approx(hand_rig.open.position, abs=0.1)


def test_an_unknown_posture_lists_those_that_exist(hand_rig):
    with pytest.raises(UnknownNameError, match="closed.*open"):
        hand_rig.port.open("opne")


def test_moving_to_a_posture_needs_no_contact(hand_rig):
    measured = hand_rig.wait(hand_rig.port.move("closed", torque_limit=0.5)).result()
    assert set(measured.names) == set(hand_rig.closed.names)
    assert {"open", "closed"} <= set(hand_rig.port.named_states())


def test_contacts_are_told_while_a_thing_is_held(hand_rig):
    assert not hand_rig.port.contacts()
    hand_rig.offer()
    hand_rig.wait(hand_rig.port.close(torque_limit=0.5)).result()
    assert all(force > 0 for force in hand_rig.port.contacts().values())
    assert hand_rig.port.contacts()


def test_closing_to_a_force_presses_with_that(hand_rig):
    hand_rig.offer()
    if hand_rig.regulates:
        hand_rig.wait(hand_rig.port.close(force=4.0)).result()
        both = hand_rig.port.contacts()
        assert sum(both.values()) / (2 if len(both) > 1 else 1) == pytest.approx(4.0, rel=0.15)
    else:
        with pytest.raises(ValueError, match="takes positions and no forces"):
            hand_rig.port.close(force=4.0)
    with pytest.raises(ValueError, match="not with both"):
        hand_rig.port.close(torque_limit=0.5, force=4.0)
    with pytest.raises(ValueError, match=r"force \[N\] is a positive number"):
        hand_rig.port.close(force=0.0)


def test_a_taught_posture_is_a_named_one(hand_rig):
    taught = hand_rig.port.teach("shown")
    assert hand_rig.port.named_states()["shown"] == taught


def test_how_it_closed_is_known_until_the_fingers_go_elsewhere(hand_rig):
    assert hand_rig.port.closing() is None
    hand_rig.offer()
    measured = hand_rig.wait(hand_rig.port.close(torque_limit=0.5)).result()
    closing = hand_rig.port.closing()
    assert closing.reached == measured
    assert closing.goal.ordered(hand_rig.closed.names) == pytest.approx(hand_rig.closed.position)
    hand_rig.wait(hand_rig.port.open())
    assert hand_rig.port.closing() is None


def test_what_is_taken_out_of_the_hand_is_told_by_the_hand(hand_rig):
    """Contact, fingers, or both: whatever the hand has to tell it by, nobody has to look."""
    if hand_rig.take is None:
        pytest.skip("its controller has given up pressing, and measures no effort: only a camera can tell")
    hand_rig.offer()
    hand_rig.wait(hand_rig.port.close(torque_limit=0.5)).result()
    assert holds(hand_evidence(hand_rig.port, EvidenceLimits()))
    hand_rig.take()
    hand_rig.let_pass(0.5)
    evidence = hand_evidence(hand_rig.port, EvidenceLimits())
    assert not holds(evidence), evidence
    assert any(one.held is False for one in evidence)


def test_what_has_closed_on_nothing_holds_nothing(hand_rig):
    with pytest.raises(NoContactError):
        hand_rig.wait(hand_rig.port.close()).result()
    assert not holds(hand_evidence(hand_rig.port, EvidenceLimits()))
