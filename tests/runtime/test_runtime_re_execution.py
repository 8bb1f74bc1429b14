"""What a recorded run says to the run that does it again, where only some runs would show it."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.common import Status
from runtime_world import CATALOG, Waiting
from timed import ManualClock

from grip_bt.compilers import to_tree
from grip_bt.runtime import Event, ReExecution, RunContext, Runner, WallClock
from grip_bt.runtime.recording import RecordedClock, Recording
from grip_bt.task.model import Task

TASK = {
    "grip": 1,
    "name": "t",
    "data": {"n": {"type": "int", "value": 0}},
    "root": {"kind": "sequence", "children": {"a": {"node": "test/wait"}}},
}
BEGUN = (("/", "enter"), ("a", "enter"))


def events(*said: tuple[Any, ...]) -> list[Event]:
    """Return events 0.1 s apart: path, kind and, where there are any, outcome, code and data."""
    rows = [(*event, *(None, None, {})[len(event) - 2 :]) for event in said]
    return [Event(n + 1, 0.1 * (n + 1), 0.0, *row) for n, row in enumerate(rows)]


def begun_again(*said: tuple[Any, ...], **options: Any) -> tuple[ReExecution, Any]:
    """Return a task that is to do a recorded run again, before its first tick."""
    task = Task.model_validate(TASK)
    compiled = to_tree(task, CATALOG, leaf_factory=lambda path, node, face: Waiting(path, path, face, {}, {}))
    re_execution = ReExecution(compiled, events(*said), lambda event: 7, ManualClock(), **options)
    compiled.prepare(SimpleNamespace(wake=lambda: None, preempt_requested=False))
    re_execution.install(lambda: None)
    return re_execution, compiled


def test_a_run_of_which_nothing_was_recorded_is_live_at_its_first_tick() -> None:
    re_execution, _ = begun_again()
    assert not re_execution.live
    re_execution.turn()
    assert re_execution.live


def test_what_was_set_by_hand_is_set_again_and_told_to_who_watches() -> None:
    written: dict[str, Any] = {"set": True, "scope": "", "variable": "n"}
    re_execution, compiled = begun_again(("/", "write", None, None, written), *BEGUN)
    cell, heard = compiled.data[""].cells["n"], []
    cell.watchers.append(lambda: heard.append(cell.value))
    re_execution.turn()
    assert (cell.value, heard) == (7, [7])


def test_a_leaf_ends_as_somebody_decided_who_gave_no_outputs() -> None:
    re_execution, compiled = begun_again(*BEGUN, results={"a": ("success", "")})
    assert (
        Runner(compiled, RunContext(re_execution.clock), re_execution=re_execution, poll=0.01).run().status == "success"
    )


def test_a_leaf_that_is_halted_before_the_recording_says_how_it_ended_is_told_what_it_was() -> None:
    told: list[str] = []
    re_execution, compiled = begun_again(*BEGUN, ("later", "enter"))
    compiled.leaves["a"].replay_ended = told.append
    re_execution.turn()
    for path in ("/", "a"):
        re_execution.recording.happened(path, "enter")
    compiled.root.tick_once()
    compiled.root.stop(Status.INVALID)
    assert (compiled.leaves["a"].status, len(told)) == (Status.INVALID, 1)


def test_time_stands_still_and_goes_on_with_the_clock_of_the_run() -> None:
    clock = WallClock()
    relived = RecordedClock(clock, Recording((), ()))
    relived.go()
    relived.pause()
    stood = relived.now()
    assert relived.now() == stood
    relived.resume()
    time.sleep(0.001)
    assert relived.now() > stood


def test_interruptions_that_nobody_explains_are_left_out_and_their_leaves_are_under_way() -> None:
    recording = Recording(events(*BEGUN, ("a", "interrupted"), ("/", "interrupted")), ["a"])
    recording.begin()
    recording.happened("/", "enter")
    assert not recording.set_aside(), "an enter is left"
    recording.happened("a", "enter")
    assert not recording.complete
    assert recording.set_aside()
    assert recording.complete
    assert recording.under_way["a"].seq == 2
    assert not recording.happened("a", "interrupted"), "it is new"


def test_a_container_has_said_before_an_event_what_it_said_itself() -> None:
    recording = Recording(events(("all", "enter"), ("all", "message"), ("b", "enter"), ("b", "exit", "success")), ["b"])
    assert [recording.said_before("all", seq) for seq in (1, 2, 3, 4)] == [False, False, True, True]
    assert not recording.said_before("b", 4), "only others have said something"


@pytest.mark.parametrize(
    ("end", "over"),
    [
        (("slow", "interrupted"), False),
        (("slow", "exit", "success"), False),
        (("slow", "exit", "failure", "broken"), False),
        (("slow", "exit", "failure", "time_out"), True),
    ],
)
def test_only_a_timeout_that_ended_its_child_was_over(end: tuple[Any, ...], over: bool) -> None:
    recording = Recording(events(("slow", "enter"), ("slow/a", "enter"), ("slow/a", "interrupted"), end), ["slow/a"])
    recording.begin()
    recording.happened("slow", "enter")
    recording.happened("slow/a", "enter")
    assert recording.halted("slow", ["time_out"]) == over


def test_a_cooldown_refuses_its_child_where_it_did_and_its_time_is_that_of_the_run() -> None:
    recording = Recording(events(("rest", "enter"), ("rest", "exit", "failure", "cooldown")), ["rest/a"])
    clock = RecordedClock(ManualClock(), recording)
    recording.begin()
    recording.happened("rest", "enter")
    assert clock.now() == pytest.approx(0.1)
    assert not clock.rested("rest", ["rest/a"], 0.05), "it refuses its child, as was recorded"
