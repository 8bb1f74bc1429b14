"""A project as a ROS 2 launch file: what it says to the letter; and its processes."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from grip_bt.app.project.folder import find_project
from grip_bt.app.project.launching import launch_file_of, project_members
from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.cli.__main__ import main

GOLDEN = Path(__file__).parents[1] / "golden" / "launch" / "project.launch.xml"
PROJECT = """
grip: 1
processes:
  robot:
    package: ur_robot_driver
    launch: ur_control.launch.py
    arguments: {ur_type: ur5e, robot_ip: 10.0.0.2, use_fake_hardware: false}
    ready: {topic: /joint_states, within: 30}
  recorder:
    command: ["{python}", rec.py, "it's $(HOME) \\"quoted\\""]
    folder: tools
    restart: always
    env: {MODE: $a}
  camera: {package: camera_ros, executable: camera_node, args: [--fps, "30"], namespace: /left, required: false}
  spare: {package: arm_driver, executable: driver, run: false}
sensors:
  overhead:
    topics: {points: {topic: /points, type: PointCloud}}
    driver: {command: ["{python}", driver.py]}
    mount: {frame: camera_link, on: world, position: [0.5, 0, 1.2]}
"""
COMPONENT = """
name: detector
interface: std_srvs/srv/Trigger
server: /detect
outcomes: {found: success, none: "true"}
start: {command: ["{python}", server.py]}
"""


@pytest.fixture
def project(tmp_path) -> Path:
    (tmp_path / "grip.yaml").write_text(PROJECT)
    for name, start in (("detector", COMPONENT), ("elsewhere", COMPONENT.replace("start: {", "start: {run: false, "))):
        home = tmp_path / "components" / name
        home.mkdir(parents=True)
        (home / "component.yaml").write_text(start.replace("detector", name))
    return tmp_path


def test_the_launch_file_of_a_project_is_the_golden_one(project):
    made = launch_file_of(find_project(project), project)
    assert made == GOLDEN.read_text()


def test_what_is_not_to_be_run_is_not_in_it(project):
    made = launch_file_of(find_project(project), project)
    assert "spare" not in made
    assert "elsewhere" not in made


def test_only_what_is_declared_is_started(project, monkeypatch):
    """A vendor's launch file is started with its arguments, and nothing beside it."""
    (project / "ros2").write_text("#!/bin/sh\n")
    (project / "ros2").chmod(0o755)
    monkeypatch.setenv("PATH", str(project))
    (project / "grip.yaml").write_text(
        "grip: 1\nprocesses:\n  robot: {launch: bringup.launch.xml, arguments: {robot_ip: 10.0.0.2, fake: true}}\n"
    )
    (project / "bringup.launch.xml").write_text("<launch/>")
    (member,) = project_members(find_project(project))
    file = str(project / "bringup.launch.xml")
    assert list(member.command) == [str(project / "ros2"), "launch", file, "robot_ip:=10.0.0.2", "fake:=true"]


def test_a_process_that_is_not_declared_is_named(project):
    with pytest.raises(UnknownNameError, match="unknown process 'recoder'; did you mean 'recorder'"):
        project_members(find_project(project), ["recoder"])


def test_the_command_writes_it_and_checks_it(project, capsys):
    file = project / "all.launch.xml"
    assert main(["launch", "--project", str(project), "--write", str(file)]) == 0
    assert file.read_text() == launch_file_of(find_project(project), project)
    (project / "grip.yaml").write_text('grip: 1\nprocesses:\n  one: {command: [echo, "a b"]}\n')
    capsys.readouterr()
    assert main(["launch", "--project", str(project), "--check"]) == 0
    assert shlex.split(capsys.readouterr().out.partition(": ")[2]) == ["echo", "a b"]


def test_a_project_without_processes_says_what_to_do(tmp_path, capsys):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    assert main(["launch", "--project", str(tmp_path)]) == 1
    assert "declares no processes; name a launch file, or add `processes:`" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("process", "reason"),
    [
        ("{}", "give exactly one of `command`, `package` with `executable`, `launch`; here: none of them"),
        ("{command: [a], launch: b.launch.xml}", "here: command and launch"),
        ("{executable: a}", "`package` and `executable` go together"),
        ("{command: [a], args: [b]}", "`args` are those of an `executable`"),
        ("{command: [a], arguments: {b: c}}", "`arguments` are those of a `launch` file"),
        ("{command: [a], ready: {}}", "give exactly one of `service`, `topic`, `log`"),
        ("{command: [a], ready: {log: '('}}", "isn't a regular expression"),
    ],
)
def test_a_process_that_says_too_little_or_too_much_is_refused_with_its_place(tmp_path, process, reason):
    (tmp_path / "grip.yaml").write_text(f"grip: 1\nprocesses:\n  one: {process}\n")
    with pytest.raises(DocumentError, match=rf"grip.yaml:3:(.|\n)*{reason}"):
        find_project(tmp_path)
