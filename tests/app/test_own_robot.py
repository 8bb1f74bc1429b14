"""Projects whose robot comes from files, or is several robots, run as any other."""

from __future__ import annotations

import pytest
from smally_project import PROJECT, write_project

from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.errors import DocumentError, InvalidRobotError
from grip_bt.runtime import JournalReader

SIMULATED = pytest.param("sim", marks=[pytest.mark.sim, pytest.mark.slow])
TWO = """grip: 1
robot: two_ur5_allegro
arms: {left: {group: left_arm, hand: left_hand}, right: {group: right_arm, hand: right_hand}}
hands: {left_hand: {group: left_hand}, right_hand: {group: right_hand}}
world: table
"""
BOTH = """grip: 1
name: both
root:
  kind: parallel
  children:
    left: {node: arm/move_to, with: {arm: left, state: up}}
    right: {node: arm/move_to, with: {arm: right, state: up}}
"""


@pytest.mark.parametrize("robot", ["fake", SIMULATED])
def test_a_project_with_a_robot_from_files_runs(tmp_path, robot):
    task = write_project(tmp_path)
    with open_session(task, RunOptions(robot=robot)) as session:
        result = session.runner.run()
        assert (result.status, result.failure) == ("success", None)
        if robot == "sim":
            assert session.resources.arms["right"].state().names == ("j1", "j2", "j3", "j4", "j5", "j6")
            fingers = session.resources.hands["gripper"].state()
            assert fingers.as_mapping() == pytest.approx({"slide_left": 0.04}, abs=2e-3)


@pytest.mark.parametrize("robot", ["fake", SIMULATED])
def test_two_arms_of_two_namespaced_robots_move_at_the_same_time(tmp_path, robot):
    (tmp_path / "grip.yaml").write_text(TWO)
    (tmp_path / "both.yaml").write_text(BOTH)
    with open_session(tmp_path / "both.yaml", RunOptions(robot=robot, journal=tmp_path / "j.sqlite")) as session:
        result = session.runner.run()
        assert (result.status, result.failure) == ("success", None)
        measured = {side: arm.state() for side, arm in session.resources.arms.items()}
    if robot == "fake":
        return  # fakes are there at once
    for side, state in measured.items():
        assert all(name.startswith(f"{side}_") for name in state.names)
        assert state.position == pytest.approx([0.0, -1.57, 0.0, -1.57, 0.0, 0.0], abs=0.02)
    with JournalReader(tmp_path / "j.sqlite") as reader:
        seen = [(e.event, e.path) for e in reader.events(session.runner.run_id or "") if e.path in ("left", "right")]
    enters = [k for k, (event, _) in enumerate(seen) if event == "enter"]
    exits = [k for k, (event, _) in enumerate(seen) if event == "exit"]
    assert len(enters) == len(exits) == 2
    assert max(enters) < min(exits), "both move before either is there"


def test_the_projects_robot_is_described_from_its_own_folder(tmp_path, monkeypatch):
    task = write_project(tmp_path)
    monkeypatch.chdir("/")
    robot = find_project(task).description()
    assert robot.name == "smally"
    assert robot.grasp_frames["manipulator"].link == "palm"


def test_a_project_with_a_wrong_robot_tells_all_that_is_wrong(tmp_path):
    task = write_project(tmp_path)
    urdf = tmp_path / "src" / "smally_description" / "urdf" / "smally.urdf"
    urdf.write_text(urdf.read_text().replace("<child", "<chidl", 2))
    with pytest.raises(InvalidRobotError, match=r"(?s)smally.urdf:\d+: error \[unknown-link\] the child of joint 'j1'"):
        find_project(task).description()


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("moveit:", "movit:", r"grip.yaml:3:3: unknown key 'movit' in robot; did you mean 'moveit'\?"),
        ("  moveit: src/smally_moveit_config\n", "", "a robot is made of exactly one of urdf, xacro, mjcf, moveit"),
        ("[0, 0, 0.09]", "[0, 0, .nan]", "finite number"),
    ],
)
def test_a_wrong_description_in_the_project_file_is_told_with_its_place(tmp_path, old, new, says):
    (tmp_path / "grip.yaml").write_text(PROJECT.replace(old, new))
    with pytest.raises(DocumentError, match=says):
        find_project(tmp_path)
