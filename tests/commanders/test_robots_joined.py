import pickle
import xml.etree.ElementTree as ET
from dataclasses import fields

import numpy as np
import pytest
from robot_files import JOINTS, SRDF, urdf
from table_top import robot_model

from grip_bt.base.errors import InvalidRobotError
from grip_bt.base.failures import StartInCollisionError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.compose import KEYED
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import inspect_robot, load_robot
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import PlanTo, Situation
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.settings import PlanningSettings

NOTHING = PlanningScene({}).snapshot()


def test_every_field_of_a_robot_has_its_part_in_putting_robots_together():
    others = {"name", "urdf", "base_link", "grasp_frame", "disabled_pairs", "end_effectors"}
    assert {field.name for field in fields(RobotDescription)} == others | set(KEYED)


def test_robots_in_one_world_keep_their_own_colours_where_materials_share_a_name(tmp_path):
    config = {"name": "pair", "robots": {}}
    for name, colour in (("left", "1 0 0 1"), ("right", "0 0 1 1")):
        text = urdf().replace('">', f'"><material name="paint"><color rgba="{colour}"/></material>', 1)
        visual = '<visual><geometry><sphere radius="0.1"/></geometry><material name="paint"/></visual>'
        at = text.index("<inertial") if "<inertial" in text else text.index("<collision")
        (tmp_path / f"{name}.urdf").write_text(text[:at] + visual + text[at:])
        config["robots"][name] = {"robot": {"urdf": f"{name}.urdf"}}
    robot = load_robot(RobotConfig.model_validate(config), tmp_path)
    colours = [c.get("rgba") for c in ET.fromstring(robot.urdf).iterfind("link/visual/material/color")]
    assert colours == ["1 0 0 1", "0 0 1 1"]


@pytest.fixture
def two(tmp_path):
    """Two small arms, 0.8 m apart, and a group of both."""
    (tmp_path / "smally.urdf").write_text(urdf())
    (tmp_path / "smally.srdf").write_text(SRDF)
    one = {"urdf": "smally.urdf", "srdf": "smally.srdf"}
    config = {
        "name": "pair",
        "robots": {
            "left": {"robot": one, "xyz": [0, 0.4, 0]},
            "right": {"robot": one, "xyz": [0, -0.4, 0], "rpy": [0, 0, np.pi]},
        },
        "groups": {"arms": {"groups": ["left_manipulator", "right_manipulator"]}},
    }
    return load_robot(RobotConfig.model_validate(config), tmp_path)


def state(robot, group, positions):
    return JointState(robot.group(group), positions)


def never() -> bool:
    return False


def test_robots_in_one_world_keep_their_own_names_groups_states_and_frames(two):
    assert two.base_link == "world"
    assert two.group("left_manipulator") == tuple(f"left_{j}" for j in JOINTS)
    assert two.group("arms") == two.group("left_manipulator") + two.group("right_manipulator")
    assert two.named_state("right_gripper", "open").as_mapping() == {"right_slide_left": 0.04}
    assert two.mimics["left_slide_right"].joint == "left_slide_left"
    model = RobotModel(two)
    for side, y in (("left", 0.4), ("right", -0.4)):
        home = state(two, f"{side}_manipulator", np.zeros(6))
        assert np.allclose(model.grasp_pose(home, group=f"{side}_manipulator").position, (0, y, 1.08))
    bent = state(two, "right_manipulator", [0, np.pi / 2, 0, 0, 0, 0])
    turned = model.grasp_pose(bent, group="right_manipulator")
    assert np.allclose(turned.position, (-0.78, -0.4, 0.3)), "the right one looks backwards"
    assert pickle.loads(pickle.dumps(two)) == two


def test_one_arm_avoids_the_other_which_stands_where_it_was_said_to(two):
    model = RobotModel(two)
    towards = state(two, "left_manipulator", [-np.pi / 2, np.pi / 2, 0, 0, 0, 0])  # 0.78 m to the right
    away = state(two, "right_manipulator", [0, np.pi / 2, 0, 0, 0, 0])
    upright = state(two, "right_manipulator", np.zeros(6))
    for other, touches in ((upright, True), (away, True)):
        chain = model.chain("left_manipulator", other)
        assert bool(CollisionChecker(chain, NOTHING).pairs(towards.ordered(chain.joints))) == touches
    short = state(two, "left_manipulator", [np.pi / 2, np.pi / 2, 0, 0, 0, 0])
    assert not CollisionChecker(model.chain("left_manipulator", upright), NOTHING).pairs(short.position)


def test_two_hands_may_not_touch_one_another(two):
    model = RobotModel(two)
    meeting = {
        "left_manipulator": [-np.pi / 2, np.pi / 2, 0, 0, 0, 0],
        "right_manipulator": [-np.pi / 2, np.pi / 2, 0, 0, 0, 0],
    }
    chain = model.chain("arms")
    q = np.concatenate([state(two, g, positions).position for g, positions in meeting.items()])
    pairs = CollisionChecker(chain, NOTHING).pairs(JointState(two.group("arms"), q).ordered(chain.joints))
    assert any({a.split("_")[0], b.split("_")[0]} == {"left", "right"} for a, b in pairs)


