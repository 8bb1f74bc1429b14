"""Projects whose robot comes from files, or is several robots, run as any other."""

from __future__ import annotations

import shutil

import pytest
from smally_project import PROJECT, robot_files, write_project

from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.execute import RunOptions, open_session, run
from grip_bt.base.errors import DocumentError, InvalidRobotError
from grip_bt.cli.__main__ import main
from grip_bt.runtime import JournalReader
from grip_bt.task import load

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
    with pytest.raises(InvalidRobotError, match=r"(?s)smally.urdf:\d+: error\[unknown-link\] robot: the child"):
        find_project(task).description()


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("moveit:", "movit:", r"grip.yaml:3:3: unknown key 'movit' in robot; did you mean 'moveit'\?"),
        ("  moveit: src/smally_moveit_config\n", "", "a robot is made of exactly one of urdf, xacro, moveit"),
        ("[0, 0, 0.09]", "[0, 0, .nan]", "finite number"),
    ],
)
def test_a_wrong_description_in_the_project_file_is_told_with_its_place(tmp_path, old, new, says):
    (tmp_path / "grip.yaml").write_text(PROJECT.replace(old, new))
    with pytest.raises(DocumentError, match=says):
        find_project(tmp_path)


def workspace(folder, srdf=None):
    """Write a MoveIt configuration package and, in another folder, the description that it names."""
    files = robot_files()
    (folder / "src" / "models").mkdir(parents=True)
    files.description_package(folder / "src" / "models")
    made = files.moveit_package(folder / "src", 2)
    if srdf is not None:
        (made / "config" / "smally.srdf").write_text(srdf(files.SRDF))
    return made


@pytest.mark.parametrize("given", ["workspace", "urdf"])
def test_a_new_project_for_a_robots_files_runs_at_once(tmp_path, capsys, given):
    workspace(tmp_path)
    urdf = tmp_path / "src" / "models" / "smally_description" / "urdf" / "smally.urdf"
    source = urdf if given == "urdf" else tmp_path / "src"
    lab = tmp_path / "lab"
    assert main(["new", str(lab), "--robot", str(source)]) == 0
    task = lab / "tasks" / "first.yaml"
    assert main(["check", str(task)]) == 0
    assert main(["fmt", "--check", str(task)]) == 0
    document = load(task)
    done = [child.node for child in document.root.children.values()]
    assert {"arm/move_to", "arm/move_to_pose", "arm/move_straight", "hand/open", "hand/posture"} <= set(done)
    assert main(["run", str(task), "--robot", "fake"]) == 0
    file = find_project(lab).file
    (arm,) = file.arms.values()
    assert arm.hand in file.hands
    if given != "urdf":
        assert (arm.group, list(file.hands)) == ("manipulator", ["gripper"])
        assert file.sensors["camera"].topics["seen"].topic == "/camera/points"
        assert "sensor-not-read" in capsys.readouterr().out


@pytest.mark.parametrize("place", ["src/lab", "install/lab/share/lab"])
def test_a_ros_package_names_the_robots_package_and_not_its_path(tmp_path, monkeypatch, place):
    """It is found around the project in the workspace, and by ament's path where both are installed."""
    made = workspace(tmp_path)
    (made / "package.xml").write_text("<package><name>smally_moveit_config</name></package>")
    lab = tmp_path / "src" / "lab"
    assert main(["new", str(lab), "--ros", "--robot", str(made)]) == 0
    text = (lab / "grip.yaml").read_text()
    assert "moveit: package://smally_moveit_config\n" in text
    assert str(tmp_path) not in text
    assert "../" not in text
    if place != "src/lab":
        prefix = tmp_path / "install"
        shutil.copytree(lab, tmp_path / place)
        for package in (tmp_path / "src").rglob("package.xml"):
            shutil.copytree(package.parent, prefix / "share" / package.parent.name, dirs_exist_ok=True)
        shutil.rmtree(tmp_path / "src")
        monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    assert main(["run", str(tmp_path / place / "tasks" / "first.yaml"), "--robot", "fake"]) == 0


def test_of_several_configurations_the_first_is_taken_and_the_others_can_be_named(tmp_path, capsys):
    made = workspace(tmp_path)
    (made / ".setup_assistant").unlink()
    (made / "package.xml").write_text(
        "<package><name>smally_moveit_config</name><depend>smally_description</depend></package>"
    )
    (made / "config" / "tall.srdf").write_text((made / "config" / "smally.srdf").read_text())
    assert main(["new", str(tmp_path / "one"), "--robot", str(made)]) == 0
    assert "several configurations: smally is taken; others, for --configuration: tall" in capsys.readouterr().out
    assert main(["new", str(tmp_path / "two"), "--robot", str(made), "--configuration", "tall"]) == 0
    assert "srdf: ../src/smally_moveit_config/config/tall.srdf" in (tmp_path / "two" / "grip.yaml").read_text()
    assert main(["new", str(tmp_path / "three"), "--robot", str(made), "--configuration", "tell"]) == 1
    assert "unknown configuration 'tell'" in capsys.readouterr().err
    assert not (tmp_path / "three").exists()


def test_a_state_in_which_links_touch_is_left_out_and_a_home_is_found(tmp_path, capsys):
    """The arm folds back into its base in the only state that its files have."""
    folded = {"j2": "2.6", "j3": "2.7"}

    def changed(srdf):
        for joint, old in (("j2", "0.5"), ("j3", "1.0")):
            srdf = srdf.replace(f'name="{joint}" value="{old}"', f'name="{joint}" value="{folded[joint]}"')
        return srdf.replace('<group_state name="home"', '<group_state name="folded"')

    made = workspace(tmp_path, changed)
    assert main(["new", str(tmp_path / "lab"), "--robot", str(made)]) == 0
    assert run(tmp_path / "lab" / "tasks" / "first.yaml", robot="fake").status == "success"
    doc = load(tmp_path / "lab" / "tasks" / "first.yaml").doc
    assert "Left out, since links touch there: folded (" in doc
    assert "manipulator: {home: {j1: 0" in (tmp_path / "lab" / "grip.yaml").read_text()


@pytest.mark.parametrize("robot", ["allegro_right", "robotiq_2f_85"])
@pytest.mark.parametrize("on", ["fake", SIMULATED])
def test_a_hand_alone_runs(robot, on, tmp_path):
    assert main(["new", str(tmp_path / "lab"), "--robot", robot]) == 0
    task = tmp_path / "lab" / "tasks" / "first.yaml"
    assert list(load(task).root.children) == ["hand_closed", "hand_open"]
    assert run(task, robot=on).status == "success"
