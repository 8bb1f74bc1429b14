"""Configuration packages as vendors lay them out: who finds the URDF, the SRDF, the arguments and the limits."""

import pytest
from robot_files import LIMITS, SRDF, urdf

from grip_bt.app.project.new_robot import new_robot
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.configurations import configured_packages
from grip_bt.commanders.description.hints import hints_of
from grip_bt.commanders.description.load import config_of, inspect_robot, load_robot
from grip_bt.commanders.description.packages import Packages, packages_below, surroundings

XACRO = '<robot name="{name}" xmlns:xacro="http://www.ros.org/wiki/xacro">{body}</robot>'


def package(folder, name, depends=(), **files):
    """Write a package; `a__b` of a file's name stands for a/b."""
    folder.mkdir(parents=True)
    needs = "".join(f"<exec_depend>{other}</exec_depend>" for other in depends)
    (folder / "package.xml").write_text(f"<package><name>{name}</name>{needs}</package>")
    for path, text in files.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return folder


def xacro_of(text, *arguments):
    """Return a URDF or SRDF as a xacro file with arguments, each a name and its default; one without is used only."""
    declared = "".join(
        f'<material name="$(arg {name})"/>' if default is None else f'<xacro:arg name="{name}" default="{default}"/>'
        for name, default in arguments
    )
    body = text.split("?>")[-1].split(">", 1)[1].rsplit("</robot>", 1)[0]
    return XACRO.format(name="smally", body=declared + body)


@pytest.fixture
def workspace(tmp_path):
    """The description lies in another repository, in a folder that isn't called like its package."""
    package(tmp_path / "ws/src/vendor/models", "smally_model", **{"robots/smally.urdf": urdf()})
    return tmp_path / "ws" / "src"


def loaded(folder):
    found = inspect_robot(str(folder))
    assert found.description is not None, found.findings
    return found


@pytest.mark.parametrize("place", ["srdf", "config", "config/srdf"])
def test_an_srdf_wherever_it_lies_keeps_its_joint_limits(workspace, place):
    files = {f"{place}/smally.srdf": SRDF, "config/joint_limits.yaml": LIMITS}
    folder = package(workspace / "drivers/smally_moveit", "smally_moveit", ["smally_model"], **files)
    found = loaded(folder)
    assert set(found.description.groups) == {"manipulator", "gripper", "all"}
    assert found.description.acceleration_limits["j1"] == 3.5
    assert 'velocity="1.25"' in found.description.urdf


PYTHON = """
# mappings={"gripper": "three"}
def generate_launch_description():
    config = (MoveItConfigsBuilder("smally", package_name="smally_moveit")
        .robot_description(mappings={"gripper": "two", "cell": LaunchConfiguration("cell")}))
    return [DeclareLaunchArgument("size", default_value="large"), Node(parameters=[config])]
"""
ROS1 = """<launch>
  <!-- <arg name="fingers" default="three"/> -->
  <arg name="fingers" default="two"/>
  <param name="robot_description" command="xacro '$(find smally_model)/robots/smally.urdf.xacro' gripper:=$(arg fingers)
    size:=large"/>
</launch>
"""


@pytest.mark.parametrize(("file", "text"), [("launch/demo.launch.py", PYTHON), ("launch/context.launch", ROS1)])
def test_what_launch_files_give_to_a_xacro_file_is_given(workspace, file, text):
    fingers = "<xacro:if value=\"${'$(arg gripper)' == 'two'}\"><link name=\"extra\"/>"
    fixed = '<joint name="e" type="fixed"><parent link="base"/><child link="extra"/></joint></xacro:if>'
    robot = xacro_of(urdf(), ("gripper", "none"), ("size", None), ("serial_ip", None))
    robot = robot.replace("</robot>", f"{fingers}{fixed}</robot>")
    (workspace / "vendor/models/robots/smally.urdf").unlink()
    (workspace / "vendor/models/robots/smally.urdf.xacro").write_text(robot)
    srdf = SRDF.replace('<group name="gripper">', '<group name="gripper"><link name="extra"/>')
    files = {"srdf/smally.srdf": srdf, file: text}
    found = loaded(package(workspace / "smally_moveit", "smally_moveit", ["smally_model"], **files))
    assert found.chosen.fit == 1
    assert found.chosen.arguments == {"gripper": "two", "size": "large", "serial_ip": "0.0.0.0"}


