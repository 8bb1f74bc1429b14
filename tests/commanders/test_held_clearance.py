"""What a hand carries keeps the margin like the hand itself."""

import numpy as np
import pytest

from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.kinematics.collision import HELD_SLACK, CollisionChecker
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.scene import PlanningScene


@pytest.fixture(scope="module")
def model():
    return RobotModel(build_robot("panda_allegro"))


def free(model, gap, margin):
    """Tell whether a held post, 40 cm long, is free of a box whose face is `gap` [m] from its end."""
    home = model.description.named_state("arm", "home")
    hand = model.description.named_state("hand", "open")
    start = JointState(home.names + hand.names, np.concatenate([home.position, hand.position]))
    chain = model.chain("arm", start)
    grasp = model.grasp_pose(start)
    scene = PlanningScene({"hand": lambda: grasp})
    scene.set_box("post", [0.04, 0.04, 0.4], grasp @ Pose([0, 0, 0.4]))
    scene.attach("post", "hand")
    scene.set_box("wall", [0.1, 0.1, 0.1], grasp @ Pose([0, 0, 0.65 + gap]))
    return CollisionChecker(chain, scene.snapshot(), "hand", margin).free(home.ordered(chain.joints))


def test_without_a_margin_some_slack_is_taken_off_the_held_object(model):
    assert free(model, gap=-HELD_SLACK / 2, margin=0.0)
    assert not free(model, gap=-2 * HELD_SLACK, margin=0.0)


def test_with_a_margin_the_held_object_keeps_it_too(model):
    assert free(model, gap=0.012, margin=0.01)
    assert not free(model, gap=0.008, margin=0.01)
    assert not free(model, gap=0.0, margin=0.01)
