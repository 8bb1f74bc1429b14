"""How plans get faster, and that they notice what they have to."""

from __future__ import annotations

import time
from typing import Any

import pytest
from plan_leaves import INVALID, F, Log, Plain, R, S, Told
from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy

from grip_bt.runtime import Plan
from grip_bt.runtime.plan import regions
from grip_bt.runtime.plan.plan import WARM_UP
from grip_bt.runtime.plan.watch import Methods


def told(name: str, *script: Any) -> Told:
    return Told(name, list(script), Log())


def steps(*children: Behaviour, memory: bool = True) -> composites.Sequence:
    return composites.Sequence("steps", memory, list(children))


def calls(leaf: Told) -> int:
    return leaf.k


def test_the_source_is_generated_after_some_ticks_in_the_background() -> None:
    plan = Plan(steps(told("a", S), told("b", S)))
    before = plan._run
    for _ in range(WARM_UP):
        plan.tick()
    deadline = time.monotonic() + 120
    while plan._run is before and time.monotonic() < deadline:
        plan.tick()
    assert plan._run.__code__.co_filename == "<plan>"


def test_trees_of_one_shape_share_their_code() -> None:
    first, second = (Plan(steps(told("a", S), told("b", F), steps(told("c", R)))) for _ in range(2))
    first.optimise()
    known = len(regions._codes)
    second.optimise()
    assert len(regions._codes) == known
    assert first._run.__code__ is second._run.__code__
    assert first._run is not second._run


def test_a_settled_tree_is_ticked_by_a_trace_that_calls_what_runs_and_nothing_else() -> None:
    guard, done, working = told("guard", S), told("done", S), told("working", R)
    plan = Plan(steps(guard, steps(done, working), memory=False))
    for _ in range(10):
        plan.tick()
    assert plan._trace is not None
    assert (calls(guard), calls(done), calls(working)) == (10, 1, 10)


@pytest.mark.parametrize("kind", ["sequence", "selector", "parallel", "decorator"])
def test_what_is_asked_in_every_tick_is_asked_by_a_trace_too(kind: str) -> None:
    usual, other = (F, S) if kind == "selector" else (S, F)
    asked, working = told("asked", *[usual] * 10, other), told("working", R)
    if kind == "decorator":
        asked = told("asked", *[F] * 10, S)
        root: Behaviour = decorators.FailureIsRunning("on", asked)
    elif kind == "parallel":
        root = composites.Parallel("both", ParallelPolicy.SuccessOnAll(synchronise=False), [asked, working])
    else:
        root = {"sequence": composites.Sequence, "selector": composites.Selector}[kind]("root", False, [asked, working])
    plan = Plan(root)
    for _ in range(10):
        plan.tick()
    assert plan._trace is not None
    assert root.status is R
    plan.tick()
    assert calls(asked) == 11
    assert root.status is (S if kind in ("selector", "decorator") else F)
    assert working.status is INVALID


@pytest.mark.parametrize("name", ["initialise", "terminate"])
def test_a_method_that_a_leaf_gets_right_after_a_trace_has_ended_is_called(name: str) -> None:
    """The plan puts what the trace knows into the leaf for one tick, which isn't what the leaf looks like."""
    working = told("working", *[R] * 9, S)
    plan = Plan(steps(working, memory=False))
    for _ in range(10):
        plan.tick()
    assert plan._trace is None
    seen: list[Any] = []
    setattr(working, name, lambda *args: seen.append(args))
    plan.tick()
    assert seen


@pytest.mark.parametrize("result", [S, F, INVALID])
def test_nothing_is_called_twice_when_a_trace_ends(result: Any) -> None:
    guard = told("guard", S)
    members = [told("one", R), told("two", *[R] * 9, result)]
    both = composites.Parallel("both", ParallelPolicy.SuccessOnAll(), list(members))
    plan = Plan(steps(guard, both, memory=False))
    for _ in range(10):
        plan.tick()
    assert plan._trace is None
    assert [calls(leaf) for leaf in (guard, *members)] == [10, 10, 10]
    assert "update" not in vars(guard)
    assert not Methods.passing, "sizes are noted again"


def test_a_trace_lets_a_timeout_end(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr("py_trees.decorators.time.monotonic", lambda: clock[0])
    working = told("working", R)
    limit = decorators.Timeout("limit", working, 5.0)
    plan = Plan(limit)
    for _ in range(10):
        plan.tick()
    assert plan._trace is not None
    clock[0] = 6.0
    plan.tick()
    assert (limit.status, working.status, limit.feedback_message) == (F, INVALID, "timed out")


def test_what_a_leaf_raises_comes_out_as_it_is_and_the_next_tick_works() -> None:
    leaf = told("leaf", *[R] * 9, "raise", S)
    root = steps(leaf)
    plan = Plan(root)
    for _ in range(9):
        plan.tick()
    with pytest.raises(ValueError, match="leaf breaks"):
        plan.tick()
    plan.tick()
    assert root.status is S


@pytest.mark.parametrize("name", ["initialise", "terminate", "update", "stop", "tick"])
@pytest.mark.parametrize("on", ["instance", "class"])
def test_a_method_replaced_between_ticks_is_called_from_the_next_tick_on(
    name: str, on: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Patched(Plain):
        pass

    leaf = Patched("leaf", [S], Log())
    plan = Plan(steps(leaf, told("next", S)))
    plan.optimise()
    plan.tick()
    seen: list[str] = []
    original = getattr(leaf if on == "instance" else Patched, name)

    def replacement(*args: Any) -> Any:
        seen.append(name)
        return original(*args)

    monkeypatch.setattr(leaf if on == "instance" else Patched, name, replacement)
    plan.tick()
    assert seen


@pytest.mark.parametrize("levels", [20, 120, 300, 400])
def test_trees_are_ticked_as_deep_as_py_trees_ticks_them(levels: int) -> None:
    node: Behaviour = told("leaf", S)
    for _ in range(levels):
        node = steps(node, memory=False)
    plan = Plan(node)
    plan.tick()
    plan.optimise()
    plan.tick()
    assert node.status is S


def test_two_plans_of_one_tree_get_along() -> None:
    leaf = told("leaf", S)
    root = steps(leaf)
    plans = [Plan(root), Plan(root)]
    seen: list[Any] = []
    leaf.terminate = seen.append  # type: ignore[method-assign]
    for plan in plans:
        plan.tick()
    assert seen == [S, INVALID, S]
    assert vars(leaf)["status"] is leaf.status


def test_a_plan_needs_no_more_than_the_root_of_a_leaf() -> None:
    leaf = Plain("leaf", [R, S], Log())
    plan = Plan(leaf)
    plan.optimise()
    plan.tick()
    assert leaf.status is R
    plan.halt()
    assert leaf.status is INVALID
