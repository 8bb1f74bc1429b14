"""Leaves of a parallel are asked to come to an end again when they restart in a run that is gone on with."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.replay import find_run
from grip_bt.cli.__main__ import main
from grip_bt.nodes.node import Observer
from grip_bt.runtime import JournalReader

TASK = """\
grip: 1
name: both
root:
  kind: parallel
  cancel: join
  children:
    one: {node: my/patient}
    two: {node: my/patient}
"""
MANIFEST = """\
id: my/patient
doc: Comes to an end only when asked.
implementation: patient.py:Patient
codes: [preempted, time_out]
resume: restart
"""
PATIENT = """\
from grip_bt.nodes import Leaf


class Patient(Leaf):
    def initialise(self):
        self.at_first = self.context.preempt_requested
        self.until = self.context.clock.now() + 30.0
        self.context.wake_at(self.until)

    def update(self):
        if self.context.preempt_requested and not self.at_first:
            return self.fail("preempted", "as asked")
        if self.context.clock.now() >= self.until:
            return self.fail("time_out", "nobody asked")
        return self.running("runs")
"""


class AskWhenBothRun(Observer):
    """Asks the run to come to an end when two leaves say that they run."""

    def __init__(self, ask: Callable[[], None]) -> None:
        self.begun: set[str] = set()
        self.ask = ask

    def message(self, path: str, text: str) -> None:
        self.begun.add(path)
        if {"one", "two"} <= self.begun:
            threading.Thread(target=self.ask).start()


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_leaves_of_a_parallel_are_asked_again_when_they_restart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], target: str
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "nodes" / "patient"
    folder.mkdir(parents=True)
    Path("grip.yaml").write_text("grip: 1\n")
    Path("both.yaml").write_text(TASK)
    (folder / "manifest.yaml").write_text(MANIFEST)
    (folder / "patient.py").write_text(PATIENT)
    with open_session("both.yaml", RunOptions(target=target, robot="fake")) as session:
        session.runner.observe(AskWhenBothRun(session.runner.request_preempt))
        assert session.runner.run().status == "failure"
    with JournalReader(Path(".grip/runs.sqlite")) as reader:
        asked = next(e for e in reader.events(find_run(reader, "last")) if e.event == "preempt_requested")
    fork = ["run", "--fork", "last", "--at", str(asked.seq), "--in-process", "--yes"]
    assert main(fork) == 3, capsys.readouterr().err
    with JournalReader(Path(".grip/runs.sqlite")) as reader:
        events = reader.events(find_run(reader, "last"))
    ends = {e.path: e.code for e in events if e.event == "exit"}
    assert (ends["one"], ends["two"]) == ("preempted", "preempted")
