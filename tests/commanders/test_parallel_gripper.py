"""Parallel grippers: the one that is written here, whose sizes are arguments, and the makers' with their linkages."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from grip_bt.base.errors import MissingPartError
from grip_bt.base.values import JointState
from grip_bt.cli.__main__ import main
from grip_bt.commanders.description import packages
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import build_robot, inspect_robot, load_robot
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.fingertips import spans_of
from grip_bt.commanders.kinematics.model import RobotModel, link_of
from grip_bt.commanders.scene import PlanningScene

WAYS = {
    "ur3_gripper": 0.138,
    "ur5_gripper": 0.138,
    "ur10_gripper": 0.138,
    "xarm7_gripper": 0.172,
    "ur3_robotiq": 0.14,
    "ur5_robotiq": 0.14,
    "ur10_robotiq": 0.14,
}
"""Arm with a gripper -> how far in front of the flange grasps are [m]."""


def placed(model, link, state):
    pin.framesForwardKinematics(model.model, model.data, model.configuration(state))
    return model.data.oMf[model.model.getFrameId(link)].copy()


@pytest.mark.parametrize("name", ["parallel_gripper", "xarm_gripper", "robotiq_2f_85", *WAYS])
def test_nothing_is_wrong_with_it(name, capsys):
    assert main(["robot", "check", name]) == 0
    assert capsys.readouterr().out.strip() == f"{name}: ok"


@pytest.mark.parametrize("name", WAYS)
def test_an_arm_with_it_is_free_at_home_and_knows_where_grasps_are(name):
    robot = load_robot(name)
    model = RobotModel(robot)
    home = robot.named_state("arm", "home")
    chain = model.chain("arm", robot.named_state("hand", "open"))
    assert not CollisionChecker(chain, PlanningScene({}).snapshot(), "hand").pairs(home.ordered(chain.joints))
    flange = robot.end_effectors[0].parent_link
    way = placed(model, flange, home).actInv(model.grasp_pose(home, group="arm").position)
    assert way == pytest.approx([0, 0, WAYS[name]], abs=1e-6)


@pytest.mark.parametrize("name", ["panda", "ur5_robotiq", "xarm7_gripper"])
def test_what_reaches_in_as_deep_as_is_told_meets_the_tips_alone(name):
    robot = load_robot(name)
    model, states = RobotModel(robot), robot.named_states["hand"]
    frame = model.grasp_frame_of("arm")
    tips = {links[-1] for links in robot.finger_links.values()}
    opened, closed = states["open"], states["closed"].position
    postures = [JointState(opened.names, opened.position + part * (closed - opened.position)) for part in (0.2, 0.5)]
    for span in spans_of(model, "hand", frame, postures):
        palm = placed(model, frame, span.posture)
        axes = np.stack([span.axis, np.cross(span.inward, span.axis), span.inward], axis=1)
        thing = palm * pin.SE3(axes, span.middle - span.depth / 2 * span.inward)
        box = coal.Box(span.gap - 1e-3, 0.04, span.depth)
        for shape in model.geometry.geometryObjects:
            link = link_of(model.model, shape)
            if link in robot.hand_links and link not in tips:
                there = model.data.oMi[shape.parentJoint] * shape.placement
                away = coal.distance(box, thing, shape.geometry, there, coal.DistanceRequest(), coal.DistanceResult())
                assert away > 0, f"{link} would touch what is {1000 * span.gap:.0f} mm wide"


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


def middle_and_gap(model, state, links):
    """Return the middle between two links' shapes in the grasp frame, and the gap between them [m]."""
    placed(model, links[0], state)
    shapes, palm = model.geometry, pin.SE3(model.grasp_pose(state).matrix())
    data = shapes.createData()
    pin.updateGeometryPlacements(model.model, model.data, shapes, data)
    found, frames = coal.DistanceResult(), model.model.frames
    ids = [next(k for k, g in enumerate(shapes.geometryObjects) if frames[g.parentFrame].name == n) for n in links]
    places = [coal.Transform3s(data.oMg[k].rotation, data.oMg[k].translation) for k in ids]
    one, other = (shapes.geometryObjects[k].geometry for k in ids)
    gap = coal.distance(one, places[0], other, places[1], coal.DistanceRequest(), found)
    middle = (found.getNearestPoint1() + found.getNearestPoint2()) / 2
    return palm.actInv(middle), gap


@pytest.mark.parametrize(
    ("name", "links", "stroke"),
    [
        ("xarm_gripper", ("left_finger", "right_finger"), 0.089),
        ("robotiq_2f_85", ("left_inner_finger_pad", "right_inner_finger_pad"), 0.086),
    ],
)
def test_the_linkages_of_the_makers_grippers_bring_their_fingers_together_at_the_grasp_frame(name, links, stroke):
    robot = load_robot(name)
    model = RobotModel(robot)
    _, opened = middle_and_gap(model, robot.named_state("hand", "open"), links)
    middle, closed = middle_and_gap(model, robot.named_state("hand", "closed"), links)
    assert opened == pytest.approx(stroke, abs=0.001)
    assert 0 < closed < 0.003
    assert middle[:2] == pytest.approx([0, 0], abs=0.02)
    assert -0.045 < middle[2] < 0.015, "along the pads, not behind them"


def test_an_argument_that_it_does_not_have_is_told():
    found = inspect_robot(RobotConfig(ready="parallel_gripper", arguments={"strok": 0.1})).findings
    assert any("strok" in finding.message for finding in found)


@pytest.mark.parametrize("name", ["panda_allegro", "ur5"])
def test_a_robot_without_arguments_says_so(name):
    (found,) = inspect_robot(RobotConfig(ready=name, arguments={"stroke": 0.1})).findings
    assert found.severity == "error"
    assert "takes no arguments" in found.message


@pytest.mark.parametrize("name", ["ur5", "ur5_robotiq", "xarm7_gripper", "panda_allegro"])
def test_a_robot_whose_models_are_not_installed_is_missed_with_what_to_install(name, without, capsys):
    without("example-robot-data")
    assert main(["robot", "check", name]) == 1
    said = capsys.readouterr()
    assert said.err.count("\n") == 1
    assert "Fix: pip install 'grip-bt[robots]'" in said.err
    with pytest.raises(MissingPartError, match=rf"robot {name!r}, in the package 'example-robot-data'"):
        load_robot(name)


def test_hands_that_come_with_us_need_no_package_and_say_their_licences(without, capsys):
    without("example-robot-data")
    for name in ("parallel_gripper", "xarm_gripper", "robotiq_2f_85", "shadow_left", "shadow_right"):
        assert main(["robot", "check", name]) == 0, capsys.readouterr()
    assert main(["robot", "list"]) == 0
    assert {"xarm7_gripper", "ur5_robotiq", "shadow_left"} <= set(capsys.readouterr().out.split())
    folder = packages.ROBOTS["shadow_left"].parent
    for models in (each for each in folder.iterdir() if each.is_dir()):
        assert (models / "LICENSE").is_file()
        assert f"`{models.name}`" in (folder / "LICENSES.md").read_text()


@pytest.fixture
def without(monkeypatch):
    """Return a function after whose call packages aren't found; what was built before is forgotten, and after."""

    def hide(*hidden):
        found = packages._installed
        monkeypatch.setattr(packages, "_installed", lambda name: None if name in hidden else found(name))
        monkeypatch.setattr(packages, "_in_ros", lambda name: None)
        build_robot.cache_clear()

    yield hide
    build_robot.cache_clear()