def test_two_arms_are_planned_together_and_never_collide_on_the_way(two):
    """They swap sides: in straight lines of joints they would meet in the middle."""
    model = RobotModel(two)
    joints = two.group("arms")
    start = JointState(joints, [-0.9, 1.3, 0, 0, 0, 0, -0.9, -1.3, 0, 0, 0, 0])
    goal = JointState(joints, [-2.2, 1.3, 0, 0, 0, 0, -2.2, -1.3, 0, 0, 0, 0])
    chain = model.chain("arms")
    checker = CollisionChecker(chain, NOTHING)
    assert checker.free(start.ordered(chain.joints))
    assert checker.free(goal.ordered(chain.joints))
    begin = Situation("arms", start, NOTHING, "", PlanningSettings(seed=1, planning_time=600.0))
    plan = answer(model, PlanTo(begin, goal), never)
    assert set(plan.trajectory.names) == set(joints)
    path = np.array(plan.trajectory.positions)[:, [plan.trajectory.names.index(j) for j in chain.joints]]
    between = np.vstack([np.linspace(a, b, 20) for a, b in zip(path[:-1], path[1:], strict=True)])
    assert checker.all_free(between)
    assert np.allclose(plan.trajectory.end().ordered(joints), goal.position, atol=1e-3)


def test_one_arm_is_planned_apart_from_the_other(two):
    model = RobotModel(two)
    start = JointState(two.group("arms"), np.zeros(12))
    goal = state(two, "right_manipulator", [0.5, 0.6, 0, 0, 0, 0])
    begin = Situation("right_manipulator", start, NOTHING, "", PlanningSettings(seed=1, planning_time=600.0))
    plan = answer(model, PlanTo(begin, goal), never)
    assert set(plan.trajectory.names) == set(two.group("right_manipulator"))
    touching = JointState(two.group("arms"), [-np.pi / 2, np.pi / 2, 0, 0, 0, 0, *np.zeros(6)])
    begin = Situation("right_manipulator", touching, NOTHING, "", PlanningSettings(seed=1))
    with pytest.raises(StartInCollisionError):
        answer(model, PlanTo(begin, goal), never)


def test_a_ready_made_pair_has_a_group_of_both_arms_and_an_open_hand_each():
    robot = robot_model("two_ur5_allegro").description
    assert len(robot.group("arms")) == 12
    assert robot.opened("left_arm").names == robot.group("left_hand")
    assert set(robot.opened("arms").names) == {*robot.group("left_hand"), *robot.group("right_hand")}
    chain = robot_model("two_ur5_allegro").chain("arms")
    assert not CollisionChecker(chain, NOTHING).pairs(np.array([robot.at_rest.get(j, 0.0) for j in chain.joints]))


def test_a_hand_is_mounted_where_the_mount_says_and_takes_the_grippers_place():
    robot = robot_model("panda_allegro_left").description
    assert robot.groups.keys() == {"arm", "hand"}
    assert "panda_leftfinger" not in robot.urdf
    left, right = robot_model("panda_allegro_left"), robot_model("panda_allegro")
    q = JointState(robot.group("arm"), [0.1, 0.2, 0.3, -1.5, 0.4, 1.6, 0.5])
    assert np.allclose(left.grasp_pose(q).matrix(), right.grasp_pose(q).matrix(), atol=1e-9)


def test_a_mount_on_a_link_that_is_not_there_lists_those_that_are(tmp_path):
    config = {"arm": "ur5", "hand": "allegro_right", "mount": {"link": "tool1"}}
    found = inspect_robot(RobotConfig.model_validate(config), tmp_path).findings
    assert "unknown link 'tool1'; did you mean 'tool0'?" in str(found[-1])
    with pytest.raises(InvalidRobotError, match="tool1"):
        load_robot(RobotConfig.model_validate(config), tmp_path)


@pytest.mark.parametrize(
    ("config", "says"),
    [
        ({}, "exactly one of urdf, xacro, moveit, ready, arm, robots; this one has nothing"),
        ({"urdf": "a", "xacro": "b"}, "this one has urdf and xacro"),
        ({"arm": "ur5"}, "needs arm, hand and mount"),
        ({"urdf": "a", "drives": {"arm": {"stiffness": -1, "damping": 1, "limit": 1}}}, "greater than 0"),
        ({"urdf": "a", "states": {"arm": {"home": [float("nan")]}}}, "finite number"),
        ({"urdf": "a", "srfd": "b"}, "srfd"),
    ],
)
def test_a_configuration_that_makes_no_sense_is_refused(config, says):
    with pytest.raises(ValueError, match=says):
        RobotConfig.model_validate(config)


@pytest.mark.parametrize("name", ["panda_allegro", "ur5", "parallel_gripper"])
def test_what_is_said_beside_a_ready_made_robot_counts(name):
    own = load_robot(name)
    group, joints = next(iter(own.groups.items()))
    at = {joint: own.at_rest[joint] for joint in joints}
    said = {"accelerations": {group: 3.5}, "states": {group: {"nearly": at}}, "name": "mine"}
    made = load_robot(RobotConfig.model_validate({"ready": name, **said}))
    assert made.name == "mine"
    assert {made.acceleration_limits[joint] for joint in joints} == {3.5}
    assert made.named_states[group]["nearly"].as_mapping() == pytest.approx(at)
    assert set(made.named_states[group]) == {*own.named_states.get(group, {}), "nearly"}
    others = own.acceleration_limits.keys() - set(joints)
    assert {each: made.acceleration_limits[each] for each in others} == {e: own.acceleration_limits[e] for e in others}
