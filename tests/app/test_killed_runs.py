"""Every process of a run, ended by SIGKILL at random moments, also while it starts: what is said of it is so."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from grip_bt.base.errors import GripError
from grip_bt.cli.__main__ import main
from grip_bt.runtime import JournalReader, RunRecord

DEATHS = int(os.environ.get("GRIP_FUZZ_DEATHS", "6"))
"""Runs that are killed; a third of them simulated."""
MARK = "GRIP_TEST_DEATHS"
WAITS = """\
grip: 1
name: waits
data: {n: {type: int, value: 0}}
root:
  kind: repeat
  times: 120
  child:
    step:
      kind: sequence
      children:
        count: {node: flow/compute, with: {expression: a + 1}, in: {a: n}, out: {value: n}}
        wait: {node: flow/wait, with: {seconds: 0.05}}
"""
SIMULATED = "robot: panda_allegro\nworld: table\narms: {right: {hand: right_hand}}\nhands: {right_hand: {}}\n"
MOVES = """\
grip: 1
name: moves
root:
  kind: repeat
  times: 40
  child:
    there_and_back:
      kind: sequence
      children:
        there: {node: arm/move_to, with: {state: home}}
        wait: {node: flow/wait, with: {seconds: 0.2}}
"""


def processes(mark: str) -> dict[int, str]:
    """Return the living processes of a run, with their command lines."""
    found = {}
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and f"{MARK}={mark}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                if (entry / "stat").read_text().rpartition(")")[2].split()[0] not in "ZX":
                    found[int(entry.name)] = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:
            continue
    return found


def part_of(command: str) -> str:
    """Return which process of a run a command line is."""
    known = {"runs.process": "child", "grip_sim": "simulator", "planning": "planner", "grip_bt.cli run": "parent"}
    return next((name for words, name in known.items() if words in command), "other")


def begin(folder: Path, task: str, robot: str, mark: str) -> subprocess.Popen[bytes]:
    command = [
        sys.executable,
        "-m",
        "grip_bt.cli",
        "run",
        task,
        "--robot",
        robot,
        *(["--pace", "1"] if robot == "sim" else []),
    ]
    environment = {**os.environ, MARK: mark}
    (folder / "said").write_text("")
    with (folder / "said").open("ab") as said:
        return subprocess.Popen(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=said, stderr=said
        )


def entered(folder: Path) -> bool:
    """Tell whether the run has begun to do something."""
    try:
        with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
            return any(reader.count(record.id) > 3 for record in reader.runs())
    except GripError:
        return False


def kill_one(folder: Path, run: subprocess.Popen[bytes], mark: str, choice: random.Random) -> str:
    """Kill one process of a run at a random moment; return which one."""
    if choice.random() < 0.5:  # while it works
        while not entered(folder) and run.poll() is None:
            time.sleep(0.01)
        time.sleep(choice.random())
    else:  # while it starts
        wanted = choice.randrange(1, 5)
        until = time.monotonic() + choice.random() * 4
        while len(processes(mark)) < wanted and time.monotonic() < until and run.poll() is None:
            time.sleep(0.002)
        time.sleep(choice.random() * 0.3)
    there = processes(mark)
    if not there:
        return "nobody"
    pid = choice.choice(sorted(there))
    os.kill(pid, signal.SIGKILL)
    return part_of(there[pid])


def gone(mark: str) -> bool:
    return not processes(mark)


def wait_until(what: Any, why: str) -> None:
    deadline = time.monotonic() + 300  # for machines under load: what is promised is measured, not waited for
    while not what():
        assert time.monotonic() < deadline, why
        time.sleep(0.02)


def records(folder: Path) -> list[RunRecord]:
    if not (folder / ".grip" / "runs.sqlite").is_file():
        return []
    try:
        with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
            return reader.runs()
    except GripError:
        return []  # it was killed as it made the file


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(DEATHS))
def test_whichever_process_is_killed_the_run_is_what_is_said(
    tmp_path: Path, seed: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    choice, mark = random.Random(seed), f"{os.getpid()}-{seed}"
    simulated = seed % 3 == 2
    (tmp_path / "waits.yaml").write_text(WAITS)
    (tmp_path / "moves.yaml").write_text(MOVES)
    (tmp_path / "grip.yaml").write_text("grip: 1\n" + (SIMULATED if simulated else ""))
    if simulated:
        pytest.importorskip("sapien")
    run = begin(tmp_path, "moves.yaml" if simulated else "waits.yaml", "sim" if simulated else "fake", mark)
    killed = kill_one(tmp_path, run, mark, choice)
    if killed == "planner" or (killed == "other" and simulated):
        time.sleep(0.2)  # it goes on with another one
        if run.poll() is None:
            run.send_signal(signal.SIGINT)
    elif killed == "nobody":
        run.send_signal(signal.SIGINT)
    wait_until(lambda: run.poll() is not None, "the parent ends")
    wait_until(lambda: gone(mark), f"nobody is left behind: {processes(mark)}")
    said = (tmp_path / "said").read_text()
    assert "Traceback" not in said, (killed, said)
    check(tmp_path, killed, said, monkeypatch, capsys)


def check(
    folder: Path, killed: str, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """See that the run is said to be what it is, by every verb, and can be resumed where that is promised."""
    monkeypatch.chdir(folder)
    found = records(folder)
    if not found:
        return  # it was killed before there was a run
    (record,) = found
    assert record.status not in ("running", "lost"), (killed, said)
    if killed in ("parent", "child"):
        assert record.status in ("died", "error"), (killed, record.status, said)
    capsys.readouterr()
    assert main(["runs"]) == 0
    assert record.status in capsys.readouterr().out
    assert main(["replay", "last", "--speed", "0"]) == 0, "it ends by itself"
    shown = capsys.readouterr().out
    with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
        events = reader.events(record.id)
    if record.status == "died":
        assert f"grip run --resume {record.id}" in shown
    if killed not in ("parent", "child"):
        return
    begun = any(event.event == "enter" for event in events)
    status = main(["run", "--resume", "last", "--yes", "--json", "--in-process"])
    resumed = capsys.readouterr()
    if not begun:
        assert (status, "died before it began" in resumed.err) == (1, True), resumed.err
    else:
        assert status == 0, (killed, resumed.err)
        last: Mapping[str, Any] = json.loads(resumed.out.splitlines()[-1])
        assert last["status"] == "success"


@pytest.mark.slow
def test_a_run_whose_page_is_killed_has_died(tmp_path: Path) -> None:
    (tmp_path / "waits.yaml").write_text(WAITS)
    mark = f"{os.getpid()}-page"
    command = [sys.executable, "-m", "grip_bt.cli", "run", "waits.yaml", "--robot", "fake", "--control"]
    page = f"import subprocess, sys; subprocess.run({command!r}, stdin=subprocess.PIPE); sys.stdin.read()"
    page = page.replace("subprocess.run", "p = subprocess.Popen")  # it holds the commands' end, and is killed
    page_process = subprocess.Popen(
        [sys.executable, "-c", page],
        cwd=tmp_path,
        env={**os.environ, MARK: mark},
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
    )
    wait_until(lambda: entered(tmp_path), "it begins")
    page_process.kill()
    page_process.communicate()
    wait_until(lambda: records(tmp_path)[0].status != "running", "its end is known")
    assert records(tmp_path)[0].status == "died"
    wait_until(lambda: gone(mark), f"nobody is left behind: {processes(mark)}")


@pytest.mark.slow
def test_a_killed_parent_leaves_a_journal_that_ends_where_it_was_killed(tmp_path: Path) -> None:
    (tmp_path / "waits.yaml").write_text(WAITS)
    mark = f"{os.getpid()}-parent"
    run = begin(tmp_path, "waits.yaml", "fake", mark)
    wait_until(lambda: entered(tmp_path), "it begins")
    run.kill()
    run.wait()
    wait_until(lambda: records(tmp_path)[0].status != "running", "its end is known")
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        events = reader.events(reader.runs()[0].id)
    assert events[-1].event == "run_ended"
    assert events[-1].data["status"] == "died"
    assert not [event for event in events if event.event == "interrupted" or event.data.get("state") == "stopping"]
    wait_until(lambda: gone(mark), f"nobody is left behind: {processes(mark)}")


@pytest.mark.slow
def test_a_planner_that_was_killed_is_told_and_the_run_goes_on(tmp_path: Path) -> None:
    pytest.importorskip("sapien")
    mark = f"{os.getpid()}-planner"
    (tmp_path / "moves.yaml").write_text(MOVES)
    (tmp_path / "grip.yaml").write_text("grip: 1\n" + SIMULATED)
    run = begin(tmp_path, "moves.yaml", "sim", mark)
    wait_until(lambda: entered(tmp_path), "the run begins")
    (planner,) = (pid for pid, command in processes(mark).items() if part_of(command) == "planner")
    os.kill(planner, signal.SIGKILL)
    words = f"process {planner} was ended by SIGKILL (Killed); process "
    wait_until(lambda: words in (tmp_path / "said").read_text(), "the death is told")
    (record,) = records(tmp_path)
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        before = reader.count(record.id)
        wait_until(lambda: reader.count(record.id) > before + 3, "the task goes on")
        said = [event for event in reader.events(record.id) if event.event == "message" and event.path == "/"]
        assert [event.data["part"] for event in said] == ["planner"]
        assert said[0].data["text"].startswith(f"planner: {words}")
    run.send_signal(signal.SIGINT)
    wait_until(lambda: run.poll() is not None, "the parent ends")
    wait_until(lambda: gone(mark), "nobody is left behind")
    assert records(tmp_path)[0].status == "stopped"
