"""The planning scene, named messages and the simulated world of a run that is gone on with, or forked."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from grip_bt.app.runs.replay import find_run
from grip_bt.cli.__main__ import main
from grip_bt.commanders.description.load import build_robot
from grip_bt.runtime import JournalReader

TASK = """\
grip: 1
name: kept
data:
  at: Pose
  number: {type: int, value: 7}
  found: Any
  names: "list[str]"
  left: Any
root:
  kind: sequence
  children:
    make: {node: pose/make, with: {position: [0.5, 0.2, 0.1]}, out: {pose: at}}
    box: {node: scene/add_shape, with: {name: brick, shape: box, size: [0.1, 0.1, 0.2]}, in: {pose: at}}
    scene: {node: scene/snapshot, out: {snapshot: left}}
    keep: {node: messages/put, with: {store: notes, name: seven}, in: {value: number}}
    push: {node: messages/push, with: {store: notes}, in: {value: number}}
    wait: {node: flow/wait, with: {seconds: WAIT}}
    read: {node: messages/get, with: {store: notes, name: seven, type: int}, out: {value: found}}
    take: {node: messages/take, with: {store: notes, type: int}, out: {value: found}}
    gone: {node: scene/remove, with: {name: brick}}
    again: {node: scene/restore, in: {snapshot: left}}
    last: {node: scene/remove, with: {name: brick}}
"""
GRIP = """\
grip: 1
robot: panda_allegro
world: table
arms: {right: {group: arm, hand: hand}}
hands: {hand: {group: hand}}
"""


def grip(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "grip_bt.cli", *words]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=600, stdin=subprocess.DEVNULL)


def kill_once(folder: Path, there: str, *words: str) -> str:
    """Start a run, kill it when the journal has the event `there` (path:event), and return its id.

    Raises:
        ChildProcessError: it has ended before.
    """
    command = [sys.executable, "-m", "grip_bt.cli", "run", *words]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, start_new_session=True)
    path, _, kind = there.rpartition(":")
    journal, deadline = folder / ".grip" / "runs.sqlite", time.monotonic() + 600
    while True:
        assert time.monotonic() < deadline, f"it didn't come to {there}"
        if process.poll() is not None:
            raise ChildProcessError("it ended too early")
        if journal.is_file():
            try:
                with JournalReader(journal) as reader:
                    run = find_run(reader, "last")
                    if any((e.path, e.event) == (path, kind) for e in reader.events(run)):
                        break
            except Exception:  # noqa: BLE001 - it is being made
                pass
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return run


def killed_while_it_waits(home: Path, target: str) -> tuple[Path, str]:
    """Return the folder and the id of a run that was killed in its wait, which is longer on a busy machine."""
    for seconds in (3.0, 30.0, 120.0):
        folder = home / f"{seconds:g}"
        folder.mkdir()
        (folder / "grip.yaml").write_text(GRIP)
        (folder / "kept.yaml").write_text(TASK.replace("WAIT", str(seconds)))
        with suppress(ChildProcessError):
            return folder, kill_once(folder, "wait:enter", "kept.yaml", "--robot", "fake", "--as", target)
    raise AssertionError("no run could be killed before it ended")


@pytest.mark.slow
@pytest.mark.parametrize("target", ["bt", "sm"])
def test_scene_and_messages_come_back_without_a_question(tmp_path: Path, target: str) -> None:
    folder, run = killed_while_it_waits(tmp_path, target)
    done = grip("run", "--resume", run, "--json", cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
        events = reader.events(run)
        assert reader.value(reader.variables(run)["found"]) == 7
        left = reader.value(reader.variables(run)["left"])
        assert left.objects["brick"].shape.size == (0.1, 0.1, 0.2)
    (resumed,) = (e for e in events if e.event == "run_resumed")
    assert set(resumed.data["restored"]) == {"scene", "messages"}
    kept = [(e.path, e.data["part"]) for e in events if e.event == "kept"]
    assert kept[:3] == [("box", "scene"), ("keep", "messages"), ("push", "messages")], "once for each change"
    at = next(i for i, e in enumerate(events) if e.event == "kept")
    assert (events[at + 1].path, events[at + 1].event) == ("box", "exit"), "before the end of the node that changed it"


def test_a_fork_begins_with_the_scene_and_the_messages_of_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("grip.yaml").write_text(GRIP)
    Path("kept.yaml").write_text(TASK.replace("WAIT", "0.01"))
    assert main(["run", "kept.yaml", "--in-process", "--robot", "fake"]) == 0, capsys.readouterr().err
    assert main(["run", "--fork", "last", "--at", "push", "--in-process"]) == 0, capsys.readouterr().err
    # before the message was put into the queue there is nothing to take
    assert main(["run", "--fork", "last", "--at", "keep", "--set-outcome", "push=success", "--in-process"]) == 3


def test_a_state_that_was_too_big_to_be_kept_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("grip.yaml").write_text(GRIP)
    Path("kept.yaml").write_text(TASK.replace("WAIT", "0.01"))
    from grip_bt.app.runs import execute
    from grip_bt.runtime import Journal

    monkeypatch.setattr(execute, "Journal", lambda file: Journal(file, largest_value=100))
    assert main(["run", "kept.yaml", "--in-process", "--robot", "fake"]) in (0, 3)
    capsys.readouterr()
    fork = ["run", "--fork", "last", "--at", "box", "--in-process"]
    assert main(fork) == 1
    said = capsys.readouterr().err
    assert "the scene cannot be restored to its state at event" in said
    assert "Fork it at an event before that" in said


FAKE = """\
grip: 1
name: fakes
root:
  kind: sequence
  children:
    close: {node: hand/posture, with: {posture: closed, seconds: 0.5}}
    go: {node: arm/jog, with: {linear: [0.0, 0.1, 0.1], seconds: 1.0}}
    show: {node: arm/teach, with: {name: shown}}
    wait: {node: flow/wait, with: {seconds: 30.0}}
    on: {node: arm/jog, with: {linear: [0.0, 0.1, 0.1], seconds: 1.0}}
    back: {node: arm/move_to_taught, with: {name: shown}}
