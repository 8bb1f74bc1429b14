"""Sequence, fallback and parallel: life cycle of py_trees, labelled ends, reasons, exits."""

from __future__ import annotations

import pytest
from control_world import World, leaf
from py_trees.common import Status


def test_a_sequence_fails_with_the_reason_of_the_child_that_failed() -> None:
    world = World({"kind": "sequence", "children": {"a": leaf(), "b": leaf(), "c": leaf()}}, {"b": "failure.no_ik"})
    assert world.tick() == Status.FAILURE
    assert (world.root.outcome, world.reason) == ("failure", "no_ik")
    assert world.ticked == ["a", "b"]


def test_a_sequence_with_memory_resumes_at_the_running_child() -> None:
    world = World({"kind": "sequence", "children": {"a": leaf(), "b": leaf()}}, {"b": "..success"})
    assert world.run() == 3
    assert world.ticked == ["a", "b", "b", "b"]


def test_a_sequence_without_memory_asks_again_and_halts_what_ran_later() -> None:
    world = World(
        {"kind": "sequence", "memory": False, "children": {"guard": leaf(), "work": leaf()}},
        {"guard": "success success failure.unsafe", "work": "......success"},
    )
    assert world.tick(2) == Status.RUNNING
    assert world.tick() == Status.FAILURE
    assert world.reason == "unsafe"
    assert world.halted == ["work"]
    assert ("interrupted", "work") in world.events


def test_a_fallback_fails_with_the_reason_of_its_last_child() -> None:
    world = World(
        {"kind": "fallback", "children": {"a": leaf(), "b": leaf()}}, {"a": "failure.no_ik", "b": "failure.no_plan"}
    )
    assert world.tick() == Status.FAILURE
    assert world.reason == "no_plan"


def test_a_fallback_without_memory_halts_the_child_that_is_no_longer_needed() -> None:
    world = World(
        {"kind": "fallback", "memory": False, "children": {"done": leaf(), "work": leaf()}},
        {"done": "failure success", "work": "...success"},
    )
    assert world.tick() == Status.RUNNING
    assert world.tick() == Status.SUCCESS
    assert world.halted == ["work"]


def test_an_exit_ends_a_sequence_at_once_with_its_own_outcome() -> None:
    world = World(
        {
            "kind": "sequence",
            "outcomes": {"empty": "success"},
            "exits": {"look.none": "empty"},
            "on": {"empty": "success"},
            "children": {"look": leaf(), "pick": leaf()},
        },
        {"look": "none"},
    )
    assert world.tick() == Status.SUCCESS
    assert world.root.outcome == "empty"
    assert world.ticked == ["look"]
    assert world.root.tip().name == "look"


def test_the_exit_with_the_code_wins_over_the_one_without() -> None:
    document = {
        "kind": "fallback",
        "outcomes": {"unreachable": "failure", "broken": "failure"},
        "exits": {"a.failure": "broken", "a.failure.no_ik": "unreachable"},
        "on": {"unreachable": "failure", "broken": "failure"},
        "children": {"a": leaf(), "b": leaf()},
    }
    for word, outcome in (("failure.no_ik", "unreachable"), ("failure.no_plan", "broken"), ("failure", "broken")):
        world = World(document, {"a": word})
        assert world.tick() == Status.FAILURE
        assert world.root.outcome == outcome


def test_an_exit_of_a_reactive_sequence_halts_the_later_child() -> None:
    world = World(
        {
            "kind": "sequence",
            "memory": False,
            "exits": {"guard.none": "failure"},
            "children": {"guard": leaf(), "work": leaf()},
        },
        {"guard": "success none", "work": "...success"},
    )
    world.tick()
    assert world.tick() == Status.FAILURE
    assert world.halted == ["work"]


def test_a_parallel_decides_after_all_children_were_ticked_and_halts_the_rest() -> None:
    world = World(
        {"kind": "parallel", "children": {"a": leaf(), "b": leaf(), "c": leaf()}},
        {"a": "failure.no_ik", "b": "..success", "c": "failure.no_plan"},
    )
    assert world.tick() == Status.FAILURE
    assert world.ticked == ["a", "b", "c"]
    assert world.halted == ["b"]
    assert world.reason == "no_ik"


