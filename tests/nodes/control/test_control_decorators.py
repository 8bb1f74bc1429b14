"""Retry, repeat, timeout, invert, force; variables of a scope; leaves that break."""

from __future__ import annotations

from typing import Any

import pytest
from control_world import World, leaf
from hypothesis import given, settings
from hypothesis import strategies as st
from py_trees.common import Status

from grip_bt.base.errors import DataError, NodeError


def over(kind: str, child: dict[str, Any] | None = None, **more: Any) -> dict[str, Any]:
    return {"kind": kind, "child": {"c": child or leaf()}, **more}


def test_retry_makes_one_attempt_a_tick_and_wakes_for_the_next() -> None:
    world = World(over("retry", times=3), {"c": "failure failure success"})
    assert world.tick() == Status.RUNNING
    assert world.wakes == 1
    assert world.tick(2) == Status.SUCCESS
    assert world.ticked == ["c", "c", "c"]
    assert world.wakes == 2  # nobody is woken for an attempt that isn't made


def test_retry_fails_with_the_reason_of_the_last_attempt() -> None:
    world = World(over("retry", times=2), {"c": "failure.no_ik failure.no_plan"})
    assert world.run() == 2
    assert world.reason == "no_plan"


def test_retry_leaves_by_an_exit_without_another_attempt() -> None:
    world = World(over("retry", times=5, exits={"c.failure.no_grasp": "failure"}), {"c": "failure failure.no_grasp"})
    assert world.run() == 2
    assert world.reason == "no_grasp"


def test_retry_counts_afresh_when_it_is_entered_again() -> None:
    root = over("retry", times=2, child=over("retry", times=2))
    world = World(root, {"c": "failure"})
    assert world.run() == 4


def test_repeat_succeeds_after_so_many_successes_and_fails_with_the_first_failure() -> None:
    assert World(over("repeat", times=3)).run() == 3
    world = World(over("repeat", times=3), {"c": "success failure.no_contact"})
    assert world.run() == 2
    assert world.reason == "no_contact"


def test_repeat_without_a_number_goes_on_until_a_failure() -> None:
    world = World(over("repeat"), {"c": "success " * 50 + "failure"})
    assert world.run() == 51


def test_a_timeout_interrupts_its_child_at_the_deadline() -> None:
    world = World(over("timeout", seconds=2.0), {"c": "." * 9 + "success"})
    assert world.tick() == Status.RUNNING
    assert world.wake_times == [2.0]
    world.clock.advance(1.9)
    assert world.tick() == Status.RUNNING
    world.clock.advance(0.1)
    assert world.tick() == Status.FAILURE
    assert world.reason == "time_out"
    assert world.halted == ["c"]


steps = st.lists(
    st.tuples(st.integers(0, 4), st.sampled_from(["success", "success", "failure"])), min_size=1, max_size=4
)


@settings(deadline=None)
@given(steps, st.lists(st.sampled_from([0.0, 0.25, 0.5, 1.0, 3.0]), min_size=20, max_size=20), st.booleans())
def test_from_its_deadline_on_nothing_in_a_timeout_is_ticked_and_what_ran_is_halted_once(
    script: list[tuple[int, str]], waits: list[float], memory: bool
) -> None:
    inner = {"kind": "sequence", "memory": memory, "children": {f"s{i}": leaf() for i in range(len(script))}}
    scripts = {f"s{i}": "." * ticks + word for i, (ticks, word) in enumerate(script)}
    world = World({"kind": "timeout", "seconds": 2.0, "child": {"c": inner}}, scripts)
    for wait in (*waits, 3.0, 0.0):
        before, halted = len(world.ticked), len(world.halted)
        running = [node.path for node in world.root.iterate() if node.status == Status.RUNNING and not node.children]
        if world.tick() != Status.RUNNING:
            break
        assert len(world.ticked) > before
        assert world.clock.now() < 2.0
        world.clock.advance(wait)
    over_at = world.clock.now() >= 2.0
    assert world.root.status != Status.RUNNING
    assert (world.reason == "time_out") == over_at
    if over_at:
        assert len(world.ticked) == before
        assert world.halted[halted:] == running


def test_with_the_child_first_what_ends_at_the_deadline_has_ended_and_what_runs_is_halted() -> None:
    world = World(over("timeout", seconds=2.0, child_first=True), {"c": ".success"})
    world.tick()
    assert world.wake_times == [2.0]
    world.clock.advance(5.0)
    assert world.tick() == Status.SUCCESS
    assert world.root.failure is None
    world = World(over("timeout", seconds=2.0, child_first=True), {"c": "..success"})
    world.tick()
    world.clock.advance(2.0)
    assert world.tick() == Status.FAILURE
    assert (world.reason, world.ticked, world.halted) == ("time_out", ["c", "c"], ["c"])