"""


@pytest.mark.slow
def test_a_fake_robot_is_where_it_was_without_a_question(tmp_path: Path) -> None:
    (tmp_path / "grip.yaml").write_text(GRIP)
    (tmp_path / "fakes.yaml").write_text(FAKE)
    run = kill_once(tmp_path, "wait:enter", "fakes.yaml", "--robot", "fake")
    done = grip("run", "--resume", run, "--set-outcome", "wait=success", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        events = reader.events(run)
        kept = {e.path: reader.value(e) for e in events if e.event == "kept" and e.data["part"] == "fakes"}
    (resumed,) = (e for e in events if e.event == "run_resumed")
    assert "fakes" in resumed.data["restored"]
    went, on, back = (kept[path]["arms"]["right"] for path in ("go", "on", "back"))
    assert np.allclose((on - went)[-6:], [0, 0.1, 0.1, 0, 0, 0], atol=1e-3), "it went on from where it was"
    assert np.allclose(back, went), "and back to what was taught before"
    assert np.allclose(
        kept["back"]["hands"]["hand"], build_robot("panda_allegro").named_state("hand", "closed").position
    )


def test_fakes_are_put_back_to_where_they_were() -> None:
    from grip_bt.app.wiring.fake import FakeState
    from grip_bt.base.values import JointState, Pose
    from grip_bt.commanders.fake import FakeArm, FakeComponent, FakeHand

    def made() -> FakeState:
        hand = FakeHand(JointState(("finger",), np.zeros(1)), thing=JointState(("finger",), np.full(1, 0.6)))
        return FakeState({"a": FakeArm()}, {"h": hand}, {"c": FakeComponent([{"n": 0}, {"n": 1}, {"n": 2}])})

    first, second = made(), made()
    first.arms["a"].execute(first.arms["a"].plan(Pose([0.4, 0.1, 0.3])).result())
    first.hands["h"].move(JointState(("finger",), np.ones(1)), 0.5)
    first.components["c"].call({})
    second.put_back(first.kept())
    assert np.allclose(second.arms["a"].state().position, first.arms["a"].state().position)
    assert second.hands["h"].contacts() == first.hands["h"].contacts() != {}
    assert second.components["c"].call({}).result() == {"n": 1}
    with pytest.raises(ValueError, match="the state is of another robot: this one has the joints x, y, z"):
        second.put_back({**first.kept(), "arms": {"a": np.zeros(2)}})


MOVE = """\
grip: 1
name: moves
root:
  kind: sequence
  children:
    close: {node: hand/posture, with: {posture: closed, seconds: 0.5}}
    go: {node: arm/jog, with: {linear: [0.0, 0.1, 0.1], seconds: 1.0}}
    wait: {node: flow/wait, with: {seconds: 30.0}}
    back: {node: hand/posture, with: {posture: open, seconds: 0.5}}
"""


@pytest.mark.slow
@pytest.mark.sim
def test_a_simulated_world_is_where_it_was(tmp_path: Path) -> None:
    pytest.importorskip("sapien")
    (tmp_path / "grip.yaml").write_text(GRIP)
    (tmp_path / "moves.yaml").write_text(MOVE)
    run = kill_once(tmp_path, "wait:enter", "moves.yaml", "--robot", "sim")
    done = grip("run", "--resume", run, "--set-outcome", "wait=success", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads(done.stdout)["outcome"] == "success"
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        kept = [reader.value(e) for e in reader.events(run) if e.event == "kept" and e.data["part"] == "world"]
    assert len(kept) == 3
    closed, ready, opened = (np.asarray(state["positions"]) for state in kept)
    assert np.abs(opened[:7] - ready[:7]).max() < 0.01, "the arm is where it was before the process died"
    assert np.abs(ready - closed).max() > 0.1
    assert np.abs(opened - ready).max() > 0.3
