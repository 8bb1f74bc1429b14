"""Breakpoints and steps, on both targets."""

from __future__ import annotations

import queue
from typing import Any

import pytest
from runtime_world import TARGETS, Started, leaf

from grip_bt.base.errors import ExpressionError, UnknownNameError
from grip_bt.compilers import to_tree
from grip_bt.runtime.debugger import Held

both = pytest.mark.parametrize("target", TARGETS)
ROOT = {
    "kind": "sequence",
    "children": {
        "a": {"kind": "sequence", "children": {"x": leaf("end", out={"x": "n"}), "y": leaf("end")}},
        "b": {"kind": "fallback", "children": {"z": leaf("end")}},
        "c": leaf("end"),
    },
}


class Debugged(Started):
    """A run that says where it holds."""

    def __init__(self, target: Any, root: dict[str, Any] = ROOT):
        super().__init__(target, root, poll=None, data={"n": {"type": "list[int]", "value": []}})
        self.places: queue.SimpleQueue[Held] = queue.SimpleQueue()
        self.runner.debugger.on_held(self.places.put)

    def place(self) -> tuple[str, str]:
        held = self.places.get(timeout=120)
        while not self.runner.pacing.holding:  # it tells before it holds
            pass
        return held.when, held.path


@both
def test_a_breakpoint_holds_before_its_node_and_the_run_goes_on(target: Any) -> None:
    run = Debugged(target)
    run.runner.debugger.set("/a/y")
    run.start()
    assert run.place() == ("before", "a/y")
    assert run.compiled.data.snapshot()["", "n"] == [1, 2, 3]
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_a_breakpoint_after_a_node_knows_its_outcome_and_code(target: Any) -> None:
    root = {"kind": "fallback", "children": {"w": leaf("obey"), "e": leaf("end")}}
    run = Debugged(target, root)
    run.runner.debugger.set("w", outcome="success")
    run.runner.debugger.set("w", outcome="failure.no_ik")
    run.runner.debugger.set("w", outcome="failure.preempted")
    run.start()
    run.wait_tick("w")
    run.runner.request_preempt()
    held = run.places.get(timeout=120)
    assert (held.when, held.path, held.outcome, held.code, held.breakpoint) == ("after", "w", "failure", "preempted", 3)
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_a_condition_looks_at_the_variables_of_its_node(target: Any) -> None:
    run = Debugged(target)
    run.runner.debugger.set("a/x", condition="len(n) > 2")
    run.runner.debugger.set("c", condition="len(n) > 2")
    run.start()
    assert run.place() == ("before", "c")
    run.runner.resume()
    run.join()
    assert run.places.empty()


@both
def test_a_condition_that_cannot_be_computed_holds_and_says_why(target: Any) -> None:
    run = Debugged(target)
    run.runner.debugger.set("c", condition="n > 1")
    run.start()
    held = run.places.get(timeout=120)
    assert "can't be computed" in held.message
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_steps_go_in_over_and_out(target: Any) -> None:
    run = Debugged(target)
    run.runner.debugger.set("a")
    run.start()
    walked = [run.place()]
    for how in ("in", "in", "out", "over"):
        run.runner.step(how)
        walked.append(run.place())
    assert walked == [("before", path) for path in ("a", "a/x", "a/y", "b", "c")]
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_a_run_to_a_node_holds_there_once(target: Any) -> None:
    run = Debugged(target, {"kind": "repeat", "times": 3, "child": {"e": leaf("end")}})
    run.runner.pause()
    run.start()
    run.runner.debugger.run_to("e")
    assert run.place() == ("before", "e")
    assert run.runner.debugger.breakpoints == ()
    run.runner.resume()
    assert run.join().status == "success"
    assert run.places.empty()


@both
@pytest.mark.parametrize("when", ["before", "after"])
def test_a_stop_ends_a_run_that_holds_and_begins_nothing_more(target: Any, when: str) -> None:
    run = Debugged(target)
    run.runner.debugger.set("a/x", when)
    run.start()
    assert run.place() == (when, "a/x")
    run.runner.stop()
    result = run.join()
    assert (result.status, result.zombies) == ("stopped", ())


@both
def test_a_step_of_a_tick_ends_the_tick_that_is_held(target: Any) -> None:
    run = Debugged(target, {"kind": "repeat", "times": 2, "child": {"e": leaf("end")}})
    run.runner.debugger.set("e")
    run.start()
    assert run.place() == ("before", "e")
    run.runner.step()
    assert not run.runner._ended.wait(0.05)
    assert run.places.empty()
    run.runner.resume()
    assert run.place() == ("before", "e")
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_a_breakpoint_set_while_a_leaf_runs_is_met(target: Any) -> None:
    run = Debugged(target, {"kind": "sequence", "children": {"w": leaf("wait"), "e": leaf("end")}})
    run.start()
    run.wait_tick("w")
    run.runner.debugger.set("e")
    run.leaves["w"].told.set()
    run.context.wake()
    assert run.place() == ("before", "e")
    run.runner.debugger.clear()
    run.runner.resume()
    assert run.join().status == "success"


@both
def test_a_command_that_comes_while_the_place_is_told_is_not_lost(target: Any) -> None:
    run = Debugged(target)
    run.runner.debugger.set("a/x")
    run.runner.debugger.on_held(lambda held: run.runner.resume())
    run.start()
    assert run.join().status == "success"


def test_what_is_not_there_is_refused_with_what_is() -> None:
    debugger = Debugged(to_tree).runner.debugger
    with pytest.raises(UnknownNameError, match="unknown node 'a/q'.*available: /, a, a/x"):
        debugger.set("a/q")
    with pytest.raises(UnknownNameError, match="unknown outcome 'succes'; did you mean 'success'"):
        debugger.set("a/x", outcome="succes")
    with pytest.raises(UnknownNameError, match="unknown variable 'm'"):
        debugger.set("a/x", condition="m > 2")
    with pytest.raises(ExpressionError):
        debugger.set("a/x", condition="n >")
    with pytest.raises(UnknownNameError, match="a breakpoint on an outcome: unknown moment 'before'"):
        debugger.set("a/x", "before", "success")
    with pytest.raises(UnknownNameError, match="unknown breakpoint '7'"):
        debugger.clear(7)
    with pytest.raises(UnknownNameError, match="unknown step 'sideways'"):
        debugger.step("sideways")


def test_a_run_without_breakpoints_asks_the_debugger_nothing() -> None:
    run = Debugged(to_tree)
    called: list[str] = []
    run.runner.debugger.entered = called.append  # type: ignore[method-assign]
    run.start().join()
    assert called == []


@pytest.mark.parametrize(
    ("written", "meant"),
    [("/", "/"), ("", "/"), (" // ", "/"), ("/a/y", "a/y"), ("a/y/", "a/y"), (" a ", "a"), ("a/y", "a/y")],
)
def test_a_node_may_be_written_with_or_without_slashes_around_it(written: str, meant: str) -> None:
    run = Debugged(TARGETS[0])
    assert run.runner.debugger.set(written).node == meant