def test_launch_files_that_cannot_be_read_and_code_in_them_do_nothing(tmp_path):
    marker = tmp_path / "ran"
    text = f"open({str(marker)!r}, 'w')\nDeclareLaunchArgument('a', default_value='b')\n"
    files = {"launch/a.launch.py": text, "launch/b.launch": "<launch", "launch/c.launch.py": "def ("}
    hints = hints_of(package(tmp_path / "p", "p", **files))
    assert hints.defaults == {"a": "b"}
    assert not marker.exists()


def test_of_several_configurations_the_first_is_taken_and_told(workspace):
    files = {f"srdf/{name}.srdf": SRDF.replace('name="smally"', f'name="{name}"') for name in ("long", "short")}
    files["srdf/parts_macro.srdf.xacro"] = XACRO.format(name="m", body='<xacro:macro name="m"><a/></xacro:macro>')
    folder = package(workspace / "smally_moveit", "smally_moveit", ["smally_model"], **files)
    found = loaded(folder)
    (told,) = [f for f in found.findings if f.code == "several-configurations"]
    assert "long is taken; others, for `srdf:`, are short" in told.message
    assert found.chosen.name == "long"


@pytest.mark.parametrize("told_by", ["launch file", "files"])
def test_the_values_that_an_argument_may_have_are_configurations(workspace, told_by):
    """A file for each robot, which the URDF's xacro file names by an argument."""
    models = workspace / "vendor" / "models"
    (models / "robots" / "smally.urdf").unlink()
    for kind in ("five", "nine"):
        (models / "robots" / f"{kind}.parts").write_text(xacro_of(urdf()))
    include = '<xacro:include filename="$(find smally_model)/robots/$(arg kind).parts"/><material name="m"/>'
    (models / "smally.urdf.xacro").write_text(XACRO.format(name="smally", body=include))
    launch = CHOICES if told_by == "launch file" else ""
    files = {"srdf/smally.srdf": SRDF, "launch/a.launch.py": launch}
    folder = package(workspace / "smally_moveit", "smally_moveit", ["smally_model"], **files)
    found = loaded(folder)
    assert found.chosen.arguments == {"kind": "five"}
    assert any("others, for `arguments:`, are nine" in f.message for f in found.findings)
    chosen = inspect_robot(RobotConfig(moveit=str(folder), arguments={"kind": "nine"}))
    assert chosen.chosen.arguments == {"kind": "nine"}
    assert not [f for f in chosen.findings if f.code == "several-configurations"]


CHOICES = "DeclareLaunchArgument('kind', choices=['five', 'nine'])\n"


def test_a_name_that_no_urdf_has_is_told_with_what_was_tried(workspace):
    srdf = '<robot name="other"><group name="g"><chain base_link="x" tip_link="y"/></group></robot>'
    folder = package(workspace / "smally_moveit", "smally_moveit", ["smally_model"], **{"srdf/a.srdf": srdf})
    (told,) = [f for f in inspect_robot(str(folder)).findings if f.severity == "error"]
    assert "no URDF has what the SRDF names (tried: smally.urdf)" in told.message


def test_a_description_that_isnt_here_is_named_whatever_else_lies_around(workspace):
    package(workspace / "tool", "tool_description", **{"urdf/broken.urdf.xacro": "<robot><xacro:nothing/></robot>"})
    made = "moveit_setup_assistant_config:\n  URDF: {package: other_description, relative_path: urdf/other.urdf}\n"
    srdf = '<robot name="other"><group name="g"><chain base_link="x" tip_link="y"/></group></robot>'
    folder = package(workspace / "other_moveit", "other_moveit", **{"config/a.srdf": srdf, ".setup_assistant": made})
    (told,) = [f for f in inspect_robot(str(folder)).findings if f.severity == "error"]
    assert ".setup_assistant names other_description/urdf/other.urdf" in told.message


