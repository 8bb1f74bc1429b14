"""Switch, loop, for_each and cooldown: who is run, what ends them, and with which reason."""

from __future__ import annotations

from typing import Any

import pytest
from control_world import World, leaf
from py_trees.common import Status

from grip_bt.base.errors import DocumentError, InvalidTaskError, NodeError
from grip_bt.task import loads

COUNT = {"count": {"type": "int", "value": 0}}
UP = {"node": "test/leaf", "in": {"a": "count"}, "out": {"x": "count"}}


def switch(**more: Any) -> dict[str, Any]:
    children = {"one": leaf(), "some": leaf(), "rest": leaf()}
    return {"kind": "switch", "on_value": "value", "cases": {"one": 1, "some": [2, "3"]}, "children": children, **more}


@pytest.mark.parametrize(
    ("value", "taken"), [(1, ["one"]), (1.0, ["one"]), (2, ["some"]), ("3", ["some"]), (3, ["rest"]), (True, ["rest"])]
)
def test_a_switch_takes_the_child_whose_literal_is_the_value(value: Any, taken: list[str]) -> None:
    world = World(switch(default="rest"), data={"value": {"type": "Any", "value": value}})
    assert world.tick() == Status.SUCCESS
    assert world.ticked == taken


def test_a_value_without_a_case_is_a_failure_with_a_code() -> None:
    world = World(switch(), data={"value": {"type": "int", "value": 7}})
    assert world.tick() == Status.FAILURE
    assert (world.ticked, world.reason) == ([], "no_case")


def test_a_switch_stays_with_its_choice_while_the_child_runs_and_chooses_anew_on_entry() -> None:
    cases = {"zero": 0, "one": 1}
    both = {"zero": {"kind": "sequence", "children": {"up": UP, "wait": leaf()}}, "one": leaf()}
    root = {"kind": "switch", "on_value": "count", "cases": cases, "children": both}
    world = World({"kind": "repeat", "times": 2, "child": {"s": root}}, {"wait": "..success"}, data=COUNT)
    assert world.run() == 4
    assert world.ticked == ["s/zero/up", *["s/zero/wait"] * 3, "s/one"]


def test_a_switch_fails_with_the_reason_of_its_child_and_knows_exits() -> None:
    world = World(switch(), {"one": "failure.no_ik"}, data={"value": {"type": "int", "value": 1}})
    world.tick()
    assert world.reason == "no_ik"
    root = switch(outcomes={"odd": "success"}, exits={"one.failure.no_ik": "odd"})
    world = World(root, {"one": "failure.no_ik"}, data={"value": {"type": "int", "value": 1}})
    assert world.tick() == Status.SUCCESS
    assert world.root.outcome == "odd"


def loop(child: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"kind": "loop", "child": {"body": child}, **more}


def test_a_loop_runs_one_pass_a_tick_while_its_condition_holds_and_then_succeeds() -> None:
    world = World(loop(UP, **{"while": "count < 3"}), data=COUNT)
    assert world.run() == 4
    assert world.root.outcome == "success"
    assert world.ticked == ["body"] * 3
    assert world.wakes == 3


def test_a_loop_whose_condition_is_false_at_once_runs_nothing() -> None:
    world = World(loop(UP, **{"while": "count > 0"}), data=COUNT)
    assert world.tick() == Status.SUCCESS
    assert world.ticked == []


def test_a_loop_ends_with_its_childs_failure_or_by_an_exit() -> None:
    world = World(loop(leaf()), {"body": "success success failure.no_plan"})
    assert world.run() == 3
    assert world.reason == "no_plan"
    root = loop(leaf(), outcomes={"found": "success"}, exits={"body.none": "found"})
    world = World(root, {"body": "success none"})
    assert world.run() == 2
    assert world.root.outcome == "found"


def test_the_cap_of_a_loop_counts_afresh_on_each_entry_and_has_a_code_of_its_own() -> None:
    world = World({"kind": "retry", "times": 2, "child": {"loop": loop(leaf(), times=2)}})
    world.run()
    assert world.reason == "loop_limit"
    assert len(world.ticked) == 4


