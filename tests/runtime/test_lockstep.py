"""A run that takes turns with its world is the same run whatever is slow: answers, threads, the world itself."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import threading
import time
from typing import Any

import pytest
from stepped_world import KINDS, SteppedWorld, Trace, runner_of

from grip_bt.base.operation import WAITS, Operation
from grip_bt.compilers import to_machine, to_tree
from grip_bt.runtime import RunContext, Runner, RunParts, lockstep
from grip_bt.runtime.clock import Waker
from grip_bt.runtime.lockstep import Lockstep
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Task

TARGETS = (to_tree, to_machine)
TASKS = int(os.environ.get("GRIP_FUZZ_TURNS", "24"))


def leaf(kind: str, number: int) -> tuple[str, dict[str, Any]]:
    return f"{kind}{number}", {"node": f"test/{kind}", "out": {"x": "last"}}


def random_root(rng: random.Random) -> dict[str, Any]:
    """Return parallels in sequences in parallels, some of which interrupt each other, of leaves that ask and move."""
    count = iter(range(1000))

    def node(depth: int) -> tuple[str, dict[str, Any]]:
        kind = rng.choice(("leaf", "sequence", "parallel")) if depth else "leaf"
        if kind == "leaf":
            return leaf(rng.choice(KINDS[:4]), next(count))
        policy = {"policy": rng.choice(("all", "any"))} if kind == "parallel" else {}
        return f"{kind}_{next(count)}", {"kind": kind, **policy, "children": dict(node(depth - 1) for _ in range(3))}

    return {"kind": "parallel", "children": dict(node(2) for _ in range(3))}


def interrupted() -> dict[str, Any]:
    """Return a sequence in which code in a worker is interrupted, and something moves after that."""
    parts = dict([leaf("ask", 0), leaf("work", 0)])
    return {
        "kind": "sequence",
        "children": {"both": {"kind": "parallel", "policy": "any", "children": parts}, **dict([leaf("move", 1)])},
    }


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("number", range(TASKS))
def test_events_values_and_their_times_do_not_depend_on_what_is_slow(target, number):
    root = random_root(random.Random(number)) if number else interrupted()
    traces = []
    for delays in range(4):
        runner, trace, _ = runner_of(target, root, delays)
        result = runner.run()
        assert result.status == "success", result
        traces.append((result.ticks, result.duration, trace.events))
    assert len(traces[0][2]) > 8
    assert all(trace == traces[0] for trace in traces)


@pytest.mark.parametrize("target", TARGETS)
def test_a_call_that_nobody_answers_holds_time_for_a_while_and_its_timeout_ends_at_its_own_moment(target, monkeypatch):
    monkeypatch.setattr(lockstep, "GRACE", 0.05)
    limited = {"kind": "timeout", "seconds": 0.2, "child": dict([leaf("never", 0)])}
    ways = {"limited": limited, "way": {"kind": "sequence", "children": dict(leaf("plan", n) for n in range(3))}}
    root = {"kind": "parallel", "policy": "all", "children": ways}
    traces = []
    for delays in range(3):
        runner, trace, _ = runner_of(target, root, delays)
        assert runner.run().status == "failure"
        traces.append(trace.events)
    assert traces[0] == traces[1] == traces[2]
    (end,) = [event for event in traces[0] if event[1] == "limited" and event[2] == "failure"]
    assert end[0] == pytest.approx(0.2)


class Answering:
    """A part whose call takes far longer than `GRACE`, in a process that thinks, or sleeps, meanwhile."""

    def __init__(self, code):
        self.process = subprocess.Popen([sys.executable, "-c", code])
        self.pid = self.process.pid

    def call(self):
        operation = Operation()
        threading.Thread(target=lambda: operation.succeed(self.process.wait()), daemon=True).start()
        return operation


THINKS = "import time\nwhile time.process_time() < 0.6: pass"
SLEEPS = "import time; time.sleep(600)"


@pytest.mark.parametrize(("code", "holds"), [(THINKS, True), (SLEEPS, False)])
def test_time_stands_still_for_who_thinks_however_long_and_goes_on_without_who_sleeps(code, holds, monkeypatch):
    monkeypatch.setattr(lockstep, "GRACE", 0.1)
    world = SteppedWorld(lambda: 0.0)
    turns, part = Lockstep(world), Answering(code)
    parts = RunParts(lockstep=turns, components={"part": part}, servers={"part": lambda: part.pid})
    context = RunContext(world.clock, parts)
    turns.begin(context.waker)
    asked = context.component("part").call()
    context.wake_at(5.0)
    while not asked.done() and world.clock.now() < 5.0:
        turns.rest_until(lambda: asked.done() or world.clock.now() >= 5.0, 5.0 - world.clock.now())
    turns.end()
    part.process.kill()
    assert asked.done() == holds
    assert (world.clock.now() == 0.0) == holds


def test_code_that_has_waited_long_holds_time_before_it_comes_to_a_processor(monkeypatch):
    """As a coroutine does after a motion that took long of ours: a filmed one, or one on a busy machine."""
    monkeypatch.setattr(lockstep, "GRACE", 0.5)
    delays = iter([0.6])
    world = SteppedWorld(lambda: next(delays, 0.0))
    turns = Lockstep(world)
    context = RunContext(world.clock, RunParts(lockstep=turns))

    def work() -> float:
        motion = world.move(0.1)
        with WAITS.get()(motion):
            motion.wait_here()
            time.sleep(0.1)
        return world.clock.now() - motion.result()

    turns.begin(context.waker)
    worked = context.run_in_worker(work)
    context.wake_at(0.3)
    turns.rest_until(worked.done, 0.3)
    turns.rest_until(worked.done, None)
    turns.end()
    assert worked.result() == 0.0


@pytest.mark.parametrize("target", TARGETS)
def test_a_stop_ends_a_run_that_waits_for_an_answer_or_for_its_world(target):
    for kind in ("never", "move"):
        runner, trace, world = runner_of(target, {"kind": "sequence", "children": dict([leaf(kind, 0)])}, 0)
        if kind == "move":
            world.move = lambda seconds, move=world.move: move(1e9)
        entered = threading.Event()
        trace.entered = lambda path, entered=entered: entered.set()
        ended = []
        thread = threading.Thread(target=lambda runner=runner, ended=ended: ended.append(runner.run()), daemon=True)
        thread.start()
        assert entered.wait(60)
        runner.stop()
        thread.join(60)
        assert ended[0].status == "stopped"


@pytest.mark.parametrize("target", TARGETS)
def test_what_a_node_writes_is_seen_at_that_moment_by_one_that_was_ticked_before_it(target):
    look = {"node": "flow/wait_until", "with": {"expression": "a > 3"}, "in": {"a": "reached"}}
    write = {
        "pause": {"node": "flow/wait", "with": {"seconds": 0.05}},
        "set": {"node": "flow/set", "with": {"value": 4}, "out": {"value": "reached"}},
        "more": {"node": "flow/wait", "with": {"seconds": 0.5}},
    }
    root = {"kind": "parallel", "children": {"look": look, "write": {"kind": "sequence", "children": write}}}
    data = {"reached": {"type": "int", "value": 0}}
    task = Task.model_validate({"grip": 1, "name": "run", "root": root, "data": data})
    world = SteppedWorld(lambda: 0.0)
    runner = Runner(target(task, Catalog.builtin()), RunContext(world.clock, RunParts(lockstep=Lockstep(world))))
    trace = Trace(world.clock)
    runner.observe(trace)
    assert runner.run().status == "success"
    (end,) = [event for event in trace.events if event[1:3] == ("look", "success")]
    assert end[0] == pytest.approx(0.05, abs=0.011)


@pytest.mark.parametrize("target", TARGETS)
def test_after_a_run_the_world_goes_by_itself_and_ends_come_when_they_come(target):
    runner, _, world = runner_of(target, interrupted(), 0)
    assert world.free
    runner.run()
    assert world.free
    lockstep = runner.context.lockstep
    asked = Operation()
    told = lockstep.through(asked)
    asked.succeed(1)
    assert told.done()


def test_what_a_run_has_left_ends_although_another_takes_turns():
    world = SteppedWorld(lambda: 0.0)
    lockstep, waker = Lockstep(world), Waker(world.clock)
    lockstep.begin(waker)
    left = Operation()
    told = lockstep.through(left)
    lockstep.end()
    lockstep.begin(waker)
    left.succeed(1)
    assert told.done()
    lockstep.end()


def test_a_request_to_end_reaches_a_task_whose_world_goes_on():
    runner, _, world = runner_of(to_tree, {"kind": "sequence", "children": dict([leaf("move", 0)])}, 0)
    begun, ended, move = threading.Event(), [], world.move

    def begin(seconds):
        operation = move(1e9)
        begun.set()  # a request before this would be older than the motion, which then is part of the recovery
        return operation

    world.move = begin
    thread = threading.Thread(target=lambda: ended.append(runner.run()), daemon=True)
    thread.start()
    assert begun.wait(60)
    runner.request_preempt()
    thread.join(60)
    assert ended[0].failure.code == "preempted"


@pytest.mark.parametrize("target", TARGETS)
def test_pauses_at_any_moment_change_nothing(target):
    root = random_root(random.Random(1))
    runner, undisturbed, _ = runner_of(target, root, 0)
    runner.run()
    runner, trace, _ = runner_of(target, root, 1)
    over = threading.Event()

    def pause_again_and_again() -> None:
        while not over.is_set():
            runner.pause()
            over.wait(0.002)
            runner.resume()
            over.wait(0.002)

    pauses = threading.Thread(target=pause_again_and_again, daemon=True)
    pauses.start()
    assert runner.run().status == "success"
    over.set()
    pauses.join(60)
    assert trace.events == undisturbed.events
