"""Pauses: clocks stand still, motions are held and go on; rates; forms of leaves that block or await."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from runtime_world import TARGETS, Started, leaf
from timed import ManualClock, OnClock, TimedArm

from grip_bt.base.errors import MissingPartError, UnknownNameError
from grip_bt.base.ports import Context, Pausable
from grip_bt.commanders.fake import FakeArm
from grip_bt.compilers import to_tree
from grip_bt.nodes.function import leaf as leaf_of
from grip_bt.runtime import RunContext, Runner, RunParts, WallClock
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Task

both = pytest.mark.parametrize("target", TARGETS)
Passing = Callable[[float], None]


@pytest.fixture
def time_passes(monkeypatch: pytest.MonkeyPatch) -> Passing:
    """Have wall clocks go only when they are told to, so that no machine is too busy for a time-out."""
    moment = [1000.0]
    monkeypatch.setattr("grip_bt.runtime.clock.time", SimpleNamespace(monotonic=lambda: moment[0]))

    def passes(seconds: float) -> None:
        moment[0] += seconds

    return passes


@both
def test_a_timeout_does_not_run_on_while_the_run_is_paused(target: Any, time_passes: Passing) -> None:
    run = Started(target, {"kind": "timeout", "seconds": 5.0, "child": {"w": leaf("wait")}}, poll=None).start()
    run.wait_tick("w")
    run.runner.pause()
    time_passes(7.0)  # longer than the time-out
    run.runner.resume()
    run.leaves["w"].told.set()
    run.context.wake()
    assert run.join().status == "success"


def test_a_wall_clock_leaves_pauses_out(time_passes: Passing) -> None:
    clock = WallClock()
    assert isinstance(clock, Pausable)
    clock.pause()
    clock.pause()
    stood = clock.now()
    time_passes(7.0)
    assert clock.now() == stood
    clock.resume()
    clock.resume()
    assert clock.now() == stood
    time_passes(2.0)
    assert clock.now() == stood + 2.0


def test_a_paused_run_holds_the_arm_in_the_middle_of_its_motion_and_goes_on() -> None:
    clock = ManualClock()
    home = FakeArm().state()
    arm = TimedArm(schedule=OnClock(clock), states={"there": type(home)(home.names, home.position + 0.5)})
    context = RunContext(clock, RunParts(arms={"right": arm}, pausable=[arm]))
    root = {"node": "arm/move_to", "with": {"state": "there"}}
    task = Task.model_validate({"grip": 1, "name": "t", "root": root})
    runner = Runner(to_tree(task, Catalog.builtin()), context, poll=0.001)
    results: list[Any] = []
    thread = threading.Thread(target=lambda: results.append(runner.run()), daemon=True)
    thread.start()
    while not arm.timed.executed:
        time.sleep(0.001)
    clock.advance(0.4)
    half = arm.state().position
    assert 0 < np.abs(half - home.position).max() < 0.5
    runner.pause()
    clock.advance(1.0)
    held = arm.state().position
    assert 0 < np.abs(held - half).max() < 0.1, "it comes to rest by a ramp"
    clock.advance(100.0)
    assert (arm.state().position == held).all()
    runner.resume()
    clock.advance(0.1)
    assert np.abs(arm.state().position - home.position).max() < 0.5
    assert not results
    clock.advance(2.0)
    thread.join(120)
    assert results[0].status == "success"
    assert arm.state().position == pytest.approx(home.position + 0.5)


@both
def test_a_run_with_a_rate_ticks_at_it_however_often_it_is_woken(target: Any) -> None:
    clock = ManualClock()
    run = Started(target, leaf("wait"), RunContext(clock), poll=None)
    run.runner = Runner(run.compiled, run.context, poll=None, rate=10.0)
    run.start()
    run.wait_tick("/")
    for expected in (2, 3, 4):
        for _ in range(20):
            run.context.wake()
        clock.advance(0.0999)
        assert run.leaves["/"].ticks == expected - 1
        clock.advance(0.0002)
        run.wait_tick("/")
        assert run.leaves["/"].ticks == expected
    run.runner.stop()
    assert run.join().status == "stopped"


def test_a_rate_is_a_positive_number() -> None:
    run = Started(to_tree, leaf("end"))
    with pytest.raises(ValueError, match="a rate is a number of ticks a second"):
        Runner(run.compiled, run.context, rate=0.0)


# --- blocking functions and coroutines as leaves ---

seen: dict[str, Any] = {}


@leaf_of("form/blocking", outputs={"n": int})
def blocking(*, seconds: float = 0.0) -> int:
    """Block."""
    seen["inside"].set()
    seen["block"].wait(120)
    return 3


@leaf_of("form/awaiting", outputs={"n": int})
async def awaiting(context: Context, *, seconds: float = 0.0) -> int:
    """Await."""
    seen["inside"].set()
    try:
        while not seen["block"].is_set():
            await asyncio.sleep(0.001)
    except asyncio.CancelledError:
        seen["cancelled"].set()
        raise
    return 4


def started(target: Any, form: Any) -> Any:
    seen.update(inside=threading.Event(), block=threading.Event(), cancelled=threading.Event())
    root = {"node": form.face.id, "out": {"n": "n"}}
    task = Task.model_validate({"grip": 1, "name": "t", "data": {"n": "int"}, "root": root})
    made = target(task, Catalog([form.face]), leaf_factory=lambda p, node, face: form(p, p, face, {"seconds": 0.0}, {}))
    run: Any = Started.__new__(Started)
    run.compiled, run.leaves, run.context, run.result = made, made.leaves, RunContext(), None
    run.runner = Runner(made, run.context, poll=None)
    run._thread = threading.Thread(target=run._run, daemon=True)
    run.start()
    assert seen["inside"].wait(120)
    return run


@both
@pytest.mark.parametrize(("form", "result"), [(blocking, 3), (awaiting, 4)])
def test_blocking_functions_and_coroutines_are_leaves(target: Any, form: Any, result: int) -> None:
    run = started(target, form)
    seen["block"].set()
    assert run.join().status == "success"
    assert run.compiled.data.snapshot()["", "n"] == result


@both
def test_a_coroutine_is_cancelled_by_a_stop_and_leaves_nothing_behind(target: Any) -> None:
    run = started(target, awaiting)
    run.runner.stop()
    result = run.join()
    assert seen["cancelled"].wait(120)
    assert (result.status, result.zombies) == ("stopped", ())


@both
def test_a_blocking_function_is_left_behind_by_a_stop_and_its_result_is_dropped(target: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("grip_bt.runtime.runner.LAST_MOMENT", 0.05)
    run = started(target, blocking)
    run.runner.stop()
    result = run.join()
    assert [str(z) for z in result.zombies] == ["/ (worker)"]
    seen["block"].set()
    assert ("", "n") not in run.compiled.data.snapshot()


@pytest.mark.parametrize("kind", ["arm", "hand", "sensor"])
def test_a_part_that_there_is_not_is_told_apart_from_having_none_at_all(kind: str) -> None:
    context = RunContext(ManualClock())
    with pytest.raises(MissingPartError, match=f"name one under `{kind}s` in grip.yaml"):
        getattr(context, kind)("")
    with pytest.raises(UnknownNameError, match="left"):
        getattr(context, kind)("left")


def test_named_messages_are_those_of_the_project() -> None:
    kept: Any = SimpleNamespace()
    assert RunContext(ManualClock(), RunParts(messages=kept)).messages() is kept
    with pytest.raises(MissingPartError, match="grip new"):
        RunContext(ManualClock()).messages()