def test_what_a_driver_tests_with_is_no_configuration(workspace):
    package(workspace / "driver", "driver", **{"test/mock.srdf": SRDF})
    folder = package(workspace / "smally_moveit", "smally_moveit", ["smally_model"], **{"srdf/smally.srdf": SRDF})
    assert configured_packages(workspace) == [folder]


def test_packages_are_known_by_their_manifests_in_the_whole_workspace(workspace):
    folder = package(workspace / "deep/er/smally_moveit", "smally_moveit")
    package(workspace / "build/smally_model", "smally_model")
    found = Packages({}, (folder / "package.xml",)).find("smally_model")
    assert found == workspace / "vendor" / "models"
    assert dict(packages_below(workspace))["smally_moveit"] == folder
    assert surroundings(folder)[-1] == workspace


def test_a_repository_ends_the_search_and_those_beside_it_are_found(tmp_path):
    (tmp_path / "code/repo/.git").mkdir(parents=True)
    folder = package(tmp_path / "code/repo/a", "a")
    package(tmp_path / "code/other/b", "b")
    package(tmp_path / "elsewhere/c", "c")
    assert Packages({}, (folder / "package.xml",)).find("b").name == "b"
    assert surroundings(folder)[-1] == tmp_path / "code"


FINGERS = """<robot name="claw"><link name="palm"/>{}</robot>"""


def finger(name, y, axis):
    moments = 'ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"'
    inertial = f'<inertial><origin xyz="0 0 0.05"/><mass value="0.1"/><inertia {moments}/></inertial>'
    limit = '<limit lower="-0.2" upper="1.2" velocity="1" effort="1"/>'
    return (
        f'<link name="{name}">{inertial}</link><joint name="{name}_joint" type="revolute"><parent link="palm"/>'
        f'<child link="{name}"/><origin xyz="0 {y} 0"/><axis xyz="{axis} 0 0"/>{limit}</joint>'
    )


def test_a_hand_without_an_srdf_has_a_group_and_closes_where_its_fingers_meet(tmp_path):
    text = FINGERS.format(finger("left", 0.04, 1) + finger("right", -0.04, -1))
    (tmp_path / "claw.urdf").write_text(text)
    robot = load_robot(str(tmp_path / "claw.urdf"))
    assert robot.groups == {"hand": ("left_joint", "right_joint")}
    assert robot.named_state("hand", "open").position.tolist() == [0, 0]
    assert robot.named_state("hand", "closed").position.tolist() == pytest.approx([1.08, 1.08])


def test_an_arm_without_an_srdf_ends_where_its_fingers_begin(tmp_path):
    (tmp_path / "smally.urdf").write_text(urdf().replace('<mimic joint="slide_left"/>', ""))
    robot = load_robot(str(tmp_path / "smally.urdf"))
    assert robot.groups == {"arm": tuple(f"j{k}" for k in range(1, 7)), "hand": ("slide_left", "slide_right")}
    assert robot.end_effectors[0].parent_group == "arm"
    closed, opened = (robot.named_state("hand", name).position.tolist() for name in ("closed", "open"))
    assert closed == [0, 0]
    assert opened == [0.04, 0.04]


@pytest.mark.parametrize(("name", "word"), [("Hand_Open", "open"), ("fist", "closed"), ("close", "closed")])
def test_states_that_mean_open_and_closed_are_called_so_too(tmp_path, name, word):
    (tmp_path / "r.urdf").write_text(urdf())
    (tmp_path / "r.srdf").write_text(SRDF.replace(f'name="{word}"', f'name="{name}"'))
    robot = load_robot(RobotConfig(urdf="r.urdf", srdf="r.srdf"), tmp_path)
    assert robot.named_state("gripper", word) == robot.named_state("gripper", name)


