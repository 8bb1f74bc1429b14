"""What was told to stop has stopped before anything else that moves begins, and before the run has ended."""

from __future__ import annotations

import asyncio
import random
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from py_trees.common import Status
from runtime_world import KINDS, TARGETS, Started, Waiting, leaf

from grip_bt.base.errors import NodeError, NotStoppedError
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import STOPPED, Operation
from grip_bt.base.values import JointState
from grip_bt.nodes.async_leaf import AsyncLeaf
from grip_bt.nodes.leaf import Leaf, OperationLeaf
from grip_bt.nodes.smach_leaf import SmachLeaf
from grip_bt.runtime import RunContext, RunParts
from grip_bt.smach_compat import State

both = pytest.mark.parametrize("target", TARGETS)


class Server:
    """What does one thing at a time, and takes its time to stop; it writes down who worked when another began."""

    def __init__(self, seed: int = 0) -> None:
        self.random, self.lock = random.Random(seed), threading.Lock()
        self.working: list[str] = []
        self.began: list[tuple[str, tuple[str, ...]]] = []
        self.stops_after: Callable[[], float] = lambda: 0.02
        self.refuses = False
        self.stops: list[Callable[[], None]] = []

    def release(self) -> None:
        """Stop everything now."""
        for stop in self.stops:
            stop()

    def begin(self, path: str, lasts: float) -> Operation[Any]:
        with self.lock:
            self.began.append((path, tuple(self.working)))
            self.working.append(path)
        operation: Operation[Any] = Operation(on_cancel=lambda: self._later(self.stops_after(), lambda: stop()))
        self.stops.append(lambda: stop())

        def over(end: Callable[[], bool]) -> None:
            with self.lock:
                if operation.done():
                    return
                self.working.remove(path)
            end()

        def stop() -> None:
            refused = CanceledError("the server says nothing", **{STOPPED: False})
            over(lambda: operation.fail(refused if self.refuses else CanceledError("canceled")))

        self._later(lasts, lambda: over(lambda: operation.succeed(None)))
        return operation

    def _later(self, seconds: float, action: Callable[[], None]) -> None:
        timer = threading.Timer(seconds, action)
        timer.daemon = True
        timer.start()

    @property
    def overlaps(self) -> list[tuple[str, tuple[str, ...]]]:
        return [(path, others) for path, others in self.began if others]


class Moving(OperationLeaf):
    server: Server
    lasts: Callable[[], float]

    def start(self) -> Operation[Any]:
        return type(self).server.begin(self.path, type(self).lasts())


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Server:
    Moving.server, Moving.lasts = Server(), staticmethod(lambda: 30.0)
    for kind in ("work", "obey"):
        monkeypatch.setitem(KINDS, kind, Moving)
    return Moving.server


def late(seconds: float, child: dict[str, Any]) -> dict[str, Any]:
    return {"kind": "timeout", "seconds": seconds, "child": {"w": child}}


def either(*children: dict[str, Any]) -> dict[str, Any]:
    return {"kind": "fallback", "children": {f"c{i}": child for i, child in enumerate(children)}}


@both
def test_the_next_motion_begins_when_the_one_before_has_stopped(target: Any, server: Server) -> None:
    server.stops_after = lambda: 0.3
    root = either(late(0.05, leaf("work")), late(0.05, leaf("work")), leaf("end"))
    result = Started(target, root, poll=0.01).start().join()
    assert (result.status, result.zombies, server.working) == ("success", (), [])
    assert server.began
    assert server.overlaps == []


@both
def test_of_many_motions_that_are_interrupted_at_random_no_two_overlap(target: Any, server: Server) -> None:
    draw = random.Random(7)
    server.stops_after = lambda: draw.uniform(0.0, 0.06)
    Moving.lasts = staticmethod(lambda: draw.uniform(0.0, 0.12))
    tried = either(late(0.04, leaf("work")), late(0.2, leaf("obey")), leaf("end"))
    attempt = {"kind": "repeat", "times": 60, "child": {"a": tried}}
    result = Started(target, attempt, poll=0.01).start().join()
    assert result.zombies == ()
    assert len(server.began) >= 60
    assert server.overlaps == []


