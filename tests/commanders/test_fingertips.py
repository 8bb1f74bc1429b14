"""A hand's posture from where its fingertips shall be."""

import numpy as np
import pytest
from table_top import named, robot_model

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NoIkError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.description.tree import joints_of_fingers
from grip_bt.commanders.kinematics.fingertips import TOLERANCE, _tips, fingertip_posture, spans_of
from grip_bt.commanders.kinematics.model import RobotModel


def fingertip_positions(model, hand, names=None, frame="grasp"):
    """Where fingertips, or other links of the hand, are in a frame of its palm [m]."""
    names = tuple(model.description.finger_links if names is None else names)
    return dict(zip(names, _tips(model, names, "hand", frame)(model.configuration(hand))[0], strict=True))


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


@pytest.mark.parametrize("name", ["panda_allegro", "panda_allegro_left"])
def test_a_hand_that_squeezes_presses_straight_and_its_fingers_as_hard_as_its_thumb(name):
    """The work of the joints' torques, when one tip alone moves along the axis by a mm, tells its force."""
    robot = load_robot(name)
    model, states = RobotModel(robot), robot.named_states["hand"]
    opened, closed = states["pinch_open"], states["pinch_closed"]
    ways = np.linspace(opened.position, closed.ordered(opened.names), 7)[1:-1]
    for span in spans_of(model, "hand", model.grasp_frame_of("arm"), [JointState(opened.names, way) for way in ways]):
        drives = [robot.drives[joint] for joint in opened.names]
        off = span.squeezing.position - span.posture.position
        torque = off * [drive.stiffness for drive in drives]
        assert np.abs(torque / [drive.limit for drive in drives]).max() == pytest.approx(1.0)
        pressed = {}
        for finger, joints in joints_of_fingers(robot, "hand").items():
            mine = np.isin(opened.names, joints)
            if np.abs(torque[mine]).max() > 1e-6:
                tip = fingertip_positions(model, span.posture, [finger], model.grasp_frame_of("arm"))[finger]
                sign = 1.0 if finger == "thumb" else -1.0
                moved = tip + 1e-3 * sign * span.axis
                there = fingertip_posture(model, {finger: moved}, span.posture, frame=model.grasp_frame_of("arm"))
                pressed[finger] = torque @ (there.ordered(opened.names) - span.posture.position) / 1e-3
        thumb = pressed.pop("thumb")
        assert len(pressed) >= 2
        assert thumb > 10
        assert sum(pressed.values()) == pytest.approx(thumb, rel=0.35)
        assert max(pressed.values()) < 0.75 * thumb


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_shadows_thumb_presses_against_three_fingers_and_not_against_the_first_alone(side):
    """What it holds would turn about the line between the two. Its fingers are alike, so their roots' torques tell."""
    robot = load_robot(f"shadow_{side}")
    model, states = RobotModel(robot), robot.named_states["hand"]
    opened, closed = states["pinch_open"], states["pinch_closed"]
    ways = np.linspace(opened.position, closed.ordered(opened.names), 7)[1:-1]
    for span in spans_of(model, "hand", model.grasp_frame_of("hand"), [JointState(opened.names, w) for w in ways]):
        off = dict(zip(opened.names, span.squeezing.position - span.posture.position, strict=True))
        presses = np.array([off[f"{side[0]}h_{finger}J3"] for finger in ("FF", "MF", "RF")])
        assert (presses / presses.sum()).max() < 0.5
        assert (presses / presses.sum()).min() > 0.15


def test_what_is_between_fingers_is_measured_once_for_each_posture_and_is_that_of_a_new_model(model, monkeypatch):
    monkeypatch.setattr("grip_bt.commanders.kinematics.fingertips._KEPT", 5)
    states = model.description.named_states["hand"]
    opened, closed = states["open"], states["closed"]
    way = [JointState(opened.names, row) for row in np.linspace(opened.position, closed.ordered(opened.names), 4)]
    frame = model.grasp_frame_of("arm")
    first = spans_of(model, "hand", frame, way)
    again = spans_of(model, "hand", frame, way[2:])
    assert all(one is other for one, other in zip(again, first[2:], strict=True))
    assert first == spans_of(RobotModel(model.description), "hand", frame, way)
    assert first == spans_of(model, "hand", frame, [*way, *reversed(way)])[:4]
    spans_of(model, "hand", frame, [closed, *way[:-1], way[1]])
    assert len(model.spans) <= 5