def test_a_timeout_passes_on_the_reason_of_a_child_that_failed_in_time() -> None:
    world = World(over("timeout", seconds=2.0), {"c": ".failure.no_plan"})
    assert world.run() == 2
    assert world.reason == "no_plan"


def test_a_timeout_counts_from_each_entry() -> None:
    world = World(over("retry", times=2, child=over("timeout", seconds=2.0)), {"c": "....success"})
    world.tick()
    world.clock.advance(2.0)
    assert world.tick() == Status.RUNNING
    world.tick()
    assert world.wake_times == [2.0, 4.0]
    world.clock.advance(1.0)
    assert world.tick() == Status.RUNNING


@pytest.mark.parametrize(
    ("word", "outcome"), [("success", "failure"), ("failure.no_ik", "success"), ("none", "failure")]
)
def test_invert_swaps_the_meaning_and_gives_no_reason(word: str, outcome: str) -> None:
    world = World(over("invert"), {"c": word})
    world.run()
    assert (world.root.outcome, world.root.failure) == (outcome, None)


@pytest.mark.parametrize(
    ("word", "forced", "code"),
    [("success", "failure", None), ("failure.no_ik", "success", None), ("failure.no_ik", "failure", "no_ik")],
)
def test_force_ends_as_it_says_and_keeps_the_reason_of_a_failure(word: str, forced: str, code: str | None) -> None:
    world = World(over("force", **{"as": forced}), {"c": "." + word})
    assert world.run() == 2
    assert (world.root.outcome, world.reason) == (forced, code)


def test_variables_of_a_container_start_anew_at_each_entry() -> None:
    inner = {
        "kind": "sequence",
        "data": {"n": {"type": "int", "value": 5}},
        "children": {
            "a": leaf(**{"in": {"a": "n"}, "out": {"x": "n"}}),
            "b": leaf(**{"in": {"a": "n"}, "out": {"x": "n"}}),
        },
    }
    world = World(over("repeat", times=2, child=inner))
    world.run()
    assert [event[3] for event in world.events if event[0] == "write"] == [6, 7, 6, 7]


def test_a_variable_without_a_value_is_unwritten_again_at_each_entry() -> None:
    inner = {
        "kind": "fallback",
        "data": {"n": "int"},
        "children": {"write": leaf(out={"x": "n"}), "read": leaf(**{"in": {"a": "n"}, "out": {"x": "n"}})},
    }
    world = World(over("repeat", times=2, child=inner), {"write": "success failure"})
    with pytest.raises(NodeError, match="'n' was read before it was written") as raised:
        world.run()
    assert isinstance(raised.value.cause, DataError)
    assert raised.value.path == "c/read"


def test_an_initial_value_is_not_shared_between_entries() -> None:
    root = {"kind": "sequence", "data": {"n": {"type": "list[int]", "value": [1]}}, "children": {"a": leaf()}}
    world = World(root)
    world.tree.data["/"].cells["n"].value.append(2)
    world.tick()
    assert world.tree.data["/"].cells["n"].value == [1]


def test_a_leaf_that_raises_is_named_and_terminated() -> None:
    world = World({"kind": "sequence", "children": {"a": leaf(), "b": leaf()}}, {"b": "!"})
    with pytest.raises(NodeError, match="b: RuntimeError: broken") as raised:
        world.tick()
    assert raised.value.path == "b"
    assert world.tree.by_path["b"].status == Status.INVALID
    assert ("interrupted", "b") in world.events


@pytest.mark.parametrize("mark", [{}, {"x": {"x-smach": "StateMachine"}}])
@pytest.mark.parametrize("data", [{}, {"n": {"type": "int", "value": 0}}])
def test_a_container_that_was_smachs_begins_with_its_variables_anew_like_any_other(mark: Any, data: Any) -> None:
    up = leaf(**{"in": {"a": "n"}, "out": {"x": "n"}})
    body = {"kind": "sequence", "children": {"up": up}, "data": data, **mark}
    world = World(over("repeat", times=3, child=body), data={"n": {"type": "int", "value": 0}})
    assert world.run() == 3
    written = [event[3] for event in world.events if event[0] == "write"]
    assert written == ([1, 1, 1] if data else [1, 2, 3])
