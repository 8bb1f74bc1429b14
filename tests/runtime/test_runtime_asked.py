"""Requests to come to an end are in the journal, and count as they did when a run is resumed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from runtime_world import TARGETS, Started, leaf

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.nodes import OperationLeaf
from grip_bt.runtime import Event, Journal, JournalReader, ReExecution, RunContext, Runner, WallClock
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

CATALOG = Catalog([Manifest(id="test/move", doc="Moves until it is told.", implementation="tests:Leaf")])
TASK = {"kind": "fallback", "children": {"reach": {"node": "test/move"}, "retreat": {"node": "test/move"}}}
BEGUN = (("/", "enter"), ("reach", "enter"))
ASKED = ("/", "preempt_requested")
RETREATING = (("reach", "exit", "failure", "preempted"), ("retreat", "enter"))


class Moving(OperationLeaf):
    """`reach` ends when it is cancelled, `retreat` by itself, a moment later."""

    def start(self) -> Operation[Any]:
        operation: Operation[Any] = Operation(lambda: operation.fail(CanceledError("held")))
        self.looks = 0
        return operation

    def waiting(self, operation: Operation[Any]) -> str:
        self.looks += 1
        if self.path == "retreat" and self.looks == 3:
            operation.succeed(None)
        return "moving"


def ends_of(target: Any, file: Path, said: tuple[tuple[str, ...], ...]) -> list[tuple[str, str | None, str | None]]:
    """Go on with a run that had come so far, and return how its nodes then end."""
    task = Task.model_validate({"grip": 1, "name": "t", "root": TASK})
    compiled = target(task, CATALOG, leaf_factory=lambda path, node, face: Moving(path, path, face, {}, {}))
    more = ((*event, None, None)[:4] for event in said)
    events = [Event(n + 1, 0.1 * n, 0.0, *event, {}) for n, event in enumerate(more)]
    re_execution = ReExecution(compiled, events, lambda event: None, WallClock())
    with Journal(file) as journal:
        runner = Runner(compiled, RunContext(re_execution.clock), journal=journal, re_execution=re_execution, poll=0.01)
        result = runner.run()
        assert result.status == "success", result
    with JournalReader(file) as reader:
        return [(e.path, e.outcome, e.code) for e in reader.events(runner.run_id or "") if e.event == "exit"]


@pytest.mark.parametrize("target", TARGETS)
def test_a_request_is_in_the_journal_before_what_comes_of_it(target: Any, tmp_path: Path) -> None:
    with Journal(tmp_path / "runs.sqlite") as journal:
        run = Started(target, leaf("obey"), journal=journal, poll=0.01).start()
        run.wait_tick("/")
        run.runner.request_preempt()
        run.join()
    with JournalReader(tmp_path / "runs.sqlite") as reader:
        kinds = [(e.path, e.event) for e in reader.events(run.runner.run_id or "")]
    assert kinds.index(("/", "enter")) < kinds.index(ASKED) < kinds.index(("/", "exit"))


@pytest.mark.parametrize("target", TARGETS)
def test_a_motion_that_was_asked_to_end_is_asked_again(target: Any, tmp_path: Path) -> None:
    ends = ends_of(target, tmp_path / "runs.sqlite", (*BEGUN, ASKED))
    assert ends == [("reach", "failure", "preempted"), ("retreat", "success", None), ("/", "success", None)]


@pytest.mark.parametrize("target", TARGETS)
def test_recovery_that_had_begun_after_the_request_is_not_cancelled(target: Any, tmp_path: Path) -> None:
    ends = ends_of(target, tmp_path / "runs.sqlite", (*BEGUN, ASKED, *RETREATING))
    assert ends == [("retreat", "success", None), ("/", "success", None)]
