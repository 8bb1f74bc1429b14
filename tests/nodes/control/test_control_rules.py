"""Parallels with rules: who is waited for, which rule wins, and what becomes of those that still run."""

from __future__ import annotations

from typing import Any

import pytest
from control_world import World, leaf
from py_trees.common import Status

from grip_bt.base.errors import DocumentError, InvalidTaskError
from grip_bt.task import loads


def parallel(*names: str, **more: Any) -> dict[str, Any]:
    return {"kind": "parallel", "children": {name: leaf() for name in names}, **more}


WON = {"won": "success", "lost": "failure"}


def test_the_first_rule_that_matches_wins() -> None:
    rules = [
        {"when": {"a": "none", "b": "success"}, "then": "lost"},
        {"when": {"a": ["success", "none"]}, "then": "won"},
        {"when": {"a": "success"}, "then": "lost"},
    ]
    world = World(parallel("a", "b", rules=rules, outcomes=WON), {"b": ".failure"})
    assert world.tick() == Status.SUCCESS
    assert world.root.outcome == "won"
    assert world.halted == ["b"]


def test_a_rule_can_ask_for_a_failure_code_and_the_parallel_carries_up_the_reason() -> None:
    rules = [{"when": {"a": "failure.no_ik"}, "then": "lost"}]
    world = World(parallel("a", "b", rules=rules, outcomes=WON), {"a": "failure.no_ik", "b": "..success"})
    assert world.tick() == Status.FAILURE
    assert (world.root.outcome, world.reason) == ("lost", "no_ik")


def test_n_of_m_is_a_rule() -> None:
    rules = [{"at_least": 2, "then": "success"}, {"at_least": 2, "ends": "failure", "then": "failure"}]
    scripts = {"a": "success", "b": ".failure", "c": "..success"}
    world = World(parallel("a", "b", "c", rules=rules), scripts)
    assert world.run() == 3
    assert world.root.outcome == "success"
    world = World(parallel("a", "b", "c", rules=rules), {**scripts, "c": ".failure.x"})
    assert world.run() == 2
    assert world.root.outcome == "failure"


def test_what_no_rule_decides_the_policy_does_when_all_have_ended() -> None:
    rules = [{"when": {"a": "none"}, "then": "won"}]
    world = World(parallel("a", "b", rules=rules, outcomes=WON), {"a": "failure", "b": "..success"})
    assert world.run() == 3
    assert world.root.outcome == "failure"


def test_a_rule_without_conditions_is_for_the_rest() -> None:
    rules = [{"when": {"a": "none"}, "then": "lost"}, {"then": "won"}]
    world = World(parallel("a", "b", rules=rules, outcomes=WON), {"a": "failure", "b": "..success"})
    assert world.run() == 3
    assert world.root.outcome == "won"


@pytest.mark.parametrize(
    ("wait_for", "ticks", "outcome"),
    [("any", 2, "success"), (2, 3, "failure"), (["c"], 4, "failure"), (["a"], 2, "success"), ("all", 5, "failure")]
    + [(3, 4, "failure"), (4, 5, "failure"), (["a", "c"], 4, "failure"), (9, 5, "failure")],
)
def test_nothing_is_decided_before_those_who_are_waited_for_have_ended(wait_for: Any, ticks: int, outcome: str) -> None:
    scripts = {"a": ".success", "b": "..failure", "c": "...success", "d": "....success"}
    world = World(parallel("a", "b", "c", "d", wait_for=wait_for), scripts)
    assert world.run() == ticks
    assert world.root.outcome == outcome


def test_an_exit_waits_for_those_who_are_waited_for_and_a_rule_for_the_rest_no_longer() -> None:
    root = parallel("a", "b", "c", wait_for=["b"], exits={"a.failure": "won"}, outcomes=WON)
    world = World(root, {"a": "failure", "b": "..success", "c": "....success"})
    assert (world.run(), world.root.outcome) == (3, "won")
    root = parallel("a", "b", "c", wait_for=2, rules=[{"then": "won"}], outcomes=WON)
    world = World(root, {"b": "..failure", "c": "....success"})
    assert (world.run(), world.root.outcome, world.halted) == (3, "won", ["c"])


def test_who_is_asked_sees_a_preempt_request_and_is_waited_for() -> None:
    root = parallel("a", "b", cancel="ask", policy="any")
    world = World(
        {"kind": "sequence", "children": {"p": root, "after": leaf()}}, {"b": "...failure.late", "after": "."}
    )
    b, after = world.tree.by_path["p/b"], world.tree.by_path["after"]
    world.tick()
    assert b.context.preempt_requested
    assert world.wakes == 1  # who is asked looks at once, without waiting for something to happen
    assert world.tick(2) == Status.RUNNING
    assert world.wakes == 1
    assert world.halted == []
    world.tick()
    assert world.ticked.count("p/b") == 4
    assert ("exit", "p", "success") in world.events
    assert not after.context.preempt_requested


def test_a_request_is_over_when_the_parallel_begins_anew() -> None:
    root = parallel("a", "b", cancel="ask", policy="any")
    world = World({"kind": "repeat", "times": 2, "child": {"p": root}}, {"a": "success ....success", "b": ".success"})
    world.tick(2)
    assert world.tree.by_path["p/b"].context.preempt_requested
    world.tick()
    assert not world.tree.by_path["p/b"].context.preempt_requested


@pytest.mark.parametrize(
    ("more", "code"),
    [
        ({"rules": [{"when": {"z": "success"}, "then": "success"}]}, "unknown-child"),
        ({"rules": [{"when": {"a": "odd"}, "then": "success"}]}, "unknown-outcome"),
        ({"rules": [{"then": "odd"}]}, "unknown-target"),
        ({"wait_for": ["z"]}, "unknown-child"),
    ],
)
def test_rules_about_what_isnt_there_arent_compiled(more: dict[str, Any], code: str) -> None:
    with pytest.raises(InvalidTaskError, match=code):
        World(parallel("a", "b", **more))


def test_join_with_wait_for_is_refused_in_words() -> None:
    text = "grip: 1\nname: t\nroot:\n  kind: parallel\n  cancel: join\n  wait_for: any\n  children: {b: {node: c}}\n"
    with pytest.raises(DocumentError, match="waits for all children"):
        loads(text, "t.yaml")
