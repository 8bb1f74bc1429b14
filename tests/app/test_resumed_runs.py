"""Runs that are killed with SIGKILL and gone on with by `grip run --resume`; and runs that others are forked from."""

from __future__ import annotations

import io
import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import fields
from pathlib import Path

import pytest

from grip_bt.app.runs import execute
from grip_bt.app.runs.execute import RunOptions
from grip_bt.app.runs.replay import find_run
from grip_bt.cli.__main__ import main
from grip_bt.runtime import JournalReader

KILLS = int(os.environ.get("GRIP_FUZZ_RESUME_KILLS", "2"))
TASK = """\
grip: 1
name: sums
data:
  total: {type: int, value: 0}
  items: {type: "list[int]", value: [1, 2, 3, 4, 5, 6]}
  waited: {type: bool, value: false}
root:
  kind: parallel
  children:
    count:
      kind: for_each
      items: items
      item: one
      child:
        step:
          kind: sequence
          children:
            pause: {node: flow/wait, with: {seconds: 0.15}}
            add: {node: flow/compute, with: {expression: a + b}, in: {a: total, b: one}, out: {value: total}}
    attempts:
      kind: fallback
      children:
        tries:
          kind: retry
          times: 3
          child:
            fail_slowly:
              kind: sequence
              children:
                wait: {node: flow/wait, with: {seconds: 0.2}}
                fail: {node: flow/fail, with: {code: no_plan}}
        limit:
          kind: timeout
          seconds: 0.3
          child:
            sleep: {node: flow/wait, with: {seconds: 60}}
        mend: {node: flow/set, with: {value: true}, out: {value: waited}}
"""
PICK = """\
grip: 1
name: pick
data: {tries: {type: int, value: 0}}
root:
  kind: sequence
  children:
    count: {node: flow/compute, with: {expression: a + 1}, in: {a: tries}, out: {value: tries}}
    act:
      kind: fallback
      children:
        first: {node: flow/fail, with: {code: no_ik}}
        second: {node: flow/wait_until, with: {expression: a > 0}, in: {a: tries}}
    last: {node: flow/succeed}
"""
MANIFEST = """\
id: my/move
doc: Moves something for a while.
implementation: move.py:Move
"""
MOVE = """\
from grip_bt.nodes import Leaf


class Move(Leaf):
    def initialise(self):
        self.until = self.context.clock.now() + 0.5
        self.context.wake_at(self.until)

    def update(self):
        return self.end() if self.context.clock.now() >= self.until else self.running()
"""


def grip(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "grip_bt.cli", *words]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=600, stdin=subprocess.DEVNULL)


def kill_in_the_middle(folder: Path, task: str, seconds: float, *words: str) -> str:
    """Start a run, kill its processes so many seconds after its first events, and return its id.

    Where the machine is so busy that the run has ended before it is killed, another one is killed earlier.
    """
    deadline = time.monotonic() + 600
    while True:
        run = _killed(folder, task, seconds, *words)
        with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
            while run is not None and reader.run(run).status == "running":  # it may take a moment to die
                assert time.monotonic() < deadline, "a run outlives SIGKILL"
                time.sleep(0.01)
            if run is not None and reader.run(run).status == "died":
                return run
        assert time.monotonic() < deadline, "no run could be killed before it ended"
        seconds /= 2


def _killed(folder: Path, task: str, seconds: float, *words: str) -> str | None:
    """Return the id of a run that was killed; None where it ended before it could be."""
    journal = folder / ".grip" / "runs.sqlite"
    before = _blocks(journal)
    command = [sys.executable, "-m", "grip_bt.cli", "run", task, *words]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 600
    while _blocks(journal) == before and process.poll() is None:
        assert time.monotonic() < deadline, "nothing happens"
        time.sleep(0.01)
    time.sleep(seconds)
    if process.poll() is not None:
        return None
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    with JournalReader(journal) as reader:
        return find_run(reader, "last")


def _blocks(journal: Path) -> int:
    try:
        with closing(sqlite3.connect(f"file:{journal}?mode=ro", uri=True)) as database:
            (count,) = database.execute("SELECT count(*) FROM blocks").fetchone()
            return int(count)
    except sqlite3.Error:
        return 0


def test_whatever_makes_a_run_go_otherwise_is_recorded_for_resuming_it() -> None:
    shown = {"picture", "video", "view", "motion", "journal", "resume"}
    assert {field.name for field in fields(RunOptions)} - shown == execute._RECORDED