LAUNCH = {
    "up.launch.xml": """<launch>
  <!-- <arg name="model" default="$(find-pkg-share smally_model)/robots/nothing.urdf"/> -->
  <include file="$(find-pkg-share smally_up)/launch/model.launch.xml"/>
</launch>""",
    "model.launch.xml": """<launch><node pkg="robot_state_publisher" exec="robot_state_publisher">
  <param name="robot_description"
    value="$(command 'xacro $(find-pkg-share smally_model)/robots/smally.urdf.xacro hand:=big')"/>
  <param name="robot_description_semantic" value="$(command 'cat $(find-pkg-share smally_groups)/config/smally.srdf')"/>
</node></launch>""",
    "up.launch": """<launch>
  <arg name="model" default="$(find smally_model)/robots/smally.urdf.xacro"/>
  <param name="robot_description" command="xacro $(arg model) hand:=big"/>
  <param name="robot_description_semantic" textfile="$(find smally_groups)/config/smally.srdf"/>
</launch>""",
    "up.launch.py": """raise SystemExit("it is read, never run")
model = os.path.join(get_package_share_directory("smally_model"), "robots", "smally.urdf.xacro")
semantic = os.path.join(get_package_share_directory("smally_groups"), "config", "smally.srdf")
description = xacro.process_file(model, mappings={"hand": "big"})
""",
}


@pytest.mark.parametrize("name", ["up.launch.xml", "up.launch", "up.launch.py"])
def test_a_launch_file_is_the_robot_that_it_brings_up(tmp_path, name):
    source = tmp_path / "ws/src"
    xacro = xacro_of(urdf(), ("hand", "small"))
    package(source / "smally_model", "smally_model", **{"robots/smally.urdf.xacro": xacro})
    package(source / "groups", "smally_groups", **{"config/smally.srdf": SRDF})
    folder = package(source / "smally_up", "smally_up", **{f"launch/{file}": text for file, text in LAUNCH.items()})
    found = loaded(folder / "launch" / name)
    assert set(found.description.groups) == {"manipulator", "gripper", "all"}
    config, _ = config_of(str(folder / "launch" / name), tmp_path)
    assert (config.arguments, config.srdf) == ({"hand": "big"}, str(source / "groups/config/smally.srdf"))
    files = new_robot(str(folder / "launch" / name), tmp_path / "lab", lambda _, names: names[0]).files
    assert f"bringup: {{package: smally_up, launch: {name}}}" in files["grip.yaml"]


def test_a_launch_file_without_a_robot_says_what_it_names(tmp_path):
    text = '<launch><node pkg="camera" exec="camera" args="camera.urdf"/></launch>'
    folder = package(tmp_path / "camera", "camera", **{"launch/camera.launch.xml": text})
    (finding,) = inspect_robot(str(folder / "launch/camera.launch.xml")).findings
    assert "no robot's file is found that it brings up (it names camera.urdf)" in finding.message


@pytest.fixture
def two_configured(workspace):
    """Two configuration packages of one workspace, the second with limits."""
    for name, more in (("a_moveit", {}), ("b_moveit", {"config/joint_limits.yaml": LIMITS})):
        package(workspace / name, name, ["smally_model"], **{"config/smally.srdf": SRDF, **more})
    return workspace


def test_a_workspace_stands_for_the_package_in_it(two_configured, tmp_path):
    asked = []

    def choose(question, names):
        asked.append(list(names))
        return names[1]

    made = new_robot(str(two_configured), tmp_path / "lab", choose)
    assert asked == [["a_moveit", "b_moveit"]]
    assert "moveit: ../ws/src/b_moveit\n" in made.files["grip.yaml"]
    assert not [f for f in made.findings if f.code == "missing-package"]


def test_of_a_workspace_the_package_of_the_srdf_is_taken_or_the_first_and_said(two_configured):
    found = inspect_robot(RobotConfig(moveit=str(two_configured)))
    (told,) = [f.message for f in found.findings if f.code == "several-configurations"]
    assert told == "of several configurations a_moveit is taken; others, for `moveit:`, are b_moveit"
    named = RobotConfig(moveit=str(two_configured), srdf=str(two_configured / "b_moveit/config/smally.srdf"))
    found = inspect_robot(named)
    assert found.description.acceleration_limits["j1"] == 3.5
    assert not [f for f in found.findings if f.code in ("several-configurations", "missing-package")]
