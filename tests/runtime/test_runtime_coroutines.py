"""Leaves whose activation is a coroutine: values, operations and time that they await, pauses, halts, mistakes."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from runtime_world import TARGETS, Started
from timed import ManualClock, OnClock, TimedArm

import grip_bt as grip
from grip_bt.base.failures import NoPlanError
from grip_bt.base.operation import Operation
from grip_bt.commanders.fake import FakeArm
from grip_bt.compilers import to_tree
from grip_bt.runtime import Journal, JournalReader, RunContext, Runner, RunParts
from grip_bt.task.catalog import Catalog, Manifest, read_python_nodes
from grip_bt.task.model import Task

both = pytest.mark.parametrize("target", TARGETS)
HEAD = "import asyncio\nimport grip_bt as grip\nfrom grip_bt.base.failures import NoPlanError\n"


class World:
    """What the leaves of a test and the test share."""

    def __init__(self) -> None:
        self.inside, self.go_on, self.cancelled = threading.Event(), threading.Event(), threading.Event()
        self.operation: Operation[Any] = Operation()


class Base(grip.AsyncLeaf):
    world: World


def run_of(
    cls: type[Base], target: Any, context: RunContext | None = None, journal: Journal | None = None, **face: Any
) -> Any:
    """A run of one leaf, whose output `n` and input `x` are variables."""
    cls.world = World()
    inputs = {"x": {"type": "int"}}
    manifest = Manifest.model_validate(
        {**{"id": "my/leaf", "doc": "d", "implementation": "t:T", "inputs": inputs}, **face}
    )
    root: dict[str, Any] = {"node": "my/leaf", "in": {"x": "x"}}
    if "outputs" in face:
        root["out"] = {port: port for port in face["outputs"]}
    data: dict[str, Any] = {"x": {"type": "int", "value": 20}, **{port: "Any" for port in face.get("outputs", {})}}
    task = Task.model_validate({"grip": 1, "name": "t", "data": data, "root": root})
    made = target(task, Catalog([manifest]), leaf_factory=lambda p, node, face: cls(p, p, face, {}, {}))
    run: Any = Started.__new__(Started)
    run.compiled, run.leaves, run.result = made, made.leaves, None
    run.context = context or RunContext()
    run.runner = Runner(made, run.context, journal=journal, poll=0.01)
    run._thread = threading.Thread(target=run._run, daemon=True)
    run.world = cls.world
    return run


def wait_for(what: Callable[[], Any]) -> None:
    deadline = time.monotonic() + 120
    while not what():
        assert time.monotonic() < deadline, "it didn't come to that within 120 s"
        time.sleep(0.002)


@both
def test_what_a_coroutine_returns_goes_to_the_outputs(target: Any) -> None:
    class Twice(Base):
        async def run(self) -> int:
            await asyncio.sleep(0)
            return int(self.read("x")) * 2

    run = run_of(Twice, target, outputs={"n": {"type": "int"}}).start()
    assert run.join().status == "success"
    assert run.compiled.data.snapshot()["", "n"] == 40


@both
def test_an_outcome_of_its_own_is_an_end(target: Any) -> None:
    class Weigh(Base):
        async def run(self) -> grip.End:
            return grip.End("heavy", code="too_heavy", message="20 kg", n=3)

    outcomes = {"heavy": "failure", "light": "success"}
    run = run_of(Weigh, target, outputs={"n": {"type": "int"}}, outcomes=outcomes, codes=["too_heavy"]).start()
    assert run.join().failure.code == "too_heavy"
    assert run.leaves["/"].outcome == "heavy"


@both
def test_operations_are_awaited_and_their_trouble_is_the_leafs(target: Any) -> None:
    class Waits(Base):
        async def run(self) -> None:
            self.world.inside.set()
            await self.world.operation

    run = run_of(Waits, target, codes=["no_plan"]).start()
    assert run.world.inside.wait(120)
    run.world.operation.fail(NoPlanError("none"))
    assert run.join().failure.code == "no_plan"


@both
def test_a_stop_cancels_the_coroutine_and_what_it_awaits(target: Any) -> None:
    class Waits(Base):
        async def run(self) -> None:
            self.world.inside.set()
            await self.world.operation

    run = run_of(Waits, target).start()
    assert run.world.inside.wait(120)
    run.runner.stop()
    assert run.join().status == "stopped"
    assert run.world.operation.wait(120)
    assert run.world.operation.cancel_asked


def test_an_arm_is_moved_by_awaiting_its_plan_and_its_motion() -> None:
    class Moves(Base):
        async def run(self) -> None:
            arm = self.context.arm("")
            await arm.execute(await arm.plan("there"))

    clock = ManualClock()
    home = FakeArm().state()
    there = type(home)(home.names, home.position + 0.5)
    arm = TimedArm(schedule=OnClock(clock), states={"there": there})
    run = run_of(Moves, to_tree, RunContext(clock, RunParts(arms={"right": arm}, pausable=[arm]))).start()
    wait_for(lambda: arm.timed.executed)
    clock.advance(100.0)
    assert run.join().status == "success"
    assert (arm.state().position == there.position).all()


@both
def test_sleep_is_by_the_runs_clock(target: Any) -> None:
    class Sleeps(Base):
        async def run(self) -> None:
            self.world.inside.set()
            nap = self.sleep(30.0)
            self.world.go_on.set()
            await nap

    clock = ManualClock()
    run = run_of(Sleeps, target, RunContext(clock)).start()
    assert run.world.go_on.wait(120)
    clock.advance(29.9)
    ticks = run.runner.pacing.ticks
    wait_for(lambda: run.runner.pacing.ticks > ticks + 1)
    assert run.result is None
    clock.advance(0.2)
    assert run.join().status == "success"


def test_what_it_tells_is_a_message_of_the_node(tmp_path: Path) -> None:
    class Tells(Base):
        async def run(self) -> None:
            self.tell("half-way")
            await self.world.operation

    with Journal(tmp_path / "runs.sqlite") as journal:
        run = run_of(Tells, to_tree, journal=journal).start()
        wait_for(lambda: run.leaves["/"].feedback_message == "half-way")
        run.world.operation.succeed(None)
        assert run.join().status == "success"
    with JournalReader(tmp_path / "runs.sqlite") as reader:
        assert "half-way" in [e.data.get("text") for e in reader.events(run.runner.run_id) if e.event == "message"]


@both
def test_a_pause_reaches_a_coroutine_in_what_it_sleeps_and_nowhere_else(target: Any) -> None:
    class Steps(Base):
        async def run(self) -> None:
            await self.world.operation
            nap = self.sleep(0.001)
            self.world.inside.set()
            await nap

    run = run_of(Steps, target).start()
    wait_for(lambda: run.leaves["/"].active)
    run.runner.pause()
    run.world.operation.succeed(None)
    assert run.world.inside.wait(120)
    assert run.result is None
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_a_paused_run_is_stopped_with_its_coroutine_cancelled(target: Any) -> None:
    class Waits(Base):
        async def run(self) -> None:
            self.world.inside.set()
            try:
                await asyncio.Event().wait()
            except asyncio.CancelledError:
                self.world.cancelled.set()
                raise

    run = run_of(Waits, target).start()
    assert run.world.inside.wait(120)
    run.runner.pause()
    run.runner.stop()
    result = run.join()
    assert run.world.cancelled.wait(120)
    assert result.status == "stopped"


@both
def test_ends_of_update_are_refused_within_a_coroutine(target: Any) -> None:
    class Ends(Base):
        async def run(self) -> Any:
            return self.end(n=1)

    run = run_of(Ends, target, outputs={"n": {"type": "int"}}).start()
    result = run.join()
    assert result.status == "error"
    assert "within run(), return grip.End('success', port=value)" in str(result.error)
    assert ("", "n") not in run.compiled.data.snapshot()


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("class A(grip.Leaf):\n    async def run(self): ...", "a class with `async def run` has to be a grip_bt.Async"),
        ("class A(grip.AsyncLeaf):\n    def run(self): ...", "has a coroutine: async def run"),
        ("class A(grip.AsyncLeaf):\n    pass", "has a coroutine: async def run"),
        ("class A(grip.Leaf):\n    async def update(self): ...", "make it `async def run` of a grip_bt.AsyncLeaf"),
        ("class A(grip.AsyncLeaf):\n    sleep: grip.Param[int] = 1\n    async def run(self): ...", "'sleep' already"),
    ],
)
def test_classes_that_nobody_would_run_are_refused(source: str, said: str) -> None:
    with pytest.raises(TypeError, match=said.replace("(", r"\(").replace(")", r"\)")):
        exec(HEAD + "@grip.leaf('my/a')\n" + source, {})


def test_a_class_with_a_coroutine_in_a_projects_file_is_a_node(tmp_path: Path) -> None:
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "nodes").mkdir()
    (tmp_path / "nodes" / "slow.py").write_text(
        HEAD
        + "@grip.leaf('my/double')\n"
        + "class Double(grip.AsyncLeaf):\n    '''Double a number, later.'''\n\n"
        + "    number: grip.Input[int]\n    by: grip.Param[int] = 2\n    doubled: grip.Output[int]\n\n"
        + "    async def run(self):\n        await self.sleep(0.01)\n        return self.number * self.by\n"
    )
    (manifest,) = read_python_nodes(tmp_path / "nodes" / "slow.py")
    assert (list(manifest.inputs), list(manifest.parameters), list(manifest.outputs)) == (
        ["number"],
        ["by"],
        ["doubled"],
    )
    (tmp_path / "t.yaml").write_text(
        "grip: 1\nname: t\ndata: {a: {type: int, value: 4}, b: int}\n"
        "root: {node: my/double, in: {number: a}, out: {doubled: b}}\n"
    )
    from grip_bt.app.runs.execute import run

    assert run(tmp_path / "t.yaml", robot="fake").status == "success"
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        newest = reader.runs()[0].id
        assert reader.value(reader.variables(newest)["b"]) == 8
