import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from robot_files import JOINTS, SRDF, description_package, moveit_package, urdf

from grip_bt.app.project.folder import ProjectFile
from grip_bt.base.errors import InvalidRobotError, MissingPartError, UnknownNameError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.file_cache import noting_files
from grip_bt.commanders.description.load import inspect_robot, load_robot
from grip_bt.commanders.description.packages import Packages
from grip_bt.commanders.description.xml import expand
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.checks import chain_and_checker
from grip_bt.commanders.planning.requests import Situation
from grip_bt.commanders.scene_state import SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings


@pytest.fixture
def files(tmp_path):
    (tmp_path / "smally.urdf").write_text(urdf())
    (tmp_path / "smally.srdf").write_text(SRDF)
    return tmp_path


def test_a_urdf_and_its_srdf_make_a_robot(files):
    robot = load_robot(RobotConfig(urdf="smally.urdf", srdf="smally.srdf"), files)
    assert robot.name == "smally"
    assert robot.groups == {"manipulator": JOINTS, "gripper": ("slide_left",), "all": (*JOINTS, "slide_left")}
    assert robot.named_state("gripper", "open").as_mapping() == {"slide_left": 0.04}
    assert robot.hands["gripper"] == ("palm", "left", "right")
    assert robot.finger_links == {"left": ("left",), "right": ("right",)}
    (end,) = robot.end_effectors
    assert (end.group, end.parent_group, end.parent_link) == ("gripper", "manipulator", "l6")
    assert robot.grasp_frame.link == "l6"
    assert robot.disabled_pairs == {("l1", "l3")}
    assert robot.opened("manipulator").as_mapping() == {"slide_left": 0.04}


def test_a_joint_that_mimics_follows_and_belongs_to_no_group(files):
    robot = load_robot(RobotConfig(urdf="smally.urdf", srdf="smally.srdf"), files)
    model = RobotModel(robot)
    q = model.configuration(JointState(("slide_left",), [0.03]))
    assert "slide_right" not in robot.joints
    assert q[model._columns["slide_right"]] == 0.03


def test_the_robot_rests_in_its_named_states_and_the_grasp_frame_is_where_hand_computation_puts_it(files):
    model = RobotModel(load_robot(RobotConfig(urdf="smally.urdf", srdf="smally.srdf"), files))
    straight = model.grasp_pose(JointState(JOINTS, np.zeros(6)), group="manipulator")
    assert np.allclose(straight.position, (0, 0, 0.2 + 0.1 + 0.35 + 0.1 + 0.25 + 0.08))
    bent = model.grasp_pose(JointState(JOINTS, [0, np.pi / 2, 0, 0, 0, 0]), group="manipulator")
    assert np.allclose(bent.position, (0.35 + 0.1 + 0.25 + 0.08, 0, 0.3))
    assert model.description.at_rest["j3"] == 1.0


@pytest.mark.parametrize("ros", [1, 2])
def test_a_moveit_package_of_either_layout_makes_a_robot(tmp_path, ros):
    description_package(tmp_path)
    folder = moveit_package(tmp_path, ros)
    config = RobotConfig(moveit=str(folder))  # the package with the URDF lies beside it
    inspected = inspect_robot(config, tmp_path)
    assert [str(f) for f in inspected.findings if f.severity == "error"] == []
    (package,), robot = inspected.packages, inspected.description
    assert package.kinematics == {"manipulator": "kdl_kinematics_plugin/KDLKinematicsPlugin"}
    assert package.planners == {"manipulator": "RRTConnect"}
    assert package.sensors[0].topic == "/camera/points"
    assert robot.acceleration_limits["j1"] == 3.5
    assert robot.acceleration_limits["j3"] == pytest.approx(2.0 / 0.5)
    limits = RobotModel(robot).limits("manipulator")
    assert limits.velocity[:2].tolist() == [1.25, 2.0]
    assert limits.lower[1] == pytest.approx(-np.pi / 2)
    assert limits.upper[1] == 1.5
    if ros == 2:
        assert robot.at_rest["j2"] == 0.7


def test_what_becomes_of_a_moveit_packages_sensors_is_said_with_what_to_declare(tmp_path):
    description_package(tmp_path)
    (found,) = [f for f in inspect_robot(str(moveit_package(tmp_path, 2))).findings if f.code == "sensor-not-read"]
    assert found.severity == "warning"
    assert "plans don't avoid what camera sees by themselves" in found.message
    assert "`scene/add_cloud`" in found.message
    declared = yaml.safe_load(found.message.split("`")[1])
    file = ProjectFile.model_validate({"grip": 1, **declared})
    assert file.sensors["camera"].topics["seen"].topic == "/camera/points"
    assert file.sensors["camera"].given_in == "world"


