"""Runs in a process of their own: whatever user code does to it, the parent knows where, and is well."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from grip_bt.app.runs import process as run_process
from grip_bt.app.runs.execute import RunOptions
from grip_bt.app.runs.supervisor import Supervisor
from grip_bt.base.errors import GripError
from grip_bt.runtime import JournalReader

NODES = """
import ctypes, os, signal, time
from grip_bt.nodes import Leaf

class Bad(Leaf):
    def update(self):
        how = self.params["how"]
        print("inside", flush=True)
        if how == "deref": ctypes.string_at(0)
        if how == "kill": os.kill(os.getpid(), signal.SIGSEGV)
        if how == "exit": os._exit(0)
        if how == "loop":
            while True: pass
        if how == "hold": ctypes.PyDLL(None).usleep(60_000_000)  # holds the interpreter's lock
        return self.running()
"""
MANIFEST = """
id: bad/node
doc: Does what no node should.
implementation: bad.py:Bad
parameters: {how: {type: str}}
"""
TASK = """
grip: 1
name: bad
root:
  kind: sequence
  children:
    fine: {node: flow/succeed}
    inner:
      kind: sequence
      children:
        worse: {node: bad/node, with: {how: %s}}
"""
SIMULATED = "robot: panda_allegro\nworld: table\narms: {right: {hand: right_hand}}\nhands: {right_hand: {}}\n"
MOVING = """
grip: 1
name: moving
root:
  kind: parallel
  children:
    moves:
      kind: repeat
      times: 40
      child:
        both:
          kind: sequence
          children:
            there: {node: arm/move_through, with: {offsets: [[0, 0.12, 0], [0, 0.12, 0.1]], radius: 0.03}}
            back: {node: arm/move_to, with: {state: home}}
    hangs:
      kind: sequence
      children:
        wait: {node: flow/wait, with: {seconds: 1.5}}
        worse: {node: bad/node, with: {how: hold}}
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    folder = tmp_path / "nodes" / "bad"
    folder.mkdir(parents=True)
    (folder / "bad.py").write_text(NODES)
    (folder / "manifest.yaml").write_text(MANIFEST)
    return tmp_path


def task(project: Path, how: str) -> Path:
    file = project / f"{how}.yaml"
    file.write_text(TASK % how)
    return file


def grip(*arguments: Any, **more: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "grip_bt.cli", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=600, **more)


class Supervised:
    """A supervised run whose events can be waited for."""

    def __init__(self, file: Path, **options: Any):
        self.events: queue.SimpleQueue[Any] = queue.SimpleQueue()
        given = RunOptions(**{"robot": "fake", **options})
        self.supervisor = Supervisor(str(file), given, self.events.put, silence=options.get("watchdog"))
        self.supervisor.start()

    def until(self, event: str) -> Any:
        while (told := self.events.get(timeout=300))["event"] != event:
            pass
        return told


def last_run(project: Path) -> Any:
    with JournalReader(project / ".grip" / "runs.sqlite") as reader:
        (record,) = reader.runs()
        return record, reader.events(record.id)


@pytest.mark.parametrize(
    ("how", "said"),
    [("deref", "was ended by SIGSEGV"), ("kill", "was ended by SIGSEGV"), ("exit", "ended with exit status 0 before")],
)
def test_a_process_that_dies_is_reported_with_the_nodes_path(project: Path, how: str, said: str) -> None:
    done = grip("run", task(project, how))
    assert done.returncode == 4
    assert "error: inner/worse: the run's process " + said in done.stdout
    assert "last node entered: inner/worse" in done.stdout
    record, events = last_run(project)
    assert (record.status, record.ended is not None) == ("error", True)
    (error,) = (e for e in events if e.event == "error")
    assert error.path == "inner/worse"
    assert said in error.data["message"]
    if how == "deref":
        assert 'bad.py", line 9 in update' in done.stdout


