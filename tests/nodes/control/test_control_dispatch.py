"""State machines as a composite: edges, one transition a tick, nesting."""

from __future__ import annotations

import pytest
from control_world import World, leaf
from py_trees.common import Status

from grip_bt.task.parts import Edges


def pick(**more: object) -> dict[str, object]:
    ends = {"none": "missed"}
    return {
        "kind": "state_machine",
        "initial": "approach",
        "outcomes": {"lifted": "success", "missed": "failure"},
        "children": {
            "approach": leaf(on={"success": "close", "failure.no_ik": "missed", "failure": "approach", **ends}),
            "close": leaf(on={"success": "lifted", "failure": "approach", **ends}),
        },
        **more,
    }


ON = {"on": {"lifted": "success", "missed": "failure"}}


def test_a_transition_takes_one_tick_and_wakes_for_the_next() -> None:
    world = World(pick(**ON))
    assert world.tick() == Status.RUNNING
    assert (world.ticked, world.wakes) == (["approach"], 1)
    assert world.tick() == Status.SUCCESS
    assert world.root.outcome == "lifted"


def test_the_edge_with_the_code_wins_and_the_reason_is_carried_up() -> None:
    world = World(pick(**ON), {"approach": "failure.no_plan failure failure.no_ik"})
    assert world.run() == 3
    assert (world.root.outcome, world.reason) == ("missed", "no_ik")


def test_an_end_reached_from_a_success_has_no_reason() -> None:
    world = World(pick(**ON), {"approach": "none"})
    assert world.run() == 1
    assert (world.root.outcome, world.root.failure) == ("missed", None)


def test_a_state_may_follow_itself_and_is_initialised_anew() -> None:
    world = World(pick(**ON), {"approach": "failure .failure success"})
    world.run()
    assert world.ticked.count("approach") == 4
    assert world.events.count(("enter", "approach")) == 3


def test_a_child_keeps_its_state_when_another_one_is_entered() -> None:
    world = World(pick(**ON))
    world.tick()
    assert world.tree.by_path["approach"].status == Status.SUCCESS
    world.tick()
    assert world.tree.by_path["approach"].status == Status.SUCCESS


def test_a_machine_entered_again_starts_at_its_initial_state() -> None:
    world = World({"kind": "retry", "times": 2, "child": {"pick": pick()}}, {"close": "none success"})
    world.run()
    assert world.ticked == ["pick/approach", "pick/close"] * 2


def test_nested_machines_hand_labels_and_codes_to_the_outer_edges() -> None:
    outer = {
        "kind": "state_machine",
        "initial": "pick",
        "outcomes": {"done": "success", "unreachable": "failure"},
        "on": {"done": "success", "unreachable": "failure"},
        "children": {"pick": pick(on={"lifted": "done", "missed": "pick", "missed.no_ik": "unreachable"})},
    }
    world = World(outer, {"approach": "none failure.no_ik"})
    world.run()
    assert (world.root.outcome, world.reason) == ("unreachable", "no_ik")
    assert world.ticked == ["pick/approach", "pick/approach"]


def test_a_sibling_of_the_same_name_wins_over_an_outcome() -> None:
    root = {
        "kind": "state_machine",
        "initial": "a",
        "outcomes": {"b": "success"},
        "on": {"b": "success"},
        "children": {
            "a": leaf(on={"success": "b", "failure": "b", "none": "b"}),
            "b": leaf(on={"success": "a", "failure": "a", "none": "a"}),
        },
    }
    world = World(root)
    assert world.tick(4) == Status.RUNNING
    assert world.ticked == ["a", "b", "a", "b"]


def test_an_end_without_an_edge_is_named() -> None:
    world = World(pick(**ON))
    world.root.answers.edges = Edges.of_children({"approach": {"failure": "approach"}})
    with pytest.raises(LookupError, match="no edge leaves 'approach' by 'success'"):
        world.tick()
