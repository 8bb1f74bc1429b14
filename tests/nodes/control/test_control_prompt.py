"""Containers that decide within a tick: a switch without memory, a prompt parallel."""

from __future__ import annotations

from typing import Any

import pytest
from control_world import World, leaf
from py_trees.common import Status
from pydantic import ValidationError

from grip_bt.task.model import Parallel

COUNT = {"count": {"type": "int", "value": 0}}
UP = {"node": "test/leaf", "in": {"a": "count"}, "out": {"x": "count"}}


def prompt(**more: Any) -> dict[str, Any]:
    return {"kind": "parallel", "prompt": True, "children": {n: leaf() for n in ("a", "b", "c")}, **more}


def test_a_prompt_parallel_ticks_nobody_after_the_child_that_decides() -> None:
    world = World(prompt(), {"a": ".success", "b": "..success .failure", "c": "...success"})
    assert world.tick() == Status.RUNNING
    assert world.ticked == ["a", "b", "c"]
    world = World(prompt(), {"a": "..success", "b": "failure.slip"})
    assert world.tick() == Status.FAILURE
    assert (world.ticked, world.halted, world.reason) == (["a", "b"], ["a"], "slip")


def test_a_prompt_parallel_reads_its_rules_after_each_child() -> None:
    rules = [{"at_least": 1, "then": "success"}, {"at_least": 2, "ends": "failure", "then": "failure"}]
    world = World(prompt(rules=rules), {"a": "failure", "b": ".success", "c": "...success"})
    assert world.tick() == Status.RUNNING
    assert world.tick() == Status.SUCCESS
    assert world.ticked == ["a", "b", "c", "b"]
    assert world.halted == ["c"]


def test_a_prompt_parallel_begins_anew_and_without_children_it_succeeds() -> None:
    root = {"kind": "repeat", "times": 2, "child": {"p": prompt()}}
    world = World(root, {"b": "failure"})
    assert world.tick() == Status.FAILURE
    assert World(prompt(children={})).tick() == Status.SUCCESS
    root = {"kind": "retry", "times": 2, "child": {"p": prompt()}}
    world = World(root, {"b": "failure success"})
    assert world.run() == 2
    assert world.ticked == ["p/a", "p/b", "p/a", "p/b", "p/c"]


def test_prompt_is_for_parallels_that_halt() -> None:
    with pytest.raises(ValidationError, match="`prompt` halts what still runs at once"):
        Parallel.model_validate(prompt(cancel="join"))


def switch(**more: Any) -> dict[str, Any]:
    cases, both = {"few": True}, {"few": leaf(), "many": leaf()}
    chosen = {"kind": "switch", "memory": False, "on_value": "count < 2", "cases": cases, "default": "many"}
    turn = {**chosen, "children": both, **more}
    return {
        "kind": "parallel",
        "order": "declared",
        "children": {"up": {"kind": "repeat", "child": {"n": UP}}, "s": turn},
    }


def test_a_switch_without_memory_halts_the_running_child_before_another_begins() -> None:
    world = World(switch(), {"few": ".....success", "many": ".success"}, data=COUNT)
    assert world.tick() == Status.RUNNING
    assert (world.ticked, world.halted) == (["up/n", "s/few"], [])
    world.tick()
    assert (world.ticked[-2:], world.halted) == (["up/n", "s/many"], ["s/few"])
    at = [e for e in world.events if e[1] in ("s/few", "s/many")]
    assert at == [("enter", "s/few"), ("interrupted", "s/few"), ("enter", "s/many")]


def test_a_switch_without_memory_fails_when_the_value_has_no_case_any_more() -> None:
    world = World(switch(default=""), {"few": ".....success"}, data=COUNT)
    assert world.tick() == Status.RUNNING
    assert world.tick() == Status.FAILURE
    assert (world.halted, world.reason) == (["s/few"], "no_case")


def test_a_switch_without_memory_stays_with_a_child_that_is_still_right() -> None:
    world = World(switch(on_value="count < 9"), {"few": "..success"}, data=COUNT)
    world.tick(3)
    assert [e for e in world.events if e[1] == "s/few"] == [("enter", "s/few"), ("exit", "s/few", "success")]