@pytest.mark.parametrize(("how", "said"), [("loop", "update hasn't returned for 3 s"), ("hold", "stood still for")])
def test_a_node_that_does_not_return_is_ended_and_named(project: Path, how: str, said: str) -> None:
    done = grip("run", task(project, how), "--watchdog", "3")
    assert done.returncode == 4
    assert "error: inner/worse: " in done.stdout
    assert said in done.stdout
    record, events = last_run(project)
    assert record.status == "error"
    assert [e.path for e in events if e.event == "error"] == ["inner/worse"]


def test_a_stop_that_is_not_acknowledged_ends_the_process_at_once(project: Path) -> None:
    run = Supervised(task(project, "hold"))
    run.until("started")
    while not run.supervisor._process.pulse.where(run.supervisor._paths)[1] == ["inner/worse"]:
        time.sleep(0.001)
    run.supervisor.stop()
    end = run.supervisor.wait()
    assert (end["status"], end["zombies"]) == ("stopped", ["inner/worse"])
    # it may just be able to acknowledge, before it goes to where it lets nothing else run
    assert "did not acknowledge the stop within 50 ms" in end["message"] or "hung after" in end["message"]
    record, _ = last_run(project)
    assert record.status == "stopped"


@pytest.mark.slow
def test_the_robot_of_a_run_that_has_to_be_ended_is_said_to_rest_when_the_simulator_has_measured_it(
    project: Path,
) -> None:
    pytest.importorskip("sapien")
    (project / "grip.yaml").write_text("grip: 1\n" + SIMULATED)
    file = project / "moving.yaml"
    file.write_text(MOVING)
    run = Supervised(file, robot="sim", pace=1.0)
    run.until("started")
    while "hangs/worse" not in run.supervisor._process.pulse.where(run.supervisor._paths)[1]:
        time.sleep(0.001)
    run.supervisor.stop()
    end = run.supervisor.wait()
    assert (end["status"], end["rest"], end["unconfirmed"]) == ("stopped", "'robot' is at rest", {})
    record, events = last_run(project)
    assert "'robot' is at rest" in events[-1].data["message"]


def test_a_stop_while_it_starts_ends_it(project: Path) -> None:
    run = Supervised(task(project, "loop"))
    run.supervisor.stop()
    end = run.supervisor.wait()  # the task itself never ends
    assert (end["status"], end["outcome"]) == ("stopped", None)
    with pytest.raises(ProcessLookupError):
        os.kill(run.supervisor.pid, 0)


