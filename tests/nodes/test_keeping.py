"""What a motion keeps to is said in a task, refused where it is wrong, and held by the arm."""

from __future__ import annotations

import re

import numpy as np
import pytest

from grip_bt.base.values import PathConstraint, Pose
from grip_bt.commanders.fake import FakeArm
from grip_bt.nodes.motion import read_keep

TURNED = Pose((0.3, -0.4, 0.5), (0.8, 0.6, 0.0, 0.0))


def about(axis, angle):
    return Pose(quaternion=[np.cos(angle / 2), *(np.sin(angle / 2) * np.eye(3)["xyz".index(axis)])])


def test_now_is_the_orientation_that_the_hand_has():
    made = read_keep({"orientation": "now"}, TURNED)
    assert made == PathConstraint(Pose(quaternion=TURNED.quaternion), (0.1, 0.1, np.inf))
    assert made.kept_by(about("z", 2.0) @ TURNED)
    assert not made.kept_by(about("x", 0.2) @ TURNED)


def test_tolerances_about_own_axes_turn_with_the_orientation():
    own = read_keep({"orientation": [0.8, 0.6, 0.0, 0.0], "tolerance": [0.1, 0.1, "free"], "axes": "own"}, Pose())
    assert own.kept_by(TURNED @ about("z", 2.0))
    assert not own.kept_by(about("z", 0.5) @ TURNED)


def test_a_box_bounds_the_origin_in_its_own_attitude():
    box = {
        "position": [1.0, 0.0, 0.5],
        "size": [2.0, 0.2, 0.2],
        "quaternion": about("z", np.pi / 2).quaternion.tolist(),
    }
    made = read_keep({"box": box}, Pose())
    assert made.kept_by(Pose((1.0, 0.9, 0.5)))
    assert not made.kept_by(Pose((1.9, 0.0, 0.5)))


@pytest.mark.parametrize(
    ("keep", "words"),
    [
        ({"orientaton": "now"}, "unknown key 'orientaton' in keep; did you mean 'orientation'"),
        ({"tolerance": [1, 1, 1]}, "an `orientation`, a `box` or both"),
        ({"box": {"position": [0, 0, 0], "size": [1, 1, 1]}, "axes": "own"}, "belong to an `orientation`"),
        ({"orientation": "here"}, "not 'here' (it is {orientation: now or [w, x, y, z]"),
        ({"orientation": [1, 0, 0]}, "(it is {orientation: now or [w, x, y, z]"),
        ({"orientation": "now", "tolerance": [0.1, 0.1]}, "tolerance: [3 angles"),
        ({"orientation": "now", "tolerance": [0.1, 0.1, "any"]}, "not 'any' (it is"),
        ({"orientation": "now", "tolerance": [0.1, 0.1, 0]}, "3 positive numbers"),
        ({"orientation": "now", "axes": "mine"}, "'world' or 'own', not 'mine'"),
        ({"box": {"position": [0, 0, 0]}}, "the key 'size' is missing"),
        ({"box": {"position": [0, 0, 0], "size": [1, 1, -1]}}, "3 positive numbers"),
        ({"box": {"position": [0, 0, 0], "size": [1, 1, 1], "centre": 1}}, "unknown key 'centre' in box"),
    ],
)
def test_what_is_said_wrongly_is_refused_with_what_is_allowed(keep, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        read_keep(keep, Pose())


def test_a_wrong_keep_is_found_before_the_run_at_its_node(world):
    with pytest.raises(ValueError, match=r"leaf: keep: .*did you mean 'orientation'"):
        world.leaf("arm/move_to", state="home", keep={"orientatio": "now"})


def test_it_is_said_once(world):
    bound = PathConstraint(box=Pose(), size=(1, 1, 1))
    with pytest.raises(ValueError, match="either `with: {keep: ...}` or `in: {constraint: ...}`"):
        world.leaf("arm/move_to", state="home", keep={"orientation": "now"}, constraint=bound)


def test_now_is_refused_for_a_plan_that_begins_elsewhere(world):
    with pytest.raises(ValueError, match="begins at a given `start`"):
        world.leaf("arm/plan", state="home", keep={"orientation": "now"}, start=world.arm.state())


@pytest.mark.parametrize(
    ("node", "fields"),
    [
        ("arm/move_to", {"state": "home"}),
        ("arm/plan", {"state": "home"}),
        ("arm/move_to_pose", {"pose": Pose((0.4, 0, 0.4))}),
    ],
)
def test_motions_hand_it_to_the_arm(world, node, fields):
    leaf = world.leaf(node, keep={"orientation": "now"}, **fields)
    leaf.tick_once()
    assert world.arm.constraint == PathConstraint(Pose(quaternion=world.arm.grasp_pose().quaternion))
    bound = PathConstraint(box=Pose((0, 0, 1)))
    leaf = world.leaf(node, constraint=bound, **fields)
    leaf.tick_once()
    assert world.arm.constraint == bound


def test_one_constraint_serves_several_motions(world):
    leaf = world.leaf("arm/constraint", keep={"orientation": "now", "tolerance": [0.2, 0.2, 0.2]})
    leaf.tick_once()
    assert world.data["constraint"].tolerance == (0.2, 0.2, 0.2)


@pytest.mark.parametrize("end", ["start", "goal"])
def test_a_fake_arm_refuses_ends_that_break_it(end):
    arm = FakeArm(home=Pose((0.3, 0, 0.5)))
    low = Pose((0.3, 0, 0.1))
    box = PathConstraint(box=low if end == "start" else arm.grasp_pose(), size=(0.1, 0.1, 0.1))
    failure = arm.plan(low, constraint=box)
    with pytest.raises(Exception, match=f"the {end} violates") as caught:
        failure.result()
    assert caught.value.code == "constraint_broken"