def test_a_condition_that_turns_false_with_the_last_pass_is_a_success() -> None:
    world = World(loop(UP, times=3, **{"while": "count < 3"}), data=COUNT)
    world.run()
    assert world.root.outcome == "success"


def each(child: dict[str, Any], items: Any, **more: Any) -> dict[str, Any]:
    held = {"heights": {"type": "list[int]", "value": items}}
    return {"kind": "for_each", "items": "heights", "item": "height", "data": held, "child": {"go": child}, **more}


def writes(world: World) -> list[Any]:
    return [event[3] for event in world.events if event[0] == "write" and event[2] == "total"]


def test_a_for_each_gives_one_item_a_tick_to_its_child() -> None:
    take = leaf(**{"in": {"a": "height"}, "out": {"x": "total"}})
    world = World(each(take, [4, 7]), data={"total": "int"})
    assert world.run() == 3
    assert writes(world) == [5, 8]


def test_a_for_each_over_nothing_succeeds_and_runs_nothing() -> None:
    world = World(each(leaf(), []))
    assert world.tick() == Status.SUCCESS
    assert world.ticked == []


def test_a_for_each_stops_at_the_first_failure_unless_an_exit_says_otherwise() -> None:
    world = World(each(leaf(), [1, 2, 3]), {"go": "success failure.no_ik"})
    assert world.run() == 2
    assert world.reason == "no_ik"
    root = each(leaf(), [1, 2, 3], outcomes={"enough": "success"}, exits={"go.failure": "enough"})
    world = World(root, {"go": "success failure"})
    world.run()
    assert world.root.outcome == "enough"


def test_the_list_of_a_for_each_is_the_one_that_was_there_on_entry() -> None:
    world = World({"kind": "repeat", "times": 2, "child": {"all": each(leaf(), [1, 2])}})
    world.run()
    assert len(world.ticked) == 4


def test_a_list_that_isnt_one_is_an_error_of_the_run() -> None:
    root = {"kind": "for_each", "items": "things", "item": "thing", "child": {"go": leaf()}}
    with pytest.raises(NodeError, match="not a list"):
        World(root, data={"things": {"type": "Any", "value": 3}}).tick()


def test_an_item_that_is_declared_twice_is_refused_with_its_place() -> None:
    text = (
        "grip: 1\nname: t\nroot:\n  kind: for_each\n  items: a\n  item: a\n  data: {a: int}\n  child: {b: {node: c}}\n"
    )
    with pytest.raises(DocumentError, match="remove it from `data`"):
        loads(text, "t.yaml")


@pytest.mark.parametrize("root", [switch(cases={"two": 1}), {**each(leaf(), [1]), "items": "lengths"}])
def test_a_task_with_names_that_arent_there_isnt_compiled(root: dict[str, Any]) -> None:
    with pytest.raises(InvalidTaskError, match="unknown-child|undeclared-variable"):
        World(root, data={"value": {"type": "int", "value": 7}})


def test_after_its_child_has_ended_a_cooldown_fails_until_its_time_is_over() -> None:
    world = World({"kind": "cooldown", "seconds": 5, "child": {"work": leaf()}})
    assert world.tick() == Status.SUCCESS
    world.clock.advance(4.9)
    assert world.tick() == Status.FAILURE
    assert world.reason == "cooldown"
    world.clock.advance(0.1)
    assert world.tick() == Status.SUCCESS
    assert world.ticked == ["work"] * 2


def test_a_cooldown_counts_from_an_interruption_too_and_a_refusal_doesnt_prolong_it() -> None:
    world = World({"kind": "cooldown", "seconds": 5, "child": {"work": leaf()}}, {"work": "......success"})
    world.tick()
    world.clock.advance(10)
    world.root.stop(Status.INVALID)
    world.clock.advance(3)
    assert world.tick() == Status.FAILURE
    world.clock.advance(2)
    assert world.tick() == Status.RUNNING
