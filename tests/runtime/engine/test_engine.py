"""The tick engine calls what py_trees calls, and notices what it has to."""

from __future__ import annotations

from typing import Any

import pytest
from engine_leaves import INVALID, F, Log, Plain, R, S, Told
from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy

from grip_bt.runtime import TickEngine


def told(name: str, *script: Any) -> Told:
    return Told(name, list(script), Log())


def steps(*children: Behaviour, memory: bool = True) -> composites.Sequence:
    return composites.Sequence("steps", memory, list(children))


def calls(leaf: Told) -> int:
    return leaf.k


def test_in_a_settled_tree_what_runs_is_called_and_nothing_else() -> None:
    guard, done, working = told("guard", S), told("done", S), told("working", R)
    engine = TickEngine(steps(guard, steps(done, working), memory=False))
    for _ in range(10):
        engine.tick()
    assert (calls(guard), calls(done), calls(working)) == (10, 1, 10)


@pytest.mark.parametrize("kind", ["sequence", "selector", "parallel", "decorator"])
def test_what_is_asked_in_every_tick_is_asked_in_a_settled_tree_too(kind: str) -> None:
    usual, other = (F, S) if kind == "selector" else (S, F)
    asked, working = told("asked", *[usual] * 10, other), told("working", R)
    if kind == "decorator":
        asked = told("asked", *[F] * 10, S)
        root: Behaviour = decorators.FailureIsRunning("on", asked)
    elif kind == "parallel":
        root = composites.Parallel("both", ParallelPolicy.SuccessOnAll(synchronise=False), [asked, working])
    else:
        root = {"sequence": composites.Sequence, "selector": composites.Selector}[kind]("root", False, [asked, working])
    engine = TickEngine(root)
    for _ in range(10):
        engine.tick()
    assert root.status is R
    engine.tick()
    assert calls(asked) == 11
    assert root.status is (S if kind in ("selector", "decorator") else F)
    assert working.status is INVALID


@pytest.mark.parametrize("name", ["initialise", "terminate"])
def test_a_method_that_a_leaf_gets_right_after_its_end_is_called(name: str) -> None:
    working = told("working", *[R] * 9, S)
    engine = TickEngine(steps(working, memory=False))
    for _ in range(10):
        engine.tick()
    seen: list[Any] = []
    setattr(working, name, lambda *args: seen.append(args))
    engine.tick()
    assert seen


@pytest.mark.parametrize("result", [S, F, INVALID])
def test_nothing_is_called_twice_when_a_settled_tree_goes_on(result: Any) -> None:
    guard = told("guard", S)
    members = [told("one", R), told("two", *[R] * 9, result)]
    both = composites.Parallel("both", ParallelPolicy.SuccessOnAll(), list(members))
    engine = TickEngine(steps(guard, both, memory=False))
    for _ in range(10):
        engine.tick()
    assert [calls(leaf) for leaf in (guard, *members)] == [10, 10, 10]


def test_a_timeout_of_py_trees_ends_a_settled_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr("py_trees.decorators.time.monotonic", lambda: clock[0])
    working = told("working", R)
    limit = decorators.Timeout("limit", working, 5.0)
    engine = TickEngine(limit)
    for _ in range(10):
        engine.tick()
    clock[0] = 6.0
    engine.tick()
    assert (limit.status, working.status, limit.feedback_message) == (F, INVALID, "timed out")


def test_what_a_leaf_raises_comes_out_as_it_is_and_the_next_tick_works() -> None:
    leaf = told("leaf", *[R] * 9, "raise", S)
    root = steps(leaf)
    engine = TickEngine(root)
    for _ in range(9):
        engine.tick()
    with pytest.raises(ValueError, match="leaf breaks"):
        engine.tick()
    engine.tick()
    assert root.status is S


@pytest.mark.parametrize("name", ["initialise", "terminate", "update", "stop", "tick"])
@pytest.mark.parametrize("on", ["instance", "class"])
def test_a_method_replaced_between_ticks_is_called_from_the_next_tick_on(
    name: str, on: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Patched(Plain):
        pass

    leaf = Patched("leaf", [S], Log())
    engine = TickEngine(steps(leaf, told("next", S)))
    engine.tick()
    seen: list[str] = []
    original = getattr(leaf if on == "instance" else Patched, name)

    def replacement(*args: Any) -> Any:
        seen.append(name)
        return original(*args)

    monkeypatch.setattr(leaf if on == "instance" else Patched, name, replacement)
    engine.tick()
    assert seen


@pytest.mark.parametrize("levels", [20, 120, 300, 400])
def test_trees_are_ticked_as_deep_as_py_trees_ticks_them(levels: int) -> None:
    node: Behaviour = told("leaf", S)
    for _ in range(levels):
        node = steps(node, memory=False)
    engine = TickEngine(node)
    engine.tick()
    engine.tick()
    assert node.status is S


def test_two_engines_of_one_tree_get_along() -> None:
    leaf = told("leaf", S)
    root = steps(leaf)
    engines = [TickEngine(root), TickEngine(root)]
    seen: list[Any] = []
    leaf.terminate = seen.append  # type: ignore[method-assign]
    for engine in engines:
        engine.tick()
    assert seen == [S, INVALID, S]
    assert vars(leaf)["status"] is leaf.status


def test_a_engine_needs_no_more_than_the_root_of_a_leaf() -> None:
    leaf = Plain("leaf", [R, S], Log())
    engine = TickEngine(leaf)
    engine.tick()
    assert leaf.status is R
    engine.halt()
    assert leaf.status is INVALID
