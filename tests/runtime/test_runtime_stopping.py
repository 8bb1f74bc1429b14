"""The certain end of a run: what hangs is left behind by name, and comes back to nothing."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from py_trees.common import Status
from runtime_world import KINDS, TARGETS, Ending, Hanging, Started, Waiting, leaf

from grip_bt.base.errors import GripError, HungError, NodeError
from grip_bt.base.operation import Operation
from grip_bt.nodes.leaf import OperationLeaf
from grip_bt.runtime import Journal, JournalReader, RunContext, Runner, RunParts
from grip_bt.runtime.runner import ABANDON
from grip_bt.runtime.stopping import in_background

both = pytest.mark.parametrize("target", TARGETS)


class HangingEnd(Waiting):
    """Its terminate doesn't return before it is released."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.released = threading.Event()

    def terminate(self, new_status: Status) -> None:
        super().terminate(new_status)
        self.released.wait(20)


class HangingStart(Waiting):
    """Its prepare doesn't return before it is released."""

    released = threading.Event()
    inside = threading.Event()

    def prepare(self) -> None:
        self.inside.set()
        self.released.wait(20)


class HangingWorker(OperationLeaf):
    """Its blocking function doesn't return before it is released."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.inside, self.released = threading.Event(), threading.Event()

    def start(self) -> Operation[Any]:
        return self.context.run_in_worker(self._block)

    def _block(self) -> None:
        self.inside.set()
        self.released.wait(20)


class Succeeding(Hanging):
    """Hangs in its update, and succeeds when it is released."""

    def update(self) -> Status:
        super().update()
        return self.end()


@pytest.fixture(autouse=True)
def more_kinds(monkeypatch: pytest.MonkeyPatch) -> None:
    more = {"wait": HangingEnd, "obey": HangingWorker, "unready": HangingStart, "hang": Succeeding}
    for kind, made in more.items():
        monkeypatch.setitem(KINDS, kind, made)
    monkeypatch.setitem(KINDS, "break", Waiting)


@pytest.fixture(autouse=True)
def hurried(unhurried: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave behind what hangs, when everything else has surely ended."""
    for limit, seconds in (("INSIST", 0.03), ("ABANDON", 1.0), ("LAST_MOMENT", 0.05)):
        monkeypatch.setattr(f"grip_bt.runtime.runner.{limit}", seconds)


@both
def test_a_leaf_that_hangs_in_its_update_is_left_behind_by_name(target: Any, tmp_path: Any) -> None:
    with Journal(tmp_path / "runs.sqlite") as journal:
        run = Started(target, {"kind": "sequence", "children": {"h": leaf("hang"), "e": leaf("end")}}, journal=journal)
        run.start()
        assert run.leaves["h"].inside.wait(120)
        run.runner.stop()
        result = run.join()
        run.leaves["h"].released.set()
        assert (result.status, [str(z) for z in result.zombies]) == ("stopped", ["h (update)"])
    with JournalReader(journal.file) as reader:
        (zombie,) = (e for e in reader.events(run.runner.run_id or "") if e.event == "zombie")
    assert (zombie.path, zombie.data) == ("h", {"where": "update"})


@both
def test_what_comes_back_after_a_stop_starts_nothing_more(target: Any) -> None:
    begun = []

    class Beginning(Ending):
        def update(self) -> Status:
            begun.append(self.path)
            return super().update()

    KINDS["end"], before = Beginning, KINDS["end"]
    try:
        run = Started(target, {"kind": "sequence", "children": {"h": leaf("hang"), "e": leaf("end")}}).start()
    finally:
        KINDS["end"] = before
    assert run.leaves["h"].inside.wait(120)
    working = next(t for t in threading.enumerate() if t.name == "grip_run" and t.ident == run.runner._thread)
    run.runner.stop()
    run.join()
    run.leaves["h"].released.set()
    working.join(120)
    assert not working.is_alive()
    assert begun == []


@both
@pytest.mark.parametrize("cancel", ["halt", "join"])
def test_one_terminate_that_hangs_keeps_no_other_leaf_running(target: Any, cancel: str) -> None:
    children = {"h": leaf("wait"), "w": leaf("break")}
    run = Started(target, {"kind": "parallel", "cancel": cancel, "children": children}).start()
    run.wait_tick("h")
    run.wait_tick("w")
    run.runner.stop()
    result = run.join()
    assert run.leaves["w"].was_terminated.is_set()
    assert [str(z) for z in result.zombies] == ["h (terminate)"]
    run.leaves["h"].released.set()


@both
def test_blocking_code_in_a_worker_is_left_behind_by_name(target: Any) -> None:
    run = Started(target, leaf("obey")).start()
    assert run.leaves["/"].inside.wait(120)
    run.runner.stop()
    result = run.join()
    assert [str(z) for z in result.zombies] == ["/ (worker)"]
    run.leaves["/"].released.set()


@both
def test_a_leaf_that_hangs_while_it_is_prepared_does_not_keep_a_stop_waiting(target: Any) -> None:
    HangingStart.inside.clear()
    HangingStart.released.clear()
    run = Started(target, leaf("unready")).start()
    assert HangingStart.inside.wait(120)
    run.runner.stop()
    assert [str(z) for z in run.join().zombies] == ["/ (prepare)"]
    HangingStart.released.set()


