"""Modules that lie in the current folder are nobody's: not ours, and not those of the processes that we start."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from grip_bt.cli.__main__ import main

ROOT = Path(__file__).parents[2]
NAMES = (
    *("random", "json", "typing", "enum", "socket", "sqlite3", "subprocess", "tempfile", "uuid", "secrets"),
    *("yaml", "numpy", "pydantic", "py_trees", "scipy", "toppra", "sapien", "rclpy", "xacro", "fastapi", "mcap"),
)
TASK = "grip: 1\nname: t\nroot: {node: flow/succeed}\n"
CAMPAIGN = "campaign: 1\ntask: t.yaml\nrobot: fake\nseeds: [0]\n"
TREE = "import py_trees\nfrom mine_too import name\n\n\ndef build():\n    return py_trees.behaviours.Success(name)\n"
LEGACY = """\
import smach
from mine_too import name


def main():
    machine = smach.StateMachine(outcomes=["done"])
    with machine:
        smach.StateMachine.add(name, smach.CBState(go, outcomes=["done"]), transitions={"done": "done"})
    return machine


def go(data):
    return "done"
"""
XACRO = (
    '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="base"/><link name="tip"/>'
    '<joint name="j" type="fixed"><parent link="base"/><child link="tip"/></joint></robot>'
)
CHILDREN: list[list[str]] | None = None
"""Commands of this Python that were started, while somebody wants to know."""


def _listen(event: str, args: tuple[Any, ...]) -> None:
    if CHILDREN is not None and event == "subprocess.Popen":
        command = [str(word) for word in args[1]]
        if Path(command[0]).name.startswith("python"):
            CHILDREN.append(command)


sys.addaudithook(_listen)


@pytest.fixture
def hostile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with modules that leave a trace wherever they are imported; a project, and the current folder."""
    global CHILDREN
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(
            f"open({str(tmp_path / name)!r} + '.run', 'w').close()\nraise SystemExit(9)\n"
        )
    (tmp_path / "t.yaml").write_text(TASK)
    (tmp_path / "campaign.yaml").write_text(CAMPAIGN)
    (tmp_path / "tree.py").write_text(TREE)
    (tmp_path / "legacy.py").write_text(LEGACY)
    (tmp_path / "mine_too.py").write_text("name = 'MINE'\n")
    (tmp_path / "robot.urdf.xacro").write_text(XACRO)
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    monkeypatch.chdir(tmp_path)
    CHILDREN = []
    yield tmp_path
    CHILDREN = None
    assert not sorted(tmp_path.glob("*.run")), "modules of the current folder were imported"


def safely(children: list[list[str]] | None) -> int:
    """See that each child was started so that the current folder isn't on its path; return how many there were."""
    assert children is not None
    for command in children:
        assert {"-P", "-I"} & set(command[1:4]), f"started with the current folder on its path: {command}"
    return len(children)


@pytest.mark.parametrize(
    ("words", "least"),
    [
        (["check", "t.yaml"], 0),
        (["fmt", "--check", "t.yaml"], 0),
        (["run", "t.yaml", "--robot", "fake"], 1),
        (["bench", "campaign.yaml", "-o", "results"], 1),
        (["convert", "t.yaml", "--to", "sm"], 0),
        (["import", "tree:build", "--from", "pytrees", "--execute", "-o", "made.yaml"], 1),
        (["import", "legacy.py", "--from", "smach", "--execute", "-o", "made.yaml"], 1),
        (["robot", "check", "robot.urdf.xacro"], 1),
        (["doctor"], 1),
        pytest.param(["run", "t.yaml", "--robot", "sim"], 1, marks=pytest.mark.sim),
    ],
)
def test_no_verb_runs_what_lies_in_the_current_folder(hostile: Path, words: list[str], least: int) -> None:
    assert main(words) in (0, 1)
    assert safely(CHILDREN) >= least


def test_what_is_meant_is_found_there(hostile: Path) -> None:
    assert main(["import", "tree:build", "--from", "pytrees", "--execute", "-o", "made.yaml"]) == 0
    assert "MINE" in (hostile / "made.yaml").read_text()


@pytest.mark.parametrize("module", ["grip_bt.cli", "grip_bt.cli.__main__"])
def test_the_command_itself_doesnt_either_as_a_module(hostile: Path, module: str) -> None:
    done = subprocess.run([sys.executable, "-m", module, "check", "t.yaml"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.sim
def test_the_parts_of_a_simulated_run_dont_either(hostile: Path) -> None:
    (hostile / "arm.yaml").write_text("grip: 1\nname: arm\nroot: {node: arm/move_to, with: {state: home}}\n")
    (hostile / "grip.yaml").write_text("grip: 1\nrobot: panda_allegro\nworld: table\narms: {right: {group: arm}}\n")
    main(["run", "arm.yaml", "--robot", "sim", "--in-process"])
    assert safely(CHILDREN) >= 2


def test_the_pages_processes_dont_either(hostile: Path) -> None:
    pytest.importorskip("fastapi")
    from grip_gui.setup.robot_drawing import geometry
    from grip_gui.setup.robot_facts import robot_facts

    assert robot_facts("robot.urdf.xacro", hostile)["links"]
    geometry("robot.urdf.xacro", {}, hostile)
    assert safely(CHILDREN) >= 2


def test_nothing_else_starts_this_python() -> None:
    """What is started anew goes through `python_command`, isolated (the process reaper), or somebody's `{python}`."""
    known = {
        "grip_bt/base/interpreter.py",
        "grip_bt/ros/command.py",
        "grip_bt/ros/process.py",
        "grip_bt/cli/doctor.py",
    }
    rooms = [ROOT / "grip_bt", ROOT / "sim", ROOT / "gui" / "grip_gui"]
    found = {
        file.relative_to(ROOT).as_posix()
        for room in rooms
        for file in room.rglob("*.py")
        if re.search(r"sys\.executable|multiprocessing|ProcessPoolExecutor", file.read_text(encoding="utf-8"))
    }
    templates = {name for name in found if "/template" in name or "/repository/" in name}
    assert found - templates == known | {"grip_bt/ros/client/connection.py"} & found
