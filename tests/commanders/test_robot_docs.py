import re
from pathlib import Path

import pytest
from robot_files import description_package, moveit_package

from grip_bt.app.project.folder import find_project
from grip_bt.cli.shell import make_parser
from grip_bt.commanders.description import check_urdf, from_files, guessed, load, srdf
from grip_bt.commanders.description import moveit_package as moveit
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.description.robot import RobotDescription

TEXT = (Path(__file__).parents[2] / "docs" / "robots.md").read_text()
YAML = re.findall(r"```yaml\n(.*?)```", TEXT, re.DOTALL)


def test_the_project_with_a_moveit_package_can_be_loaded_as_it_stands(tmp_path):
    description_package(tmp_path / "src")
    folder = moveit_package(tmp_path / "src", 2)
    folder.rename(tmp_path / "src" / "arm_moveit_config")
    (tmp_path / "src" / "smally_description").rename(tmp_path / "src" / "arm_description")
    assistant = tmp_path / "src" / "arm_moveit_config" / ".setup_assistant"
    assistant.write_text(assistant.read_text().replace("smally_description", "arm_description"))
    (tmp_path / "grip.yaml").write_text(YAML[0])
    project = find_project(tmp_path)
    robot = project.description()
    assert all(arm.group in robot.groups for arm in project.file.arms.values())
    assert robot.grasp_frames["manipulator"].pose.position.tolist() == [0, 0, 0.09]


def test_the_project_with_two_arms_can_be_loaded_as_it_stands(tmp_path):
    (tmp_path / "grip.yaml").write_text(YAML[1])
    project = find_project(tmp_path)
    robot = project.description()
    for part in (*project.file.arms.values(), *project.file.hands.values()):
        assert part.group in robot.groups
    assert isinstance(robot, RobotDescription)
    assert len(robot.group("arms")) == 12


@pytest.mark.parametrize("line", [x for x in TEXT.split("```sh\n")[1].split("```")[0].splitlines() if x])
def test_the_commands_are_commands(line):
    words = line.split()[1:]
    assert make_parser(words).parse_args(words).run is not None


def test_every_ready_made_robot_and_every_code_is_listed():
    told = set(re.findall(r"`([a-z0-9_]+)`", TEXT.split("## Ready-made")[1].split("## From files")[0]))
    assert set(ROBOTS) <= told
    modules = (check_urdf, srdf, load, moveit, from_files, guessed)
    codes = set(re.findall(r'"([a-z]+-[a-z]+)"', "".join(Path(m.__file__).read_text() for m in modules)))
    listed = set(re.findall(r"`([a-z-]+)`", TEXT.split("## What is checked")[1]))
    assert codes <= listed
