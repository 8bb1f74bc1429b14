"""Whether a hand holds something: what each kind of evidence says, and how it is put together."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_perception_leaves import BEFORE, OTHER, PLACE, frame, thing

from grip_bt.base.values import JointState, Pose
from grip_bt.base.values.joints import Closing
from grip_bt.commanders.scene import PlanningScene
from grip_bt.nodes.evidence import Evidence, EvidenceLimits, fingers_evidence, holds, sight_evidence

NAMES = ("contact", "fingers", "sight", "image")


@pytest.mark.parametrize("says", list(product((True, False, None), repeat=4)))
def test_something_is_held_when_the_hand_or_the_sight_of_it_says_so_and_nothing_contradicts(says):
    evidence = [Evidence(name, held, "") for name, held in zip(NAMES, says, strict=True)]
    assert holds(evidence) == (True in says[:3] and False not in says)


def test_an_empty_place_alone_is_no_evidence():
    assert not holds([Evidence("image", True, "")])
    assert not holds([])


class Fingers:
    """A hand of joints that are somewhere."""

    def __init__(self, goal, reached, now, postures):
        self._now, self._postures = now, postures
        self._closing = None if goal is None else Closing(goal, reached)

    def closing(self):
        return self._closing

    def named_states(self):
        return self._postures

    def state(self):
        return self._now


def of(*positions):
    return JointState(tuple(f"f{k}" for k in range(len(positions))), positions)


def says(reached, now, empty=None, goal=(1.0, 1.0)):
    postures = {"open": of(0.0, 0.0), "closed": of(1.0, 1.0), **({} if empty is None else {"empty": of(*empty)})}
    return fingers_evidence(Fingers(of(*goal), of(*reached), of(*now), postures), EvidenceLimits()).held


@given(
    stopped=st.floats(0.1, 0.9),
    moved=st.floats(-0.04, 0.04),
    other=st.floats(0.1, 0.9),
)
def test_fingers_that_stay_where_something_stopped_them_say_yes(stopped, moved, other):
    assert says((stopped, other), (stopped + moved, other + moved))


@given(stopped=st.floats(0.1, 0.8), moved=st.floats(0.06, 0.19))
def test_fingers_that_have_moved_since_say_no_whichever_way_they_went(stopped, moved):
    assert says((stopped, stopped), (stopped + moved, stopped + moved)) is False
    assert says((stopped + moved, stopped + moved), (stopped, stopped)) is False


def test_fingers_that_close_all_the_way_say_no_and_so_do_those_that_end_as_an_empty_hand_does():
    assert says((1.0, 1.0), (1.0, 1.0)) is False
    assert says((0.7, 0.8), (0.7, 0.8), empty=(0.7, 0.8)) is False
    assert says((0.5, 0.8), (0.5, 0.8), empty=(0.7, 0.8)) is True


def test_fingers_that_were_not_closed_cannot_tell():
    hand = Fingers(None, None, of(0.5, 0.5), {"open": of(0.0, 0.0)})
    assert fingers_evidence(hand, EvidenceLimits()).held is None


# --- seen in the hand ---

HELD = Pose([0.5, 0.1, 0.3])


def scene(pose=HELD, size=(0.06, 0.06, 0.16)):
    made = PlanningScene({"hand": lambda: Pose()})
    made.set_box("held_hand", size, pose)
    made.attach("held_hand", "hand")
    return made


def depth_with(*things):
    return frame(*things).depth


def test_what_is_seen_where_the_hand_has_it_is_in_the_hand():
    there = depth_with((0.5, 0.1, 0.03, 0.03, 0.38, (205, 60, 45)))
    assert sight_evidence(there, scene(), "hand", []).held is True


def test_where_the_table_is_seen_instead_there_is_nothing_in_the_hand():
    one = sight_evidence(depth_with(), scene(), "hand", [])
    assert one.held is False
    assert "0%" in one.why


def test_what_the_robot_hides_or_is_out_of_the_view_cannot_be_told():
    assert sight_evidence(depth_with(), scene(Pose([0.5, -0.9, 0.3])), "hand", []).held is None
    palm = [np.array([[x, y, z] for x in (0.4, 0.6) for y in (0.0, 0.2) for z in (0.40, 0.45)])]
    hidden = depth_with((0.5, 0.1, 0.1, 0.1, 0.45, (50, 50, 50)))
    assert sight_evidence(hidden, scene(), "hand", palm).held is None
    assert sight_evidence(depth_with(), PlanningScene({"hand": Pose}), "hand", []).held is None


# --- the leaf ---


def held(world, tick, grasp_at, after=None, **more):
    frames = {} if after is None else {"before": BEFORE, "after": after}
    return tick(world.leaf("hand/holds", grasp=grasp_at(PLACE), **frames, **more))


def closed_on_something(world):
    world.hand.closed = Closing(JointState(("f",), [1.0]), JointState(("f",), [0.5]))
    world.hand.at = 0.5


def test_a_hand_that_feels_what_left_its_place_holds_it(world, tick, grasp_at):
    closed_on_something(world)
    assert held(world, tick, grasp_at, frame(OTHER)) == ("SUCCESS", "success", None)
    assert world.data["evidence"] == {"contact": True, "fingers": True, "sight": None, "image": True}


def test_what_fell_beside_the_view_is_not_held_although_its_place_is_empty(world, tick, grasp_at):
    """The image alone would say yes: nothing has appeared on the table."""
    closed_on_something(world)
    world.hand.touched, world.hand.at = {}, 1.0
    leaf = world.leaf("hand/holds", grasp=grasp_at(PLACE), before=BEFORE, after=frame(OTHER))
    assert tick(leaf)[2] == "not_held"
    assert "contact: no" in leaf.failure.message
    assert "fingers: no" in leaf.failure.message
    assert "against image" in leaf.failure.message


def test_a_hand_that_touches_something_else_does_not_hold_what_was_pushed_aside(world, tick, grasp_at):
    closed_on_something(world)
    assert held(world, tick, grasp_at, frame(thing(0.62, 0.1), OTHER))[2] == "not_held"


def test_without_frames_the_hand_alone_decides(world, tick, grasp_at):
    closed_on_something(world)
    assert held(world, tick, grasp_at)[0] == "SUCCESS"
    world.hand.touched = {}
    assert held(world, tick, grasp_at)[2] == "not_held"


def test_a_hand_that_can_tell_nothing_is_not_believed_for_its_image(world, tick, grasp_at):
    """A hand without a sense of touch that wasn't closed by this run, and an empty place."""
    world.hand.touched = {}
    assert held(world, tick, grasp_at, frame(OTHER), links=0)[0] == "SUCCESS", "no links are asked for"
    assert held(world, tick, grasp_at, frame(OTHER))[2] == "not_held"


# --- placing ---


def test_what_was_lost_on_the_way_is_not_placed(world, tick):
    """The hand is asked where it is going to let go; the arm stays there and the hand stays closed."""
    world.hold()
    world.hand.touched = {}
    leaf = world.leaf("arm/place", target="crate")
    assert tick(leaf) == ("FAILURE", "failure", "nothing_held")
    assert "lost on the way" in leaf.failure.message
    assert "open" not in world.hand.verbs()
    assert not [n for n in world.scene.names() if n.startswith("placed_")]


# --- nothing left ---


def test_what_is_left_is_told_with_its_place(world, tick):
    assert tick(world.leaf("scene/nothing_seen")) == ("SUCCESS", "success", None)
    world.stand("seen_0", (0.5, 0.1))
    world.stand("seen_1", (0.62, -0.05))
    leaf = world.leaf("scene/nothing_seen")
    assert tick(leaf) == ("FAILURE", "failure", "something_left")
    assert leaf.failure.message == "2 things are left, at (0.50, 0.10), (0.62, -0.05) [m]"
