"""Times and reasons out of journals, as the commands show them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from grip_bt.app.runs.replay import Timing, failures, timings
from grip_bt.cli.__main__ import main
from grip_bt.runtime import Event

TASK = """
grip: 1
name: tables
root:
  kind: retry
  times: 3
  child:
    both:
      kind: fallback
      children:
        look: {node: hand/open}
        other: {node: flow/fail, with: {code: tired}}
"""


def event(t: float, path: str, kind: str, outcome: str | None = None, code: str | None = None) -> Event:
    return Event(1, t, 0.0, path, kind, outcome, code, {"message": f"{code}!"} if code else {})


@pytest.fixture
def task(tmp_path: Path) -> str:
    (tmp_path / "tables.yaml").write_text(TASK)
    return str(tmp_path / "tables.yaml")


def test_activations_are_timed_and_halted_ones_are_counted_apart() -> None:
    events = [
        *(event(0.0, "a", "enter"), event(1.0, "a", "exit", "success")),
        *(event(2.0, "a", "enter"), event(5.0, "a", "exit", "success")),
        *(event(5.0, "b", "enter"), event(6.0, "b", "interrupted")),
        *(event(6.0, "a", "enter"), event(8.0, "a", "exit", "failure", "no_ik")),
        event(9.0, "b", "interrupted"),
    ]
    assert timings(events) == [Timing("a", 3, 0, 6.0, 2.0, 3.0), Timing("b", 0, 1, 0.0, 0.0, 0.0)]


def test_a_reason_is_counted_where_it_arose() -> None:
    events = []
    for _ in range(2):
        events += [event(0, p, "enter") for p in ("/", "s", "s/a")]
        events += [event(0, p, "exit", "failure", "no_ik") for p in ("s/a", "s", "/")]
    assert failures(events) == {("s/a", "no_ik"): (2, "no_ik!")}


def test_the_summary_of_a_run_says_why_leaves_failed_though_the_task_recovered(task: str, capfd) -> None:
    mocked = "both/look=failure.time_out,failure.time_out,success"
    assert main(["run", task, "--mock", mocked]) == 0
    said, *reasons = capfd.readouterr().out.splitlines()
    assert said.startswith("success: success; ")
    assert reasons == ["    2x both/look: time_out: mocked", "    2x both/other: tired"]


def test_the_times_of_a_run_are_listed(task: str, capfd, monkeypatch) -> None:
    assert main(["run", task, "--mock", "both/look=success", "--json"]) == 0
    run = json.loads(capfd.readouterr().out)["run"]
    monkeypatch.chdir(Path(task).parent)
    assert main(["runs", run, "--timing"]) == 0
    head, *rows = capfd.readouterr().out.splitlines()
    assert head.split() == ["node", "count", "halted", "total", "[s]", "median", "[s]", "max", "[s]"]
    assert [row.split()[:3] for row in rows] == [[p, "1", "0"] for p in ("/", "both", "both/look")]
    assert main(["runs", "last", "--timing", "--json"]) == 0
    assert {row["path"] for row in json.loads(capfd.readouterr().out)} == {"/", "both", "both/look"}
