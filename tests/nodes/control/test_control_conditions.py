"""Preconditions and guards: when they are looked at, what they halt, and what they leave alone."""

from __future__ import annotations

import pytest
from control_world import World, leaf
from py_trees.common import Status

from grip_bt.base.errors import InvalidTaskError, NodeError

COUNT = {"count": {"type": "int", "value": 0}}


def test_a_node_whose_precondition_is_false_fails_without_having_begun() -> None:
    world = World(leaf(precondition="count > 0"), data=COUNT)
    assert world.tick() == Status.FAILURE
    assert (world.root.outcome, world.reason) == ("failure", "precondition")
    assert world.ticked == []
    assert world.halted == []
    assert world.events == [("enter", "/"), ("exit", "/", "failure")]


def test_a_precondition_is_looked_at_on_entry_only() -> None:
    count_up = leaf(out={"x": "count"}, **{"in": {"a": "count"}})
    waits = leaf(precondition="count == 0")
    world = World(
        {"kind": "parallel", "children": {"waits": waits, "up": count_up}}, {"waits": "..success"}, data=COUNT
    )
    assert world.run() == 3
    assert world.root.outcome == "success"
    assert world.tree.data[""].cells["count"].value == 1


def test_a_precondition_of_a_container_sees_what_is_around_it_and_leaves_its_variables_alone() -> None:
    inner = {"kind": "sequence", "precondition": "count > 0", "data": {"count": {"type": "int", "value": 9}}}
    world = World({**inner, "children": {"a": leaf()}}, data=COUNT)
    assert world.tick() == Status.FAILURE
    assert world.ticked == []
    assert "`count > 0` is false" in world.root.feedback_message


def test_the_code_of_a_precondition_can_be_led_somewhere() -> None:
    machine = {
        "kind": "state_machine",
        "initial": "a",
        "outcomes": {"skipped": "success", "done": "success", "failure": "failure"},
        "children": {
            "a": leaf(
                precondition="count > 0",
                on={"success": "done", "none": "done", "failure": "failure", "failure.precondition": "skipped"},
            )
        },
    }
    world = World({**machine, "on": {}}, data=COUNT)
    world.run()
    assert world.root.outcome == "skipped"


def test_a_refused_node_may_begin_the_next_time() -> None:
    up = {"node": "test/leaf", "in": {"a": "count"}, "out": {"x": "count"}}
    body = {
        "kind": "fallback",
        "children": {"late": leaf(precondition="count > 1"), "more": {"kind": "invert", "child": {"up": up}}},
    }
    world = World({"kind": "retry", "times": 9, "child": {"body": body}}, data=COUNT)
    world.run()
    assert world.ticked == ["body/more/up", "body/more/up", "body/late"]


def guarded(child: dict, condition: str = "count == 0", **more) -> dict:
    return {"kind": "guard", "if": condition, "child": {"work": child}, **more}


def test_a_guard_passes_on_what_its_child_ends_with() -> None:
    world = World(guarded(leaf()), {"work": ".failure.no_ik"}, data=COUNT)
    assert world.run() == 2
    assert (world.root.outcome, world.reason) == ("failure", "no_ik")


def test_a_guard_that_is_false_on_entry_never_begins_its_child() -> None:
    world = World(guarded(leaf(), "count > 0"), data=COUNT)
    assert world.tick() == Status.FAILURE
    assert world.reason == "guard"
    assert world.ticked == []


def test_a_guard_that_turns_false_halts_its_child_before_ticking_it_and_a_write_wakes_it() -> None:
    up = {"node": "test/leaf", "in": {"a": "count"}, "out": {"x": "count"}}
    root = {"kind": "parallel", "children": {"guard": guarded(leaf()), "up": up}}
    world = World(root, {"work": "....success", "up": ".success"}, data=COUNT)
    world.tick()
    assert world.wakes == 0
    world.tick()
    assert world.wakes == 1
    assert world.ticked == ["guard/work", "up", "guard/work", "up"]
    assert world.tick() == Status.FAILURE
    assert world.halted == ["guard/work"]
    assert world.reason == "guard"


def test_a_guard_sees_its_own_variables_which_begin_anew() -> None:
    up = {"node": "test/leaf", "in": {"a": "count"}, "out": {"x": "count"}}
    body = {"kind": "repeat", "child": {"up": up}}
    root = guarded(body, "count < 3", data=COUNT)
    world = World({"kind": "retry", "times": 2, "child": {"guard": root}})
    world.run()
    assert world.ticked == ["guard/work/up"] * 6


def test_a_guard_with_a_precondition_keeps_its_own_condition() -> None:
    world = World(guarded(leaf(), "count > 0", precondition="count == 0"), data=COUNT)
    assert world.tick() == Status.FAILURE
    assert (world.reason, world.ticked) == ("guard", [])


def test_a_condition_that_cant_be_computed_is_an_error_of_its_node() -> None:
    for root in (guarded(leaf(), "1 / count > 0"), leaf(precondition="1 / count > 0")):
        world = World(root, data=COUNT)
        with pytest.raises(NodeError, match="division by zero"):
            world.tick()


@pytest.mark.parametrize("condition", ["count >", "missing > 0"])
def test_a_task_with_a_condition_that_cant_be_read_isnt_compiled(condition: str) -> None:
    with pytest.raises(InvalidTaskError, match="bad-expression|undeclared-variable"):
        World(guarded(leaf(), condition), data=COUNT)