def test_a_finished_child_of_a_parallel_is_not_ticked_again() -> None:
    world = World({"kind": "parallel", "children": {"a": leaf(), "b": leaf()}}, {"b": "..success"})
    assert world.run() == 3
    assert world.ticked.count("a") == 1


def test_an_exit_from_inside_a_parallel_waits_for_the_end_of_the_round() -> None:
    world = World(
        {
            "kind": "parallel",
            "outcomes": {"seen": "success"},
            "exits": {"a.none": "seen"},
            "on": {"seen": "success"},
            "children": {"a": leaf(), "b": leaf()},
        },
        {"a": ".none", "b": "....success"},
    )
    assert world.tick(2) == Status.SUCCESS
    assert world.root.outcome == "seen"
    assert world.ticked == ["a", "b", "a", "b"]
    assert world.halted == ["b"]


@pytest.mark.parametrize(
    ("policy", "a", "b", "outcome"),
    [
        ("all", "success", "..success", "success"),
        ("all", "failure", "..success", "failure"),
        ("any", "success", "..failure", "success"),
        ("any", "failure", "..failure", "failure"),
        ("any", "failure", "..success", "success"),
    ],
)
def test_a_parallel_that_joins_ends_when_all_children_have_ended(policy: str, a: str, b: str, outcome: str) -> None:
    world = World(
        {"kind": "parallel", "policy": policy, "cancel": "join", "children": {"a": leaf(), "b": leaf()}},
        {"a": a, "b": b},
    )
    assert world.run() == 3
    assert world.root.outcome == outcome
    assert world.halted == []


@pytest.mark.parametrize(("policy", "ticks"), [("all", 3), ("any", 1)])
def test_any_succeeds_with_the_first_success_and_fails_only_when_all_failed(policy: str, ticks: int) -> None:
    root = {"kind": "parallel", "policy": policy, "children": {"a": leaf(), "b": leaf()}}
    world = World(root, {"a": "success", "b": "..success"})
    assert world.run() == ticks
    world = World({**root, "policy": "any"}, {"a": "failure.no_ik", "b": "..failure.no_plan"})
    assert world.run() == 3
    assert (world.root.outcome, world.reason) == ("failure", "no_ik")


@pytest.mark.parametrize(("kind", "status"), [("sequence", Status.SUCCESS), ("fallback", Status.FAILURE)])
def test_a_composite_without_children_ends_as_in_py_trees(kind: str, status: Status) -> None:
    assert World({"kind": kind, "children": {}}).tick() == status


def test_a_composite_entered_again_starts_from_its_first_child() -> None:
    world = World(
        {"kind": "retry", "times": 2, "child": {"s": {"kind": "sequence", "children": {"a": leaf(), "b": leaf()}}}},
        {"b": "failure success"},
    )
    assert world.run() == 2
    assert world.ticked == ["s/a", "s/b", "s/a", "s/b"]


def test_halting_interrupts_what_is_active_and_nothing_else() -> None:
    world = World(
        {
            "kind": "sequence",
            "children": {"a": leaf(), "p": {"kind": "parallel", "children": {"b": leaf(), "c": leaf()}}},
        },
        {"b": "...success", "c": "success"},
    )
    world.tick()
    world.root.stop(Status.INVALID)
    assert world.halted == ["p/b"]
    assert [event for event in world.events if event[0] == "interrupted"] == [
        ("interrupted", "p/b"),
        ("interrupted", "p"),
        ("interrupted", "/"),
    ]
    assert world.root.outcome is None


def test_an_interrupted_tree_can_run_again_from_the_start() -> None:
    world = World({"kind": "sequence", "children": {"a": leaf(), "b": leaf()}}, {"b": "...success success"})
    world.tick()
    world.root.stop(Status.INVALID)
    assert world.tick() == Status.SUCCESS
    assert world.ticked == ["a", "b", "a", "b"]
