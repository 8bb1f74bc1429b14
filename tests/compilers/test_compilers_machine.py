"""Graph -> machine: containers, transitions, labels of failure codes, embedded parts, preempt requests."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from py_trees.common import Status

from grip_bt import smach_compat
from grip_bt.base.errors import NodeError, NotExpressibleError
from grip_bt.compilers import BehaviourState, Halted, Rushing, to_machine
from grip_bt.nodes import Leaf
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

CATALOG = Catalog([Manifest(id="test/leaf", doc="Ends as it is told.", implementation="tests:Told")])


class Told(Leaf):
    told: dict[str, str]
    saw_preempt: list[tuple[str, bool]]
    machine: Any = None

    def update(self) -> Status:
        if self.told.get(self.path) == "ask":
            self.machine.request_preempt()
        self.saw_preempt.append((self.path, self.context.preempt_requested))
        code = self.told.get(self.path, "")
        if code.startswith("runs"):
            return self.running()
        if code == "breaks":
            raise RuntimeError("broken")
        return self.fail(code) if code not in ("", "ask") else self.end()

    def terminate(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.told.get(self.path) == "runs and can't be stopped":
            raise RuntimeError("no way to stop")


class Context:
    preempt_requested = False

    def wake(self) -> None:
        """Nobody waits."""


def machine_of(root: dict[str, Any], told: dict[str, str] | None = None, **options: Any) -> Any:
    saw: list[tuple[str, bool]] = []

    def make(path: str, node: Any, manifest: Manifest) -> Leaf:
        leaf = Told(path, path, manifest, {}, {})
        leaf.told, leaf.saw_preempt = told or {}, saw
        return leaf

    task = Task.model_validate({"grip": 1, "name": "tested", "root": root})
    compiled = to_machine(task, CATALOG, leaf_factory=make, **options)
    for leaf in compiled.leaves.values():
        leaf.machine = compiled
    compiled.prepare(Context())
    return compiled, saw


LEAF = {"node": "test/leaf"}


def edges(container: Any) -> set[tuple[str, str, str]]:
    return {(label, outcome, target) for outcome, label, target in container.get_internal_edges()}


def test_a_sequence_is_a_machine_whose_successes_lead_on() -> None:
    compiled, _ = machine_of({"kind": "sequence", "children": {"a": LEAF, "b": LEAF}})
    root = compiled.by_path["/"]
    assert isinstance(root, smach_compat.StateMachine)
    assert edges(root) == {
        ("a", "success", "b"),
        ("a", "failure", "failure"),
        ("b", "success", "success"),
        ("b", "failure", "failure"),
    }
    assert root.get_initial_states() == ["a"]


def test_a_fallback_is_a_machine_whose_failures_lead_on() -> None:
    compiled, _ = machine_of({"kind": "fallback", "children": {"a": LEAF, "b": LEAF}})
    assert ("a", "failure", "b") in edges(compiled.by_path["/"])


def test_a_failure_code_has_a_label_only_where_an_edge_uses_it_however_far_out() -> None:
    inner = {"kind": "sequence", "children": {"a": LEAF, "b": LEAF}}
    outer = {
        "kind": "fallback",
        "outcomes": {"unreachable": "failure"},
        "exits": {"inner.failure.no_ik": "unreachable"},
        "on": {"unreachable": "failure"},
        "children": {"inner": inner, "other": LEAF},
    }
    compiled, _ = machine_of(outer, {"inner/b": "no_ik"})
    assert compiled.by_path["inner/a"].get_registered_outcomes() == ("success", "failure", "failure.no_ik")
    assert ("b", "failure.no_ik", "failure.no_ik") in edges(compiled.by_path["inner"])
    assert ("inner", "failure.no_ik", "unreachable") in edges(compiled.by_path["/"])
    assert compiled.by_path["other"].get_registered_outcomes() == ("success", "failure")
    end = compiled.execute(Rushing())
    assert (end.outcome, end.failure.code) == ("failure", "no_ik")


def test_a_child_named_like_an_outcome_is_not_taken_for_its_target() -> None:
    compiled, saw = machine_of({"kind": "sequence", "children": {"failure": LEAF, "success": LEAF}}, {"success": "x"})
    assert compiled.execute(Rushing()).outcome == "failure"
    assert [path for path, _ in saw] == ["failure", "success"]


@pytest.mark.parametrize(
    "root",
    [
        {"kind": "sequence", "memory": False, "children": {"a": LEAF}},
        {"kind": "fallback", "memory": False, "children": {"a": LEAF}},
        {"kind": "timeout", "seconds": 1, "child": {"a": LEAF}},
        {"kind": "parallel", "children": {"a": LEAF}},
    ],
)
def test_what_interrupts_a_running_child_is_one_state_or_refused(root: dict[str, Any]) -> None:
    compiled, _ = machine_of({"kind": "sequence", "children": {"first": LEAF, "inside": root}})
    state = compiled.by_path["inside"]
    assert isinstance(state, BehaviourState)
    assert not isinstance(state.node, Leaf)
    assert "inside/a" in compiled.leaves
    with pytest.raises(NotExpressibleError, match=f"inside: a {root['kind']} that interrupts"):
        machine_of({"kind": "sequence", "children": {"first": LEAF, "inside": root}}, embed=False)


def test_a_parallel_that_joins_is_a_concurrence() -> None:
    root = {"kind": "parallel", "cancel": "join", "children": {"a": LEAF, "b": LEAF}}
    compiled, saw = machine_of(root, {"b": "no_ik"})
    assert isinstance(compiled.by_path["/"], smach_compat.Concurrence)
    end = compiled.execute(Rushing())
    assert (end.outcome, end.failure.code) == ("failure", "no_ik")
    assert sorted(path for path, _ in saw) == ["a", "b"]


def test_a_preempt_request_travels_to_every_later_leaf_and_recovery_runs() -> None:
    root = {
        "kind": "fallback",
        "children": {
            "try": {"kind": "sequence", "children": {"a": LEAF, "b": LEAF, "c": LEAF}},
            "recover": {"kind": "parallel", "cancel": "join", "children": {"d": LEAF, "e": LEAF}},
        },
    }
    compiled, saw = machine_of(root, {"try/b": "ask", "try/c": "preempted"})
    assert compiled.execute(Rushing()).outcome == "success"
    assert dict(saw) == {"try/a": False, "try/b": True, "try/c": True, "recover/d": True, "recover/e": True}


def test_the_machine_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    compiled, _ = machine_of({"kind": "sequence", "children": {"a": LEAF}})
    capsys.readouterr()
    compiled.execute(Rushing())
    assert capsys.readouterr().out == ""


def test_a_machine_runs_again_after_its_end() -> None:
    compiled, saw = machine_of({"kind": "retry", "times": 2, "child": {"a": LEAF}}, {"a": "no_ik"})
    for _ in range(2):
        assert compiled.execute(Rushing()).failure.code == "no_ik"
    assert len(saw) == 4


STEPS = {"kind": "sequence", "children": {"a": LEAF, "b": LEAF, "c": LEAF}}


def during(leaf: Told, action: Callable[[], None]) -> None:
    """Have something happen while a leaf is active."""
    update = leaf.update

    def acting() -> Status:
        action()
        return update()

    leaf.update = acting  # type: ignore[method-assign]


def test_who_begins_to_listen_in_the_middle_hears_of_the_very_next_transition() -> None:
    compiled, _ = machine_of(STEPS)
    (steps,) = compiled.machine.get_children().values()
    heard: list[list[str]] = []
    during(compiled.leaves["b"], lambda: steps.register_transition_cb(lambda ud, active: heard.append(list(active))))
    compiled.execute(Rushing())
    assert heard == [["c"]]


def test_a_shutdown_that_is_asked_for_in_the_middle_stops_before_the_next_state() -> None:
    compiled, saw = machine_of(STEPS)
    usual = smach_compat.is_shutdown
    during(compiled.leaves["b"], lambda: smach_compat.set_shutdown_check(lambda: True))
    try:
        with pytest.raises(Halted):
            compiled.execute(Rushing())
    finally:
        smach_compat.set_shutdown_check(usual)
    assert [path for path, _ in saw] == ["a", "b"]


def test_a_transition_that_is_edited_in_the_middle_is_followed_as_it_is_then() -> None:
    compiled, saw = machine_of(STEPS)
    (steps,) = compiled.machine.get_children().values()

    def past_the_second() -> None:
        steps._transitions["a"]["success"] = "c"

    during(compiled.leaves["a"], past_the_second)
    assert compiled.execute(Rushing()).outcome == "success"
    assert [path for path, _ in saw] == ["a", "c"]


def at_once(*names: str, **more: Any) -> dict[str, Any]:
    return {"kind": "parallel", "children": dict.fromkeys(names, LEAF), **more}


def test_an_error_says_what_else_went_wrong_while_everything_was_stopped() -> None:
    told = {"a": "runs and can't be stopped", "b": "breaks"}
    machine, _ = machine_of(at_once("a", "b"), told)
    with pytest.raises(NodeError, match="broken") as caught:
        machine.execute(Rushing())
    assert caught.value.path == "b"
    assert caught.value.__notes__ == ["while stopping a: RuntimeError: no way to stop"]


@pytest.mark.parametrize("broken", ["a", "b/c"])
def test_an_error_in_one_thread_ends_what_runs_in_the_others(broken: str) -> None:
    root = at_once("a", cancel="join")
    root["children"] |= {"b": {"kind": "switch", "on_value": "1 / 0", "cases": {"c": 1}, "children": {"c": LEAF}}}
    if broken == "a":
        root["children"]["b"]["on_value"] = "1"
    machine, _ = machine_of(root, {"a": "runs", "b/c": "runs", broken: "breaks"})
    with pytest.raises(NodeError) as caught:
        machine.execute(Rushing())
    assert caught.value.path == ("a" if broken == "a" else "b")


@pytest.mark.parametrize(("code", "outcome"), [("no_ik", "known"), ("no_plan", "failure")])
def test_the_code_of_a_parallel_that_joins_leads_where_its_edge_says(code: str, outcome: str) -> None:
    joined = at_once("a", "b", cancel="join")
    joined["on"] = {"success": "known", "failure": "failure", "failure.no_ik": "known"}
    ends = {"known": "success", "failure": "failure"}
    root = {"kind": "state_machine", "initial": "p", "outcomes": ends, "children": {"p": joined}}
    machine, _ = machine_of({**root, "on": {"known": "success"}}, {"p/b": code})
    assert machine.execute(Rushing()).outcome == ("success" if outcome == "known" else "failure")