@both
def test_a_check_does_not_wait_for_what_has_still_to_stop(target: Any, server: Server) -> None:
    server.stops_after = lambda: 1000.0
    run = Started(
        target,
        either(late(0.05, leaf("work")), {"kind": "sequence", "children": {"e": leaf("end"), "w": leaf("wait")}}),
        poll=0.01,
    )
    run.start()
    run.wait_tick("c1/w")
    assert server.working == ["c0/w"]
    run.leaves["c1/w"].told.set()
    run.context.wake()
    while not run.runner._returned.is_set():
        time.sleep(0.002)
    assert run.result is None
    server.release()
    assert run.join().status == "success"
    assert server.working == []  # the run has waited for it


@both
def test_where_the_server_never_says_that_it_stopped_nothing_else_begins(target: Any, server: Server) -> None:
    server.refuses = True
    result = Started(target, either(late(0.05, leaf("work")), leaf("work")), poll=0.01).start().join()
    assert result.status == "error"
    assert isinstance(result.error, NodeError)
    assert isinstance(result.error.cause, NotStoppedError)
    assert "the server says nothing" in str(result.error)
    assert result.rest.unconfirmed == {"c0/w": "the server says nothing"}
    assert len(server.began) == 1


@both
def test_a_task_that_leaves_something_moving_is_no_success(target: Any, server: Server) -> None:
    server.refuses = True
    result = Started(target, either(late(0.05, leaf("work")), leaf("end")), poll=0.01).start().join()
    assert (result.status, result.outcome) == ("error", None)
    assert "c0/w" in str(result.rest)


