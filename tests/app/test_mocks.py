"""Scripts in place of nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.mocks import read_mocks
from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.runtime import JournalReader

TASK = """
grip: 1
name: m
outcomes: {done: success, gave_up: failure}
data: {n: {type: int, value: 0}}
root:
  kind: retry
  times: 3
  on: {success: done, failure: gave_up}
  child:
    attempt:
      kind: sequence
      children:
        look: {node: arm/move_to_named, with: {state: home}}
        pick:
          kind: state_machine
          initial: try
          outcomes: {held: success, missed: failure}
          children: {try: {node: hand/close, on: {success: held, failure: missed}}}
"""


@pytest.fixture
def run(tmp_path: Path) -> Any:
    file = tmp_path / "m.yaml"
    file.write_text(TASK.replace("arm/move_to_named, with: {state: home}", "hand/open"))

    def run(*mocks: str, target: str = "bt", text: str = "") -> Any:
        mocked = tmp_path / "mocks.yaml"
        mocked.write_text(text)
        options = RunOptions(target=target, mocks=read_mocks(mocked if text else None, mocks))  # type: ignore[arg-type]
        with open_session(file, options) as session:
            result = session.runner.run()
            session.runner.journal.flush()
            with JournalReader(session.journal) as reader:
                events = reader.events(session.runner.run_id)
        return result, events, session

    return run


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_leaves_and_containers_play_their_scripts_without_a_robot(run: Any, target: str) -> None:
    result, events, _ = run("attempt/look=failure.time_out,success", "/attempt/pick=missed,held", target=target)
    assert (result.status, result.outcome) == ("success", "done")
    ends = [(e.path, e.outcome, e.code) for e in events if e.event == "exit"]
    look, pick = ([(o, c) for p, o, c in ends if p == path] for path in ("attempt/look", "attempt/pick"))
    assert look == [("failure", "time_out"), ("success", None), ("success", None)]
    assert [o for o, _ in pick] == ["missed", "held"]


def test_a_file_says_outputs_durations_and_counts(run: Any) -> None:
    text = """
mocks:
  attempt/look: success
  attempt/pick:
    - {outcome: missed, code: slipped, message: too wet, seconds: 0.02, times: 2}
    - {outcome: held, outputs: {n: 7}}
"""
    result, events, session = run(text=text)
    assert result.status == "success"
    assert result.duration >= 0.04
    picks = [e for e in events if e.path == "attempt/pick" and e.event == "exit"]
    assert [(e.outcome, e.code) for e in picks] == [("missed", "slipped"), ("missed", "slipped"), ("held", None)]
    assert session.runner.compiled.data.snapshot()["", "n"] == 7


def test_the_command_line_replaces_what_the_file_says_of_a_node(run: Any) -> None:
    text = "mocks: {attempt/look: success, attempt/pick: missed}"
    assert run("attempt/pick=held", text=text)[0].outcome == "done"


@pytest.mark.parametrize(
    ("mock", "said"),
    [
        ("attempt/lok=success", "a mock: unknown node 'attempt/lok'; did you mean 'attempt/look'"),
        ("attempt/pick=success", "mock of attempt/pick: unknown outcome 'success'.*available: held, missed"),
        (
            "attempt/look=failure.no_sucess",
            "mock of attempt/look: unknown failure code .no_sucess. .available: aborted, canceled",
        ),
    ],
)
def test_what_is_not_in_the_task_is_refused_with_what_is(run: Any, mock: str, said: str) -> None:
    with pytest.raises(UnknownNameError, match=said):
        run(mock)


def test_outputs_are_checked_and_scripts_have_to_be_scripts(run: Any) -> None:
    with pytest.raises(UnknownNameError, match="mock of attempt/pick: unknown output 'm'.*available: n"):
        run(text="mocks: {attempt/pick: {outcome: held, outputs: {m: 1}}}")
    with pytest.raises(DocumentError, match="isn't NODE=SCRIPT"):
        read_mocks(None, ["look"])
    with pytest.raises(DocumentError, match="times"):
        run(text="mocks: {attempt/pick: {outcome: held, times: 0}}")
