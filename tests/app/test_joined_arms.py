"""A project of two arms: joined into one that one plan moves, and moved at once by plans that are checked as one."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest
from smally_project import robot_files

from grip_bt.app.project.faults import check, faults_of_parts, jerks_of_arms
from grip_bt.app.project.folder import ArmConfig, find_project
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.errors import GripError
from grip_bt.cli.__main__ import main

SIMULATED = pytest.param("sim", marks=[pytest.mark.sim, pytest.mark.slow])
PROJECT = """grip: 1
robot:
  robots:
    left: {robot: {urdf: smally.urdf, srdf: smally.srdf}, xyz: [0, 0.4, 0]}
    right: {robot: {urdf: smally.urdf, srdf: smally.srdf}, xyz: [0, -0.4, 0]}
  groups:
    arms: {groups: [left_manipulator, right_manipulator]}
arms:
  left: {group: left_manipulator, hand: left_gripper}
  right: {group: right_manipulator, hand: right_gripper}
  both: {group: arms, arms: [left, right]}
hands: {left_gripper: {group: left_gripper}, right_gripper: {group: right_gripper}}
world: table
"""
TASK = """grip: 1
name: both
data: {state: JointState}
root:
  kind: sequence
  children:
    home: {node: arm/move_to, with: {arm: both, state: home}}
    where: {node: arm/read_state, with: {arm: both}, out: {state: state}}
"""


@pytest.fixture
def folder(tmp_path):
    files = robot_files()
    (tmp_path / "smally.urdf").write_text(files.urdf())
    (tmp_path / "smally.srdf").write_text(files.SRDF)
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "both.yaml").write_text(TASK)
    return tmp_path


@pytest.mark.parametrize("robot", ["fake", SIMULATED])
def test_one_plan_moves_both_arms_to_the_state_that_both_have(folder, capsys, robot):
    status = main(["run", str(folder / "both.yaml"), "--robot", robot, "--json"])
    said = json.loads(capsys.readouterr().out)
    assert (status, said["status"]) == (0, "success"), said


@pytest.mark.sim
@pytest.mark.slow
def test_the_joined_arm_is_where_its_arms_are(folder):
    with open_session(folder / "both.yaml", RunOptions(robot="sim")) as session:
        assert session.runner.run().status == "success"
        arms = session.resources.arms
        measured = arms["both"].state().as_mapping()
        for side in ("left", "right"):
            home = {f"{side}_{joint}": angle for joint, angle in HOME.items()}
            assert arms[side].state().as_mapping() == pytest.approx(home, abs=0.02)
            assert {n: p for n, p in measured.items() if n.startswith(side)} == pytest.approx(home, abs=0.02)


HOME = {"j1": 0, "j2": 0.5, "j3": 1.0, "j4": 0, "j5": 1.2, "j6": 0}


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("arms: [left, rihgt]", "did you mean 'right'"),
        ("arms: [left]", "holds other joints than left together"),
        ("arms: [left, both]", "unknown arm 'both'"),
    ],
)
def test_a_joined_arm_of_wrong_parts_is_refused(folder, wrong, words):
    file = folder / "grip.yaml"
    file.write_text(file.read_text().replace("arms: [left, right]", wrong))
    project = find_project(folder / "both.yaml")
    with pytest.raises(GripError, match=words):
        check(faults_of_parts(project, project.description()))


def test_joints_brake_with_the_smaller_jerk_of_the_arms_that_they_are_part_of():
    robot = SimpleNamespace(
        groups={"l": ("a", "b"), "r": ("c",), "all": ("a", "b", "c")}, jerk_limits={"a": 10.0, "b": 20.0, "c": 40.0}
    )
    arms = {
        "left": ArmConfig(group="l", jerk=0.5),
        "right": ArmConfig(group="r"),
        "both": ArmConfig(group="all", jerk=0.8),
    }
    assert jerks_of_arms(arms, robot) == {"a": 5.0, "b": 10.0, "c": 32.0}
    assert jerks_of_arms({"right": arms["right"]}, robot) == {}