@both
def test_what_never_stops_ends_the_run_when_the_patience_is_over(
    target: Any, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("grip_bt.nodes.leaf", "grip_bt.runtime.runner"):
        monkeypatch.setattr(f"{module}.STOPPING", 0.2)
    monkeypatch.setattr("grip_bt.runtime.runner.REST", 0.1)
    server.stops_after = lambda: 1000.0
    for root in (either(late(0.05, leaf("work")), leaf("work")), either(late(0.05, leaf("work")), leaf("end"))):
        result = Started(target, root, poll=0.01).start().join()
        assert result.status == "error"
        assert "hasn't" in str(result.error)
        assert list(result.rest.unconfirmed) == ["c0/w"]
        assert result.zombies == ()


@both
def test_a_leaf_that_waits_for_its_beginning_obeys_a_request_to_end(target: Any, server: Server) -> None:
    server.stops_after = lambda: 1000.0
    run = Started(target, either(late(0.05, leaf("work")), leaf("obey")), poll=0.01).start()
    deadline = time.monotonic() + 120
    while not run.leaves["c1"].active:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    run.runner.request_preempt()
    while run.leaves["c1"].active:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    server.release()
    result = run.join()
    assert (result.status, result.failure and result.failure.code) == ("failure", "preempted")
    assert [path for path, _ in server.began] == ["c0/w"]


class Awaiting(AsyncLeaf):
    """A coroutine that awaits motions, the second of them when the first was too slow."""

    async def run(self) -> None:
        with suppress(TimeoutError):
            await asyncio.wait_for(Moving.server.begin(self.path, 30.0), 0.02)
        await Moving.server.begin(self.path, 30.0)


class Reaching(Leaf):
    """Begins a motion of the arm in its own `update`."""

    motion: Operation[Any] | None = None

    def update(self) -> Status:
        if self.motion is None:
            self.motion = self.context.arm("right").execute(self.path)  # type: ignore[arg-type]
        self.motion.add_done_callback(self.context.wake)
        return self.end(x=self.motion.result()) if self.motion.done() else self.running()

    def terminate(self, new_status: Status) -> None:
        if self.motion is not None:
            self.motion.cancel()
        self.motion = None


class Holding(Reaching):
    """Likewise, and tells the arm to stop in place of its motion."""

    def terminate(self, new_status: Status) -> None:
        if self.motion is not None:
            self.context.arm("right").stop()
        self.motion = None


class Blocking(State):  # type: ignore[misc]
    """Moves something itself, and returns when that has stopped after a request."""

    def __init__(self, path: str) -> None:
        State.__init__(self, ["success", "failure"])
        self.path = path

    def execute(self, userdata: Any) -> str:
        motion = Moving.server.begin(self.path, 30.0)
        while not motion.done():
            time.sleep(0.002)
            if self.preempt_requested():
                motion.cancel()
        return "failure"


class Legacy(SmachLeaf):
    def make(self) -> Any:
        return Blocking(self.path)


class ServedArm:
    """An arm whose motions are the server's."""

    name = "right"

    def execute(self, plan: Any) -> Operation[Any]:
        motion = Moving.server.begin(plan, 30.0)
        self.ends = Moving.server.stops[-1]
        return motion

    def stop(self) -> None:
        Moving.server._later(0.1, self.ends)


@both
@pytest.mark.parametrize("second", [Awaiting, Reaching, Holding, Legacy, Moving])
@pytest.mark.parametrize("first", [Awaiting, Reaching, Holding, Legacy, Moving])
def test_whatever_has_begun_a_motion_the_next_one_waits_for_its_end(
    target: Any, first: Any, second: Any, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.stops_after = lambda: 0.1
    monkeypatch.setitem(KINDS, "work", first)
    monkeypatch.setitem(KINDS, "obey", second)
    arms: Any = {"right": ServedArm()}
    root = either(late(0.08, leaf("work")), late(0.25, leaf("obey")), leaf("end"))
    result = Started(target, root, RunContext(parts=RunParts(arms=arms)), poll=0.01).start().join()
    assert (result.status, result.zombies, server.working) == ("success", (), [])
    assert server.began[0][0] == "c0/w"
    assert server.overlaps == []


@both
@pytest.mark.parametrize("first", [Awaiting, Reaching])
@pytest.mark.parametrize("second", ["obey", "end"])
def test_a_motion_of_which_nobody_can_say_that_it_stopped_ends_the_run_whatever_has_begun_it(
    target: Any, first: Any, second: str, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.refuses = True
    monkeypatch.setitem(KINDS, "work", first)
    monkeypatch.setitem(KINDS, "obey", Reaching)
    arms: Any = {"right": ServedArm()}
    root = either(late(0.08, leaf("work")), leaf(second))
    result = Started(target, root, RunContext(parts=RunParts(arms=arms)), poll=0.01).start().join()
    assert result.status == "error"
    assert "the server says nothing" in str(result.error)
    assert [path for path, _ in server.began] == ["c0/w"]


@both
def test_code_in_a_worker_that_a_cancelled_coroutine_awaited_is_waited_for(
    target: Any, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    go_on, over = threading.Event(), threading.Event()

    class Works(AsyncLeaf):
        async def run(self) -> None:
            await self.context.run_in_worker(lambda: (go_on.wait(120), over.set()))

    class Asks(Moving):
        def start(self) -> Operation[Any]:
            assert over.is_set()
            return Operation.finished(None)

    monkeypatch.setitem(KINDS, "work", Works)
    monkeypatch.setitem(KINDS, "obey", Asks)
    run = Started(target, either(late(0.05, leaf("work")), leaf("obey")), poll=0.01).start()
    deadline = time.monotonic() + 120
    while "to stop" not in run.leaves["c1"].feedback_message:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    go_on.set()
    assert run.join().status == "success"


class Part:
    """An arm that brakes for a while when it is told to stop."""

    name = "right"

    def __init__(self, brakes: float) -> None:
        self.brakes, self.told = brakes, 0.0

    def stop(self) -> None:
        self.told = self.told or time.monotonic()

    def state(self) -> JointState:
        passed = time.monotonic() - self.told if self.told else 0.0
        return JointState(("a",), [min(passed, self.brakes)])


class Using(Waiting):
    def update(self) -> Status:
        self.context.arm("right")
        return super().update()


def stopped_with(target: Any, part: Any, **more: Any) -> Any:
    KINDS["break"], before = Using, KINDS["break"]
    try:
        arms: Any = {"right": part}
        run = Started(target, leaf("break"), RunContext(parts=RunParts(arms=arms, **more))).start()
    finally:
        KINDS["break"] = before
    run.wait_tick("/")
    run.runner.stop()
    return run.join()


@both
def test_a_run_is_stopped_when_the_arm_was_measured_to_stand_still(target: Any) -> None:
    part = Part(brakes=0.6)
    result = stopped_with(target, part)
    assert time.monotonic() - part.told >= 0.6
    assert (result.status, result.rest.at_rest, str(result.rest)) == ("stopped", ("right",), "'right' is at rest")


@both
def test_what_could_not_be_measured_is_named(target: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grip_bt.runtime.runner.REST", 0.3)

    def silent(names: Any) -> Operation[JointState]:
        return Operation.failed(CanceledError("/joint_states: no new joint states within 1 s"))

    result = stopped_with(target, Part(brakes=0.0), measure=silent)
    assert str(result.rest) == "could not confirm that 'right' stopped: /joint_states: no new joint states within 1 s"
    result = stopped_with(target, Part(brakes=1000.0))
    assert "still move" in result.rest.unconfirmed["right"]