def test_a_moveit_package_says_what_it_lacks_and_what_it_cannot_be_read_in(tmp_path):
    description_package(tmp_path)
    folder = moveit_package(tmp_path, 2)
    (folder / "config" / "kinematics.yaml").unlink()
    (folder / "config" / "joint_limits.yaml").write_text("joint_limits: {j1: {max_velocity: fast}}\n")
    (folder / "config" / "ompl_planning.yaml").write_text("a: [\n")
    inspected = inspect_robot(str(folder))
    assert inspected.description is not None
    found = inspected.findings
    assert {(f.severity, f.code) for f in found} == {
        ("warning", "sensor-not-read"),
        ("warning", "missing-file"),
        ("warning", "bad-file"),
    }
    told = "\n".join(map(str, found))
    assert "has no config/kinematics.yaml" in told
    assert "joint_limits/j1/max_velocity has to be a finite number, not 'fast'" in told
    assert "ompl_planning.yaml:2" in told


def test_arguments_reach_a_xacro_file_and_those_that_it_includes(tmp_path):
    package = description_package(tmp_path)
    groups = {"arm": {"joints": ["left_j1"]}}
    config = RobotConfig(
        xacro=str(package / "urdf" / "smally.urdf.xacro"), arguments={"prefix": "left_", "reach": 0.5}, groups=groups
    )
    robot = load_robot(config)
    assert robot.joints == ("left_j1",)
    assert RobotModel(robot).grasp_pose(group="arm").position.tolist() == [0, 0, 1.0]
    odd = inspect_robot(config.model_copy(update={"arguments": {"prefix": "left_", "raech": 1}}))
    assert "declares no argument 'raech'; did you mean 'reach'?" in str(odd.findings[0])


def test_what_a_package_that_is_not_here_would_give_is_left_out_and_told(tmp_path):
    package = description_package(tmp_path)
    file = package / "urdf" / "smally.urdf.xacro"
    more = '<xacro:include filename="$(find laser)/l.xacro"/><xacro:laser parent="base"/><xacro:include'
    file.write_text(file.read_text().replace("<xacro:include", more, 1))
    found = inspect_robot(RobotConfig(xacro=str(file)))
    assert found.description is not None
    told = [f.message for f in found.findings if f.code == "missing-package"]
    assert ["'laser' isn't available" in told[0], "macro xacro:laser" in told[1], len(told)] == [True, True, 2]
    file.write_text(file.read_text().replace("$(find laser)", str(tmp_path)))
    (error,) = inspect_robot(RobotConfig(xacro=str(file))).findings
    assert "No such file or directory" in error.message


def test_a_declaration_below_a_licence_is_read(tmp_path):
    (tmp_path / "r.urdf").write_text("<!-- a licence -->\n" + urdf())
    assert load_robot(str(tmp_path / "r.urdf")).groups["arm"] == JOINTS


def test_a_xacro_file_that_fails_says_why(tmp_path):
    path = tmp_path / "odd.xacro"
    start = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    for body, why in (
        ("<xacro:nothing/>", "nothing"),
        ('<link name="${1/0}"/>', "division by zero"),
        ('<xacro:include filename="${nowhere}/x.xacro"/>', "name 'nowhere' is not defined"),
        ('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>', "without end"),
        ("<link>", "mismatched tag"),
    ):
        path.write_text(f"{start}{body}</robot>")
        with pytest.raises(InvalidRobotError, match=why):
            load_robot(str(path))


@pytest.mark.parametrize(
    "start",
    [
        '<robot name="smally">',
        "<robot name='smally' xmlns:xacro='http://www.ros.org/wiki/xacro'>",
        '<robot\n name="smally" >',
    ],
)
def test_a_robots_name_is_read_by_a_parser_not_by_a_pattern(tmp_path, start):
    (tmp_path / "r.urdf").write_text(urdf().replace('<robot name="smally">', start))
    assert load_robot(RobotConfig(urdf="r.urdf"), tmp_path).name == "smally"


def test_packages_are_found_in_given_folders_in_ros_and_among_installed_ones(tmp_path, monkeypatch):
    prefix = tmp_path / "install"
    description_package(prefix / "share")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'other'}:{prefix}")
    here = tmp_path / "given"
    packages = Packages({"mine": here})
    assert packages.resolve("package://mine/a.stl", tmp_path) == here / "a.stl"
    assert packages.find("smally_description") == prefix / "share" / "smally_description"
    assert packages.find("example-robot-data").name == "example-robot-data"
    assert (packages.find("scipy") / "spatial").is_dir()
    own = Packages({}, (Path(__file__),)).find("grip_bt")
    assert (own / "commanders" / "robots").is_dir(), "also in a checkout, whose own package.xml is one folder higher"
    with pytest.raises(MissingPartError, match=r"package 'nowhere' isn't available.*`packages:` \(given: mine\)"):
        packages.find("nowhere")


