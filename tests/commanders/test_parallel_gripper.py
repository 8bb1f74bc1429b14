"""The parallel gripper that is written here: its sizes are arguments, and it sits on any arm."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from grip_bt.cli.__main__ import main
from grip_bt.commanders.collision import CollisionChecker
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import inspect_robot, load_robot
from grip_bt.commanders.model import RobotModel
from grip_bt.commanders.scene import PlanningScene
from grip_bt.values import JointState

ARMS = ("ur3_gripper", "ur5_gripper", "ur10_gripper", "xarm7_gripper")


def placed(model, link, state):
    pin.framesForwardKinematics(model.model, model.data, model.configuration(state))
    return model.data.oMf[model.model.getFrameId(link)].copy()


@pytest.mark.parametrize("name", ["parallel_gripper", *ARMS])
def test_nothing_is_wrong_with_it(name, capsys):
    assert main(["robot", "check", name]) == 0
    assert capsys.readouterr().out.strip() == f"{name}: ok"


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_with_it_is_free_at_home_and_knows_where_grasps_are(name):
    robot = load_robot(name)
    model = RobotModel(robot)
    home = robot.named_state("arm", "home")
    chain = model.chain("arm", robot.named_state("hand", "open"))
    assert not CollisionChecker(chain, PlanningScene({}).snapshot(), "hand").pairs(home.ordered(chain.joints))
    flange = robot.end_effectors[0].parent_link
    way = placed(model, flange, home).actInv(model.grasp_pose(home, group="arm").position)
    assert way == pytest.approx([0, 0, 0.138], abs=1e-6), "0.138 m in front of the flange"


def test_its_sizes_are_arguments():
    wide = load_robot(RobotConfig(ready="parallel_gripper", arguments={"stroke": 0.14, "finger_length": 0.1}))
    assert wide.named_state("hand", "open").as_mapping() == {"slide_left": pytest.approx(0.07)}
    assert RobotModel(wide).limits("hand").upper == pytest.approx([0.07])
    assert wide.mimics["slide_right"].joint == "slide_left"
    config = {"arm": "ur10", "hand": {"ready": "parallel_gripper", "arguments": {"stroke": 0.05}}}
    mounted = load_robot(RobotConfig.model_validate(config | {"mount": {"link": "tool0", "root": "palm"}}))
    assert mounted.named_state("hand", "open").as_mapping() == {"hand_slide_left": pytest.approx(0.025)}


def test_its_fingers_part_and_meet():
    robot = load_robot("parallel_gripper")
    model = RobotModel(robot)

    def gap(opening):
        state = JointState(("slide_left",), [opening])
        left, right = (placed(model, f"finger_{side}", state).translation for side in ("left", "right"))
        return float(np.linalg.norm(left - right)) - 0.012  # a finger's thickness

    assert gap(0.0) == pytest.approx(0.0)
    assert gap(0.0425) == pytest.approx(0.085)


def test_an_argument_that_it_does_not_have_is_told():
    found = inspect_robot(RobotConfig(ready="parallel_gripper", arguments={"strok": 0.1})).findings
    assert any("strok" in finding.message for finding in found)


@pytest.mark.parametrize("name", ["panda_allegro", "ur5"])
def test_a_robot_without_arguments_says_so(name):
    (found,) = inspect_robot(RobotConfig(ready=name, arguments={"stroke": 0.1})).findings
    assert found.severity == "error"
    assert "takes no arguments" in found.message