@both
def test_a_run_that_hangs_outside_of_its_leaves_is_left_behind_as_itself(target: Any, monkeypatch: Any) -> None:
    run, inside, released = Started(target, leaf("wait")), threading.Event(), threading.Event()
    rest = run.runner.pacing.rest

    def hang(*given: Any) -> None:
        inside.set()
        released.wait(120)
        rest(*given)

    monkeypatch.setattr(run.runner.pacing, "rest", hang)
    run.start()
    assert inside.wait(120)
    run.leaves["/"].released.set()
    run.runner.stop()
    assert [str(z) for z in run.join().zombies] == ["/ (the run itself)"]
    released.set()


@both
def test_a_stop_waits_for_nothing_that_hangs(target: Any, monkeypatch: Any) -> None:
    """How soon it ends is measured in benchmarks/run_control.py."""
    monkeypatch.setattr("grip_bt.runtime.runner.ABANDON", ABANDON)
    children = {"t": leaf("wait"), "o": leaf("obey"), "h": leaf("hang")}
    run = Started(target, {"kind": "parallel", "cancel": "join", "children": children}).start()
    run.wait_tick("t")
    assert run.leaves["h"].inside.wait(120)
    run.runner.stop()
    assert {"t", "h"} <= {zombie.path for zombie in run.join().zombies}
    for node in run.leaves.values():
        node.released.set()


@both
def test_the_robot_holds_at_a_stop_even_if_no_leaf_says_so(target: Any) -> None:
    class Part:
        name = "right"

        def __init__(self) -> None:
            self.held = threading.Event()

        def stop(self) -> None:
            self.held.set()

    class Using(Waiting):
        def update(self) -> Status:
            self.context.arm("right")
            return super().update()

    used, unused = Part(), Part()
    KINDS["break"] = Using
    arms: Any = {"right": used, "left": unused}
    run = Started(target, leaf("break"), RunContext(parts=RunParts(arms=arms))).start()
    run.wait_tick("/")
    run.runner.stop()
    run.join()
    assert used.held.is_set()
    assert not unused.held.is_set()


def looking_later(runner: Runner, monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Have a run's watch-dog look from when the returned function is called: until then a busy machine may be slow."""
    dog = runner._watchdog
    assert dog is not None
    look = dog.start
    monkeypatch.setattr(dog, "start", lambda: None)
    return look


@both
def test_an_endless_update_ends_the_run_as_an_error_with_its_path_and_place(
    target: Any, tmp_path: Any, monkeypatch: Any
) -> None:
    with Journal(tmp_path / "runs.sqlite") as journal:
        run = Started(target, {"kind": "sequence", "children": {"h": leaf("hang")}}, journal=journal)
        run.runner = Runner(run.compiled, run.context, journal=journal, poll=None, watchdog=0.05)
        look = looking_later(run.runner, monkeypatch)
        run.start()
        assert run.leaves["h"].inside.wait(120)
        look()
        result = run.join()
        run.leaves["h"].released.set()
    assert result.status == "error"
    assert isinstance(result.error, NodeError)
    assert result.error.path == "h"
    assert isinstance(result.error.cause, HungError)
    assert "update hasn't returned for 0.05 s" in str(result.error)
    with JournalReader(journal.file) as reader:
        (entered,) = (e for e in reader.events(run.runner.run_id or "") if e.event == "error")
    assert entered.path == "h"
    assert "self.released.wait(20)" in entered.data["traceback"]


@both
def test_waiting_is_no_hanging(target: Any, monkeypatch: Any) -> None:
    root = {"kind": "parallel", "cancel": "join", "children": {"w": leaf("break"), "v": leaf("break")}}
    run = Started(target, root)
    run.runner = Runner(run.compiled, run.context, poll=None, watchdog=0.5)
    look = looking_later(run.runner, monkeypatch)
    run.start()
    run.wait_tick("w")
    run.wait_tick("v")
    run.leaves["w"].told.set()
    run.context.wake()
    run.wait_tick("v")
    look()
    assert not run.runner._ended.wait(1.0)  # twice the limit; what would be wrong here is an end
    run.runner._watchdog.stop()
    run.leaves["v"].told.set()
    run.context.wake()
    assert run.join().status == "success"


def test_work_that_hangs_keeps_no_other_work_waiting() -> None:
    context, block = RunContext(), threading.Event()
    hanging = context.run_in_worker(lambda: block.wait(120))
    while not hanging.busy:
        time.sleep(0.001)
    waiting = context.run_in_worker(lambda: 7)
    hanging.cancel()
    assert waiting.wait(120)
    assert waiting.result() == 7
    assert hanging.lingers
    block.set()


@pytest.mark.parametrize(("error", "traceback"), [(GripError("the simulator is gone"), False), (KeyError("x"), True)])
def test_only_bugs_show_their_traceback(error: Exception, traceback: bool, caplog: pytest.LogCaptureFixture) -> None:
    def fails() -> None:
        raise error

    in_background("hold of right", fails).join(30.0)
    (record,) = caplog.records
    assert "hold of right" in record.message
    assert bool(record.exc_info) == traceback
    assert traceback or "the simulator is gone" in record.message
