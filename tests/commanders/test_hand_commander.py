"""The hand commander's verbs beyond opening and closing: postures, fingers, synergies, teaching."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NameTakenError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.fake import FakeExecutor, FakeHand
from grip_bt.commanders.hand import AT_GOAL_TIME, OPENING_TIME, HandCommander, Synergies
from grip_bt.commanders.taught import TaughtStates

FINGERS = {"index": ("joint_0.0", "joint_1.0"), "thumb": ("joint_12.0", "joint_13.0")}
STATES = build_robot("panda_allegro").named_states["hand"]
PREFIX = STATES["open"].names[0].removesuffix("joint_0.0")
FINGERS = {finger: tuple(PREFIX + joint for joint in joints) for finger, joints in FINGERS.items()}


@pytest.fixture
def port():
    return FakeHand(STATES["open"])


@pytest.fixture
def hand(port):
    return HandCommander("right", port, STATES, fingers=FINGERS)


def test_moving_goes_to_a_named_posture_and_leaves_out_what_a_posture_does_not_name(hand):
    hand.move("flat").result()
    assert hand.state().position == pytest.approx(STATES["flat"].ordered(hand.state().names))
    part = JointState(FINGERS["thumb"][:1], [0.4])
    measured = hand.move(part).result().as_mapping()
    assert measured[FINGERS["thumb"][0]] == pytest.approx(0.4)
    assert measured[FINGERS["index"][1]] == pytest.approx(STATES["flat"].as_mapping()[FINGERS["index"][1]])


def test_moving_passes_the_torque_limit_on_and_refuses_what_is_no_limit(hand, port):
    hand.move("closed", torque_limit=0.3)
    assert port.torque_limits == [0.3]
    with pytest.raises(ValueError, match="positive"):
        hand.move("closed", torque_limit=-1.0)
    with pytest.raises(ValueError, match="positive"):
        hand.move("closed", seconds=np.nan)


def test_opening_takes_its_time_but_not_where_the_hand_is_open_already():
    moved = FakeExecutor(STATES["closed"])
    hand = HandCommander("right", FakeHand(STATES["closed"], executor=lambda _: moved), STATES, fingers=FINGERS)
    hand.open().result()
    hand.open().result()
    assert [way.duration for way in moved.executed] == [OPENING_TIME, AT_GOAL_TIME]
    hand.move(JointState(FINGERS["thumb"][:1], [0.4])).result()  # one joint is elsewhere
    hand.open().result()
    assert moved.executed[-1].duration == OPENING_TIME


def test_one_finger_closes_half_way_between_open_and_closed_and_the_others_stay(hand):
    measured = hand.move(hand.finger_posture({"index": 0.5})).result().as_mapping()
    opened, closed = STATES["open"].as_mapping(), STATES["closed"].as_mapping()
    for joint in FINGERS["index"]:
        assert measured[joint] == pytest.approx((opened[joint] + closed[joint]) / 2)
    for joint in FINGERS["thumb"]:
        assert measured[joint] == pytest.approx(opened[joint])


def test_an_unknown_finger_lists_the_fingers_and_a_share_is_between_0_and_1(hand):
    with pytest.raises(UnknownNameError, match="index, thumb"):
        hand.finger_posture({"indx": 0.5})
    with pytest.raises(ValueError, match="0 to 1"):
        hand.finger_posture({"index": 1.5})


def test_synergies_span_the_postures_that_made_them():
    synergies = Synergies.of(STATES.values())
    assert len(synergies.directions) == len(STATES) - 1
    for posture in STATES.values():
        weights = synergies.directions @ (posture.ordered(synergies.names) - synergies.middle)
        weights /= (synergies.directions**2).sum(axis=1)
        assert np.abs(weights).max() <= 1 + 1e-9
        assert synergies.posture(weights).position == pytest.approx(posture.ordered(synergies.names))


def test_the_first_synergy_explains_most_and_a_positive_weight_flexes():
    synergies = Synergies.of(STATES.values())
    lengths = np.linalg.norm(synergies.directions, axis=1)
    assert (np.diff(lengths) <= 1e-9).all() or lengths[0] > 0
    assert synergies.directions[0].sum() > 0
    assert synergies.directions @ synergies.directions.T == pytest.approx(np.diag(lengths**2), abs=1e-9)


def test_a_hand_moves_by_synergies_and_stays_within_its_limits(port):
    low = {name: (0.0, 0.1) for name in STATES["open"].names}
    hand = HandCommander("right", port, STATES, limits=low)
    assert hand.synergy([5.0]).position.max() <= 0.1
    free = HandCommander("right", port, STATES)
    assert free.synergy([]).position == pytest.approx(np.mean([s.position for s in STATES.values()], axis=0))
    with pytest.raises(ValueError, match=f"at most {len(STATES) - 1}"):
        free.synergy([0] * len(STATES))


def test_a_taught_posture_is_a_named_one_also_in_the_next_run(port, tmp_path):
    file = tmp_path / "taught.yaml"
    hand = HandCommander("right", port, STATES, taught=TaughtStates(file))
    hand.move("flat")
    hand.teach("halt")
    again = HandCommander("right", port, STATES, taught=TaughtStates(file))
    assert again.named_states()["halt"].position.tolist() == hand.state().position.tolist()
    assert again.move("halt").result().position == pytest.approx(STATES["flat"].position)
    with pytest.raises(NameTakenError, match="closed"):
        hand.teach("closed")