def test_a_run_whose_parent_is_killed_has_died(project: Path) -> None:
    file = project / "wait.yaml"
    file.write_text("grip: 1\nname: w\nroot: {node: flow/wait, with: {seconds: 60}}\n")
    parent = subprocess.Popen(
        [sys.executable, "-m", "grip_bt.cli", "run", str(file), "--control"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert parent.stdout is not None
    while json.loads(parent.stdout.readline())["event"] != "started":
        pass
    parent.kill()
    parent.communicate()
    for _ in range(3000):
        record, _ = last_run(project)
        if record.status == "died":
            break
        time.sleep(0.01)
    assert record.status == "died", record


def test_ctrl_c_stops_the_run_and_says_so(project: Path) -> None:
    file = project / "wait.yaml"
    file.write_text("grip: 1\nname: w\nroot: {node: flow/wait, with: {seconds: 60}}\n")
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(file), "--set", "x=1"][:-2]
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    journal = project / ".grip" / "runs.sqlite"
    while not journal.is_file() or not _running(journal):
        time.sleep(0.01)
    os.killpg(run.pid, signal.SIGINT)
    out, err = run.communicate(timeout=300)
    assert run.returncode == 130
    assert out.startswith("stopped; ")
    assert err == ""


def _running(journal: Path) -> bool:
    try:
        with JournalReader(journal) as reader:
            return any(e.event == "enter" for r in reader.runs() for e in reader.events(r.id))
    except Exception:  # noqa: BLE001 - its tables are being made
        return False


def test_an_invalid_task_is_said_as_before(project: Path) -> None:
    done = grip("run", task(project, "[]"))
    assert done.returncode == 1
    assert "wrong-type" in done.stderr or "str" in done.stderr
    assert done.stdout == ""


def test_breakpoints_that_are_set_before_the_run_hold_under_control(project: Path) -> None:
    file = project / "steps.yaml"
    file.write_text("grip: 1\nname: s\nroot: {kind: sequence, children: {a: {node: flow/succeed}}}\n")
    run = subprocess.Popen(
        [sys.executable, "-m", "grip_bt.cli", "run", str(file), "--control"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert run.stdout is not None
    assert run.stdin is not None
    run.stdin.write('{"command": "break", "node": "a", "outcome": "success"}\n')
    run.stdin.flush()
    while (told := json.loads(run.stdout.readline()))["event"] != "held":
        pass
    assert (told["path"], told["when"], told["outcome"], told["breakpoint"]) == ("a", "after", "success", 1)
    run.stdin.write('{"command": "resume"}\n')
    run.stdin.flush()
    while (told := json.loads(run.stdout.readline()))["event"] != "ended":
        pass
    assert told["status"] == "success"
    run.communicate()
    assert run.returncode == 0


def test_a_stop_that_comes_while_a_refusal_is_told_does_not_cut_it_short(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[str, Any]] = []

    class Stopped:
        def send(self, event: str, **fields: Any) -> None:
            os.kill(os.getpid(), signal.SIGUSR1)
            told.append((event, fields["message"]))

    def refuse(*_: Any) -> int:
        raise GripError("no such thing")

    monkeypatch.setattr(run_process, "_run", refuse)
    before = signal.signal(signal.SIGUSR1, run_process._interrupted)
    try:
        assert run_process._run_or_say_why({}, {}, Stopped(), None) == 1
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert told == [("failed", "grip: no such thing")]


def test_a_stop_that_is_the_very_first_command_ends_the_process_in_good_order(project):
    # The signal of a stop that came while the thread which hears commands was still being started.
    code = (
        "import os, signal\n"
        "from grip_bt.runtime.control import Control\n"
        "Control.start = lambda self: os.kill(os.getpid(), signal.SIGUSR1)\n"
        "from grip_bt.app.runs.process import main\n"
        "raise SystemExit(main())\n"
    )
    (commands, order), (told, events), (_, trace) = os.pipe(), os.pipe(), os.pipe()
    os.write(order, json.dumps({"task": "t.yaml", "options": {}}).encode() + b"\n")
    passed = {"commands": commands, "events": events, "report": events, "trace": trace}
    done = subprocess.run(
        [sys.executable, "-c", code, json.dumps(passed)],
        pass_fds=(commands, events, trace),
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (130, b"")
    assert json.loads(os.read(told, 65536))["message"] == "before the task began"
    for number in (commands, order, told, events, trace):
        os.close(number)


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        ("-f 10", "the run's process can't be started: File too large; `ulimit -a`"),
        ("-f 1060", "couldn't be written"),
    ],
)
def test_a_limit_on_files_is_said_in_a_sentence(project: Path, limit: str, said: str) -> None:
    file = project / "much.yaml"
    nodes = (
        f"    n{i}: {{node: flow/set, with: {{value: {os.urandom(9000).hex()}}}, out: {{value: v}}}}\n"
        for i in range(50)
    )
    file.write_text(f"grip: 1\nname: much\ndata: {{v: str}}\nroot:\n  kind: sequence\n  children:\n{''.join(nodes)}")
    command = f"ulimit {limit}; exec {sys.executable} -m grip_bt.cli run {file} --robot fake"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=600)
    assert done.returncode == 1
    assert said in done.stderr
    assert "Traceback" not in done.stderr
