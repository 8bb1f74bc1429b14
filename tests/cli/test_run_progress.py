"""`grip run` says on stderr what starts and what came up, unless the result is for a program."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from pathlib import Path

import pytest

from grip_bt.cli.__main__ import main
from grip_bt.cli.run import tell_end
from grip_bt.runtime import RunResult
from grip_bt.runtime.control import result_facts
from grip_bt.runtime.motion_end import Rest

GRIP = """\
grip: 1
robot: panda_allegro
world: table
arms: {right: {group: arm, hand: hand}}
hands: {hand: {group: hand}}
"""
LOOK = "grip: 1\nname: look\ndata: {left: Any}\nroot: {node: scene/snapshot, out: {snapshot: left}}\n"
NAMED = """\
grip: 1
name: named
data: {number: {type: int, value: 7}}
root: {node: messages/put, with: {store: notes, name: seven}, in: {value: number}}
"""


@pytest.mark.parametrize("way", [(), ("--in-process",)])
def test_what_came_up_is_said_on_stderr_unless_the_result_is_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], way: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("grip.yaml").write_text("grip: 1\n")
    Path("named.yaml").write_text(NAMED)
    assert main(["run", "named.yaml", *way]) == 0
    said = capfd.readouterr()
    assert said.err == "  messages    0 by name, 0 of them kept by an earlier run\n"
    assert said.out.startswith("success")
    assert main(["run", "named.yaml", "--json", *way]) == 0
    said = capfd.readouterr()
    assert said.err == ""
    assert json.loads(said.out)["status"] == "success"


PRINTS = """\
import py_trees

print("as it is imported")


class Talks(py_trees.behaviour.Behaviour):
    def update(self):
        print("as it ticks")
        return py_trees.common.Status.SUCCESS


def tree():
    return Talks("talks")
"""
PRINTED = ["as it is imported", "as it ticks"]


@pytest.mark.parametrize("way", [(), ("--in-process",)])
@pytest.mark.parametrize("as_json", [True, False])
def test_what_a_program_reads_holds_nothing_that_code_prints(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    way: tuple[str, ...],
    as_json: bool,
) -> None:
    monkeypatch.chdir(tmp_path)
    name = f"talks_{len(way)}_{as_json}"  # one that this process hasn't imported
    Path(f"{name}.py").write_text(PRINTS)
    assert main(["run", f"{name}.py:tree", *way, *["--json"] * as_json]) == 0
    said = capfd.readouterr()
    assert [line for line in (said.out, said.err)[as_json].splitlines() if line.startswith("as it")] == PRINTED
    if as_json:
        assert json.loads(said.out)["status"] == "success"


@pytest.mark.parametrize("way", [(), ("--in-process",)])
def test_nor_do_the_events_of_a_controlled_run(tmp_path: Path, way: tuple[str, ...]) -> None:
    (tmp_path / "talks.py").write_text(PRINTS)
    command = [sys.executable, "-m", "grip_bt.cli", "run", "talks.py:tree", "--control", *way]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=tmp_path, text=True, **pipes) as run:
        assert run.stdout is not None
        assert run.stderr is not None
        told = [json.loads(line) for line in run.stdout]  # until the run has ended; who ends stdin stops it
        assert [line for line in run.stderr.read().splitlines() if line.startswith("as it")] == PRINTED
    assert (told[0]["event"], told[-1]["event"], told[-1]["status"]) == ("started", "ended", "success")


@pytest.mark.slow
@pytest.mark.sim
def test_that_the_simulator_starts_is_said_before_it_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("sapien")
    monkeypatch.chdir(tmp_path)
    Path("grip.yaml").write_text(GRIP)
    Path("look.yaml").write_text(LOOK)
    assert main(["run", "look.yaml", "--in-process"]) == 0
    first, *others = [line.split()[0] for line in capfd.readouterr().err.splitlines() if line.startswith("  ")]
    assert first == "starting"
    assert others == ["simulator", "planner"]


def test_what_was_measured_after_a_stop_is_in_the_result(capsys):
    result = RunResult(None, None, "stopped", None, 3, 1.0, rest=Rest(("hand",), {"right": "the server says nothing"}))
    tell_end({**result_facts(result), "run": "1"}, as_json=True)
    said = json.loads(capsys.readouterr().out)
    assert said["unconfirmed"] == {"right": "the server says nothing"}
    assert said["rest"] == "could not confirm that 'right' stopped: the server says nothing; 'hand' is at rest"


def test_a_stop_before_there_is_a_run_names_none(capsys):
    tell_end({"status": "stopped", "outcome": None, "message": "before the task began", "run": None}, as_json=False)
    assert capsys.readouterr().out == "stopped: before the task began; no run was started\n"


def test_quiet_says_results_alone_and_verbose_where_an_error_was_raised(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("logging.root.handlers", [])
    monkeypatch.setattr("logging.root.level", logging.WARNING)
    (tmp_path / "two.yaml").write_text("{grip: 1, name: two, root: {node: messages/list, with: {store: poses}}}")
    for words, said in (((), True), (("-q",), False), ((), True)):
        assert main(["run", *words, "--robot", "fake", "--in-process", str(tmp_path / "two.yaml")]) == 0
        assert ("messages " in capsys.readouterr().err) is said
    assert main(["convert", "-v", str(tmp_path / "none.yaml"), "--to", "svg"]) == 1
    assert "Traceback" in capsys.readouterr().err
