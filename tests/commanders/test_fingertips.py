"""A hand's posture from where its fingertips shall be."""

import numpy as np
import pytest
from table_top import named, robot_model

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NoIkError
from grip_bt.base.values import JointState
from grip_bt.commanders.kinematics.fingertips import TOLERANCE, _Tips, fingers_of, fingertip_posture


def fingertip_positions(model, hand, names=None, frame="grasp"):
    """Where fingertips, or other links of the hand, are in a frame of its palm [m]."""
    tips = _Tips(model, tuple(fingers_of(model, "hand") if names is None else names), "hand", frame)
    return dict(zip(tips.fingers, tips.places(model.configuration(hand)), strict=True))


@pytest.fixture(scope="module")
def model():
    return robot_model()


def random_posture(model, rng):
    limits = model.limits("hand")
    return JointState(model.description.group("hand"), rng.uniform(limits.lower, limits.upper))


def test_tips_that_a_posture_has_are_reached_by_all_fingers_together(model):
    rng = np.random.default_rng(0)
    limits = model.limits("hand")
    for _ in range(20):
        wanted = fingertip_positions(model, random_posture(model, rng))
        posture = fingertip_posture(model, wanted)
        reached = fingertip_positions(model, posture)
        assert all(np.linalg.norm(reached[name] - wanted[name]) < TOLERANCE for name in wanted)
        assert (posture.position >= limits.lower - 1e-9).all()
        assert (posture.position <= limits.upper + 1e-9).all()


def test_fingers_that_are_not_asked_for_stay(model):
    opened = named(model, "hand", "open")
    target = fingertip_positions(model, opened)["index"] + [-0.01, 0.0, -0.01]
    posture = fingertip_posture(model, {"index": target}, seed=opened)
    moved = {name for name, a, b in zip(posture.names, posture.position, opened.position, strict=True) if a != b}
    assert moved
    assert moved <= {f"hand_joint_{k}.0" for k in range(4)}


def test_a_posture_near_its_seed_stays_near_and_the_same_question_has_the_same_answer(model):
    opened = named(model, "hand", "open")
    tips = fingertip_positions(model, opened)
    targets = {name: tip - [0.0, 0.0, 0.003 * (name != "thumb")] for name, tip in tips.items()}
    one, other = (fingertip_posture(model, targets, seed=opened) for _ in range(2))
    assert np.abs(one.position - opened.position).max() < 0.3
    assert np.array_equal(one.position, other.position)


def test_the_arm_does_not_matter(model):
    targets = fingertip_positions(model, named(model, "hand", "closed"))
    assert targets["thumb"].shape == (3,)
    assert np.linalg.norm(targets["thumb"]) < 0.2


def test_what_a_finger_cannot_reach_is_told_by_finger(model):
    targets = fingertip_positions(model, named(model, "hand", "open")) | {"thumb": np.array([0.0, 0.0, 0.5])}
    with pytest.raises(NoIkError, match=r"thumb stays \d+ mm away") as caught:
        fingertip_posture(model, targets)
    assert set(caught.value.data["distances"]) == {"thumb"}


def test_an_unknown_finger_lists_those_that_exist(model):
    with pytest.raises(UnknownNameError, match="index, middle, ring, thumb"):
        fingertip_posture(model, {"pinky": np.zeros(3)})


def test_any_link_that_the_fingers_move_may_be_placed(model):
    closed = named(model, "hand", "closed")
    knuckle = "hand_link_2.0"
    wanted = fingertip_positions(model, closed, ["thumb", knuckle])
    reached = fingertip_positions(model, fingertip_posture(model, wanted), wanted)
    assert all(np.linalg.norm(reached[name] - wanted[name]) < TOLERANCE for name in wanted)


def test_positions_may_be_given_in_a_link_of_the_palm(model):
    closed = named(model, "hand", "closed")
    palm = fingertip_positions(model, closed, frame="hand_palm_link")
    grasp = fingertip_positions(model, closed)
    assert np.linalg.norm(palm["thumb"] - grasp["thumb"]) > 0.005
    posture = fingertip_posture(model, palm, frame="hand_palm_link")
    reached = fingertip_positions(model, posture)
    assert all(np.linalg.norm(reached[name] - grasp[name]) < TOLERANCE for name in grasp)


@pytest.mark.parametrize("frame", ["hand_link_1.0", "panda_link3", "nowhere"])
def test_a_frame_that_is_not_fixed_to_the_palm_is_refused(model, frame):
    with pytest.raises(UnknownNameError, match="hand_palm_link"):
        fingertip_posture(model, {"thumb": np.zeros(3)}, frame=frame)


def test_a_link_that_the_fingers_do_not_move_is_refused(model):
    with pytest.raises(UnknownNameError, match="finger or link of the hand"):
        fingertip_posture(model, {"hand_palm_link": np.zeros(3)})
