"""Times and reasons out of journals, as the commands show them."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.app.runs.replay import failures
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