@pytest.mark.slow
@pytest.mark.parametrize("target", ["bt", "sm"])
@pytest.mark.parametrize("number", range(KILLS))
def test_a_run_that_was_killed_comes_to_the_same_end(
    tmp_path: Path, target: str, number: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sums.yaml").write_text(TASK)
    run = kill_in_the_middle(tmp_path, "sums.yaml", random.Random(number).uniform(0.02, 0.9), "--as", target)
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        before = reader.events(run)
    if number == 0:  # as users do; the others without processes of their own, which is quicker and ends alike
        done = grip("run", "--resume", "last", cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
    else:
        assert main(["run", "--resume", "last", "--in-process"]) == 0, capsys.readouterr()
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        events = reader.events(run)
        assert (reader.run(run).status, reader.run(run).outcome) == ("success", "success")
        assert events[: len(before)] == before, "nothing that was committed has changed"
        assert reader.value(reader.variables(run)["total"]) == 21
        assert reader.value(reader.variables(run)["waited"]) is True
    ends = [(e.path, e.outcome, e.code) for e in events if e.event == "exit"]
    assert ends.count(("count/step/add", "success", None)) == 6, "each item was added once"
    assert ends.count(("attempts/tries/fail_slowly/fail", "failure", "no_plan")) == 3, "attempts are counted on"
    assert ends.count(("attempts/limit", "failure", "time_out")) == 1
    began = next(e.t for e in events if (e.path, e.event) == ("attempts/limit", "enter"))
    over = next(e.t for e in events if (e.path, e.event) == ("attempts/limit", "exit"))
    assert 0.3 <= over - began < 120, "the time while there was no process doesn't count"
    assert all(a.t <= b.t + 1e-6 for a, b in zip(events, events[1:], strict=False)), "the clock goes on"


@pytest.mark.slow
def test_a_motion_that_was_under_way_is_asked_about(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())  # nobody can be asked
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "nodes" / "move").mkdir(parents=True)
    (tmp_path / "nodes" / "move" / "manifest.yaml").write_text(MANIFEST)
    (tmp_path / "nodes" / "move" / "move.py").write_text(MOVE)
    (tmp_path / "task.yaml").write_text("grip: 1\nname: moves\nroot: {node: my/move}\n")
    run = kill_in_the_middle(tmp_path, "task.yaml", 0.1)
    capsys.readouterr()
    assert main(["run", "--resume", run]) == 1
    asked = capsys.readouterr().err
    assert "resuming needs your confirmation (or pass --yes):" in asked
    assert "/: my/move was under way, and its progress is unknown; it is started again" in asked
    assert main(["run", "--resume", run, "--set-outcome", "/=failure.dropped", "--json", "--in-process"]) == 3
    assert json.loads(capsys.readouterr().out)["code"] == "dropped"
    assert main(["run", "--resume", run, "--yes"]) == 1
    assert f"run {run} cannot be resumed: it has ended: failure" in capsys.readouterr().err


@pytest.fixture
def forked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Path:
    """A project in which `pick` has run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pick.yaml").write_text(PICK)
    assert main(["run", "pick.yaml", "--in-process", "--robot", "fake"]) == 0
    capsys.readouterr()
    return tmp_path


def outcomes(run: str = "last") -> list[tuple[str, str | None, str | None]]:
    with JournalReader(".grip/runs.sqlite") as reader:
        events = reader.events(find_run(reader, run))
    assert [event.seq for event in events] == list(range(1, len(events) + 1))
    return [(e.path, e.outcome, e.code) for e in events if e.event == "exit"]


def test_a_fork_repeats_what_was_recorded_and_goes_on(forked: Path) -> None:
    whole = outcomes()
    assert main(["run", "--fork", "last", "--at", "act/first", "--in-process"]) == 0
    assert outcomes() == whole
    with JournalReader(".grip/runs.sqlite") as reader:
        new, old = reader.runs()
        started = reader.events(new.id)[0]
        assert started.data["forked_from"]["run"] == old.id
        assert reader.value(reader.variables(new.id)["tries"]) == 1


def test_a_fork_with_another_result_takes_another_way(forked: Path) -> None:
    words = ["run", "--fork", "last", "--at", "act/first", "--set-outcome", "act/second=failure.stuck", "--in-process"]
    assert main(words) == 3
    assert outcomes()[-3:] == [
        ("act/second", "failure", "stuck"),
        ("act", "failure", "stuck"),
        ("/", "failure", "stuck"),
    ]
    # and a fork of that fork repeats the result that was set
    assert main(["run", "--fork", "last", "--at", "act", "--in-process"]) == 3
    assert outcomes()[-3][0] == "act/second"


def test_a_fork_with_another_value_goes_on_with_it(forked: Path) -> None:
    assert main(["run", "--fork", "last", "--at", "count:enter", "--set", "tries=41", "--in-process"]) == 0
    with JournalReader(".grip/runs.sqlite") as reader:
        assert reader.value(reader.variables(reader.runs()[0].id)["tries"]) == 42
    assert main(["run", "--fork", "last", "--at", "count", "--in-process"]) == 0
    with JournalReader(".grip/runs.sqlite") as reader:
        assert reader.value(reader.variables(reader.runs()[0].id)["tries"]) == 42


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--at", "act/frist"], "unknown place in the run 'act/frist'; did you mean 'act/first'?"),
        (["--at", "act", "--set-outcome", "act=success"], "how a container ends follows from its leaves; set one of"),
        (["--at", "act", "--set-outcome", "last=lost"], "unknown outcome 'lost'"),
        (["--at", "act", "--set-outcome", "lst=success"], "unknown leaf 'lst'; did you mean 'last'?"),
        (["--at", "act", "--set-outcome", "last"], "isn't NODE=OUTCOME"),
        (["--at", "act", "--set", "tires=1"], "unknown variable 'tires'; did you mean 'tries'?"),
        (["--at", "act", "--set", "tries=one"], "tries"),
    ],
)
def test_what_cant_be_forked_says_why(
    forked: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert main(["run", "--fork", "last", "--in-process", *words]) == 1
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "a task file is needed"),
        (["--fork", "last"], "--fork RUN and --at PLACE go together"),
        (["pick.yaml", "--set-outcome", "a=success"], "--set-outcome goes with --resume or --fork"),
    ],
)
def test_options_that_dont_go_together_are_usage_errors(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    with pytest.raises(SystemExit) as end:
        main(["run", *words])
    assert end.value.code == 2
    assert said in capsys.readouterr().err


def test_a_run_that_has_ended_is_forked_instead(forked: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--resume", "last"]) == 1
    assert "cannot be resumed: it has ended: success. As a new run" in capsys.readouterr().err


def test_a_run_whose_task_was_changed_is_what_it_was(forked: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (forked / "pick.yaml").write_text(PICK.replace("no_ik", "no_plan"))
    whole = outcomes()
    assert main(["run", "--fork", "last", "--at", "count", "--in-process"]) == 0
    assert "pick.yaml has changed since; the run continues with the recorded task" in capsys.readouterr().err
    assert outcomes() == whole