def test_groups_states_and_frames_can_be_said_without_an_srdf(files):
    config = RobotConfig.model_validate(
        {
            "urdf": "smally.urdf",
            "groups": {"arm": {"chain": ["base", "l6"]}, "hand": {"joints": ["slide_left"]}},
            "end_effectors": {"hand": {"parent_link": "l6", "group": "hand"}},
            "states": {"arm": {"home": [0, 0.5, 1, 0, 1.2, 0]}, "hand": {"open": {"slide_left": 0.04}}},
            "grasp_frames": {"arm": {"link": "palm", "xyz": [0, 0, 0.09]}},
            "drives": {"arm": {"stiffness": 900, "damping": 90, "limit": 50}},
            "accelerations": {"arm": 5.0, "j1": 2.0},
            "namespace": "left",
        }
    )
    robot = load_robot(config, files)
    assert robot.groups["left_arm"] == tuple(f"left_{j}" for j in JOINTS)
    assert robot.drives["left_j2"].stiffness == 900
    assert (robot.acceleration_limits["left_j1"], robot.acceleration_limits["left_j2"]) == (2.0, 5.0)
    assert robot.grasp_frames["left_arm"].link == "left_palm"
    assert RobotModel(robot).grasp_pose(JointState(robot.groups["left_arm"], np.zeros(6)), group="left_arm").position[
        2
    ] == pytest.approx(1.08 + 0.07 + 0.09)


def test_a_configuration_that_names_what_is_not_there_is_told_all_of_it(files):
    config = RobotConfig.model_validate(
        {
            "urdf": "smally.urdf",
            "srdf": "smally.srdf",
            "grasp_frames": {"manipulator": {"link": "plam"}},
            "fingers": {"gripper": {"left": ["lefd"]}},
            "drives": {"arm": {"stiffness": 1, "damping": 1, "limit": 1}},
            "states": {"manipulator": {"odd": [1, 2]}},
        }
    )
    with pytest.raises(InvalidRobotError, match="lists 2 positions, and the group has 6 joints: j1, j2"):
        load_robot(config, files)
    with pytest.raises(InvalidRobotError) as error:
        load_robot(config.model_copy(update={"states": {}}), files)
    told = str(error.value)
    assert "grasp_frames/manipulator: there is no link 'plam'; did you mean 'palm'?" in told
    assert "there is no link 'lefd'; did you mean 'left'?" in told
    assert "drives: there is no group 'arm'" in told


def test_a_robot_that_is_no_file_and_not_ready_made_lists_those_that_are():
    with pytest.raises(UnknownNameError, match="did you mean 'panda'.*ur10_shadow"):
        load_robot("pandaa")
    with pytest.raises(InvalidRobotError, match="there is no such file"):
        load_robot("pandaa.urdf")


def test_a_robot_that_is_a_part_of_itself_is_refused(tmp_path):
    (tmp_path / "r.yaml").write_text("robots: {a: {robot: r.yaml}}\n")
    with pytest.raises(InvalidRobotError, match="contains itself"):
        load_robot("r.yaml", tmp_path)


def test_a_continuous_joint_turns_once_to_both_sides_and_a_driving_base_is_held(tmp_path):
    text = urdf().replace('name="j1" type="revolute"', 'name="j1" type="continuous"')
    text = text.replace('name="wrist_to_palm" type="fixed"', 'name="wrist_to_palm" type="floating"')
    (tmp_path / "r.urdf").write_text(text)
    (tmp_path / "r.srdf").write_text(SRDF.replace('type="fixed"', 'type="planar"'))
    inspected = inspect_robot(RobotConfig(urdf="r.urdf", srdf="r.srdf"), tmp_path)
    assert [f.code for f in inspected.findings] == ["held-joint", "held-joint"]
    assert RobotModel(inspected.description).limits("manipulator").upper[0] == pytest.approx(2 * np.pi)


def test_an_expanded_file_tells_which_files_it_was_made_of(tmp_path):
    xmlns = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    (tmp_path / "inner.xacro").write_text(f'<robot {xmlns}><link name="${{1 + 1}}"/></robot>')
    outer = tmp_path / "outer.xacro"
    outer.write_text(f'<robot name="r" {xmlns}><xacro:include filename="inner.xacro"/></robot>')
    with noting_files() as files:
        assert '<link name="2"/>' in expand(outer, {}, Packages())[0]
    assert {file.name for file in files} == {"outer.xacro", "inner.xacro"}


def test_a_robot_without_shapes_or_with_a_fixed_joint_called_as_its_link_can_be_planned_for(tmp_path):
    bare = re.sub("<collision>.*?</collision>", "", urdf()).replace('"wrist_to_palm"', '"palm"')
    (tmp_path / "r.urdf").write_text(bare)
    model = RobotModel(load_robot(str(tmp_path / "r.urdf")))
    situation = Situation("arm", JointState(JOINTS, np.zeros(6)), SceneSnapshot(), "", PlanningSettings())
    _, checker = chain_and_checker(model, situation)
    assert checker.free(np.zeros(6))
