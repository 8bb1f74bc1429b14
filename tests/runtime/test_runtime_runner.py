"""Running either target: wakes, time, pause, stop, preempt requests, errors."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.common import Status
from runtime_world import TARGETS, Started, leaf
from timed import ManualClock

from grip_bt.base.errors import MissingPartError, NodeError, UnknownNameError
from grip_bt.compilers import to_machine
from grip_bt.runtime import RunContext, RunParts

both = pytest.mark.parametrize("target", TARGETS)
SEQUENCE = {"kind": "sequence", "children": {"a": leaf("end"), "w": leaf("wait")}}
FORKED = {"kind": "parallel", "cancel": "join", "children": {"v": leaf("wait"), "w": leaf("wait")}}


@both
def test_a_wake_alone_has_the_task_ticked(target: Any) -> None:
    run = Started(target, SEQUENCE, poll=None).start()
    run.wait_tick("w")
    run.leaves["w"].told.set()
    run.context.wake()
    result = run.join()
    assert (result.outcome, result.meaning, result.status) == ("success", "success", "success")
    assert run.leaves["w"].ticks == 2


@both
def test_a_wake_before_the_wait_is_not_lost(target: Any) -> None:
    run = Started(target, {"kind": "repeat", "times": 200, "child": {"w": leaf("work")}}, poll=None).start()
    assert run.join().status == "success"


@both
def test_a_leaf_that_wakes_nobody_is_polled(target: Any) -> None:
    run = Started(target, SEQUENCE, poll=0.005).start()
    run.wait_tick("w")
    run.leaves["w"].told.set()
    assert run.join().status == "success"


@both
def test_a_timeout_needs_no_polling(target: Any) -> None:
    run = Started(target, {"kind": "timeout", "seconds": 0.02, "child": {"w": leaf("wait")}}, poll=None).start()
    result = run.join()
    assert (result.status, result.failure.code) == ("failure", "time_out")
    assert result.duration >= 0.02


@both
def test_a_timeout_of_an_hour_takes_no_time_on_a_manual_clock(target: Any) -> None:
    clock = ManualClock()
    root = {"kind": "timeout", "seconds": 3600, "child": {"w": leaf("wait")}}
    run = Started(target, root, RunContext(clock), poll=None).start()
    run.wait_tick("w")
    clock.advance(3599)
    clock.advance(1)
    result = run.join()
    assert (result.failure.code, result.duration) == ("time_out", 3600)


@both
def test_a_stop_terminates_a_leaf_that_hangs(target: Any) -> None:
    run = Started(target, SEQUENCE, poll=None).start()
    run.wait_tick("w")
    run.runner.stop()
    result = run.join()
    assert (result.status, result.outcome, result.meaning) == ("stopped", None, None)
    assert run.leaves["w"].terminated == [Status.INVALID]


@both
def test_a_stop_reaches_every_branch_and_a_paused_run(target: Any) -> None:
    run = Started(target, FORKED, poll=None).start()
    run.wait_tick("v")
    run.wait_tick("w")
    run.runner.pause()
    run.runner.stop()
    assert run.join().status == "stopped"
    assert [leaf.terminated for leaf in run.leaves.values()] == [[Status.INVALID], [Status.INVALID]]


@both
@pytest.mark.parametrize("cancel", ["halt", "join"])
def test_a_stop_terminates_the_others_while_one_leaf_hangs_in_its_update(
    target: Any, cancel: str, monkeypatch: Any
) -> None:
    monkeypatch.setattr("grip_bt.runtime.runner.INSIST", 0.03)
    children = {"w": leaf("wait"), "h": leaf("hang")}
    run = Started(target, {"kind": "parallel", "cancel": cancel, "children": children}, poll=None).start()
    run.wait_tick("w")
    assert run.leaves["h"].inside.wait(120)
    run.runner.stop()
    assert run.leaves["w"].was_terminated.wait(120)
    run.leaves["h"].released.set()
    assert run.join().status == "stopped"


@both
def test_a_run_stopped_before_it_begins_ticks_nothing(target: Any) -> None:
    run = Started(target, SEQUENCE)
    run.runner.stop()
    assert run.start().join().status == "stopped"
    assert run.leaves["w"].ticks == 0


@both
def test_recovery_does_not_run_after_a_stop(target: Any) -> None:
    root = {"kind": "fallback", "children": {"w": leaf("wait"), "recover": leaf("wait")}}
    run = Started(target, root, poll=None).start()
    run.wait_tick("w")
    run.runner.stop()
    assert run.join().status == "stopped"
    assert run.leaves["recover"].ticks == 0


@both
def test_a_paused_run_ticks_only_when_stepped(target: Any) -> None:
    run = Started(target, leaf("wait"), poll=0.001)
    waiting = run.leaves["/"]
    run.runner.pause()
    run.start()
    for expected in (1, 2, 3):
        run.runner.step()
        run.wait_tick("/")
        for _ in range(20):
            run.context.wake()
        assert waiting.ticks == expected
    waiting.told.set()
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_a_preempt_request_lets_the_task_end_on_its_own_terms(target: Any) -> None:
    root = {"kind": "fallback", "children": {"obey": leaf("obey"), "recover": leaf("end")}}
    run = Started(target, root, poll=None).start()
    run.wait_tick("obey")
    run.runner.request_preempt()
    assert run.join().outcome == "success"


@both
def test_an_exception_ends_the_run_with_the_nodes_path(target: Any) -> None:
    root = {
        "kind": "fallback",
        "children": {"a": {"kind": "sequence", "children": {"b": leaf("break")}}, "c": leaf("end")},
    }
    result = Started(target, root).start().join()
    assert result.status == "error"
    assert isinstance(result.error, NodeError)
    assert result.error.path == "a/b"
    assert isinstance(result.error.cause, RuntimeError)


@both
def test_an_exception_terminates_every_other_running_leaf_first(target: Any) -> None:
    children = {"w": leaf("wait"), "s": {"kind": "sequence", "children": {"v": leaf("wait"), "b": leaf("break")}}}
    for cancel in ("join", "halt"):
        run = Started(target, {"kind": "parallel", "cancel": cancel, "children": children}, poll=None).start()
        run.wait_tick("w")
        run.wait_tick("s/v")
        run.leaves["s/v"].told.set()
        run.context.wake()
        assert run.join().error.path == "s/b"
        assert run.leaves["w"].terminated == [Status.INVALID]


@both
def test_a_leaf_that_cannot_be_prepared_is_named_before_anything_is_ticked(target: Any) -> None:
    root = {"kind": "sequence", "children": {"w": leaf("wait"), "u": leaf("unready")}}
    run = Started(target, root)
    result = run.start().join()
    assert (result.status, str(result.error)) == ("error", "u: ConnectionError: no driver")
    assert run.leaves["w"].ticks == 0


@both
def test_a_runner_runs_once(target: Any) -> None:
    run = Started(target, leaf("end"))
    run.start().join()
    with pytest.raises(RuntimeError, match="runs once"):
        run.runner.run()


@both
def test_blocking_code_runs_in_a_worker(target: Any) -> None:
    run = Started(target, leaf("work", out={"x": "name"}), poll=None, data={"name": "str"})
    assert run.start().join().status == "success"
    assert run.compiled.data.snapshot()["", "name"] == "grip_worker"


def test_unknown_parts_are_listed_and_an_empty_name_means_the_only_one() -> None:
    part: Any = SimpleNamespace(name="right")
    context = RunContext(parts=RunParts(arms={"right": part}, hands={"left_hand": part, "right_hand": part}))
    assert context.arm("").name == "right"
    with pytest.raises(UnknownNameError, match="unknown arm 'rigt'; did you mean 'right'"):
        context.arm("rigt")
    with pytest.raises(UnknownNameError, match="left_hand, right_hand"):
        context.hand("")
    with pytest.raises(MissingPartError):
        context.scene()


def test_much_work_at_once_is_done() -> None:
    context = RunContext()
    operations = [context.run_in_worker(lambda n=n: n) for n in range(50)]
    assert all(operation.wait(120) for operation in operations)
    assert [operation.result() for operation in operations] == list(range(50))


def test_a_machine_waits_in_the_thread_that_runs_it() -> None:
    run = Started(to_machine, leaf("end"))
    assert run.runner.run().status == "success"
