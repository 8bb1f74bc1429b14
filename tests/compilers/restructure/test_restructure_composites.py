"""State machines -> composites: chains, loops, labels, and the machines that have no structure."""

from __future__ import annotations

from typing import Any

import pytest
from restructure_tasks import CATALOG, leaf, machine, task

from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.restructure import to_state_machines, to_trees
from grip_bt.task import dumps, walk


def converted(root: dict[str, Any]) -> dict[str, Any]:
    result = to_trees(task(root), CATALOG)
    assert result.notes == ()
    return result.task.root.model_dump(by_alias=True, exclude_defaults=True)


def test_a_chain_of_successes_is_a_plain_sequence() -> None:
    root = converted(
        machine("a", {"a": {"success": "b", "failure": "failure"}, "b": {"success": "success", "failure": "failure"}})
    )
    assert root == {"kind": "sequence", "children": {"a": leaf(), "b": leaf()}}


def test_a_chain_of_failures_is_a_plain_fallback() -> None:
    root = converted(
        machine("a", {"a": {"success": "success", "failure": "b"}, "b": {"success": "success", "failure": "failure"}})
    )
    assert root == {"kind": "fallback", "children": {"a": leaf(), "b": leaf()}}


def test_the_first_state_comes_first_and_not_the_first_in_the_file() -> None:
    root = converted(
        machine("b", {"a": {"success": "success", "failure": "failure"}, "b": {"success": "a", "failure": "failure"}})
    )
    assert list(root["children"]) == ["b", "a"]


def test_a_loop_is_a_repeat_that_is_left_by_labels() -> None:
    root = converted(machine("a", {"a": {"success": "a", "failure": "out"}}, out="failure"))
    assert root["kind"] == "repeat"
    assert root["exits"] == {"a.failure": "out"}
    assert root["child"] == {"a": leaf()}


def test_a_loop_on_failure_goes_round_through_a_label() -> None:
    root = converted(machine("a", {"a": {"success": "success", "failure": "a"}}))
    assert root["kind"] == "repeat"
    assert root["exits"] == {"try_a.success": "success"}
    inner = root["child"]["try_a"]
    assert inner["outcomes"] == {"a": "success"}
    assert inner["exits"] == {"a.failure": "a"}


def test_where_both_ends_go_on_the_outcome_is_forced() -> None:
    root = converted(
        machine("a", {"a": {"success": "b", "failure": "b"}, "b": {"success": "success", "failure": "failure"}})
    )
    assert root["children"]["try_a"] == {"kind": "force", "as": "success", "child": {"a": leaf()}}


def test_a_code_that_goes_elsewhere_than_its_outcome_keeps_its_edge() -> None:
    root = converted(
        machine(
            "a",
            {
                "a": {"success": "success", "failure.no_ik": "b", "failure": "failure"},
                "b": {"success": "success", "failure": "failure"},
            },
        )
    )
    assert root["children"]["try_a"]["exits"] == {"a.failure.no_ik": "b", "a.failure": "failure"}


def test_a_shared_recovery_follows_the_chain_that_leads_to_it() -> None:
    before = task(
        machine(
            "approach",
            {
                "approach": {"success": "close", "failure": "retreat"},
                "close": {"success": "lifted", "failure": "retreat"},
                "retreat": {"success": "missed", "failure": "missed"},
            },
            lifted="success",
            missed="failure",
        ),
        outcomes={"lifted": "success", "missed": "failure"},
    )
    result = to_trees(before, CATALOG)
    assert result.paths["close"] == "approach_then_close/close"
    assert result.paths["retreat"] == "retreat"
    assert result.task.root.kind == "fallback"
    assert result.task.outcomes == before.outcomes
    assert {result.paths[path] for path, _ in walk(before.root)} <= {path for path, _ in walk(result.task.root)}


def test_new_names_are_free() -> None:
    root = machine(
        "a",
        {
            "a": {"success": "b", "failure": "a_then_b"},
            "b": {"success": "success", "failure": "a_then_b"},
            "a_then_b": {"success": "success", "failure": "failure"},
        },
    )
    names = [path.rsplit("/", 1)[-1] for path, _ in walk(to_trees(task(root), CATALOG).task.root)]
    assert len(names) == len(set(names))
    assert "a_then_b_2" in names


def test_a_loop_with_two_ways_in_stays_and_the_edges_are_named() -> None:
    root = machine(
        "start",
        {
            "start": {"success": "a", "failure": "b"},
            "a": {"success": "b", "failure": "failure"},
            "b": {"success": "a", "failure": "success"},
        },
    )
    before = task(root)
    result = to_trees(before, CATALOG)
    assert result.task == before
    (note,) = result.notes
    assert note.path == "/"
    assert note.reason.count("->") == 1
    with pytest.raises(NotExpressibleError, match="->"):
        result.require_all("a behaviour tree")


def test_without_the_named_edges_the_machine_has_a_structure() -> None:
    states = {
        "start": {"success": "a", "failure": "b"},
        "a": {"success": "b", "failure": "failure"},
        "b": {"success": "a", "failure": "failure"},
    }
    reason = to_trees(task(machine("start", states)), CATALOG).notes[0].reason
    named = [label for state, on in states.items() for label in (f"{state}.{k} -> {v}" for k, v in on.items())]
    (edge,) = [label for label in named if label in reason]
    state, label = edge.split(" -> ")[0].split(".")
    states[state][label] = "failure"
    assert to_trees(task(machine("start", states)), CATALOG).notes == ()


def test_a_state_that_is_never_reached_is_not_thrown_away() -> None:
    root = machine(
        "a", {"a": {"success": "success", "failure": "failure"}, "b": {"success": "success", "failure": "failure"}}
    )
    result = to_trees(task(root), CATALOG)
    assert result.task.root.kind == "state_machine"
    assert "b" in result.task.root.children
    assert "never reached" in result.notes[0].reason


def test_a_machine_that_stays_has_edges_for_all_ends_of_its_new_children() -> None:
    inner = machine("x", {"x": {"success": "done", "failure": "done"}}, done="success")
    outer = machine(
        "a",
        {
            "a": {"success": "b", "failure": "c"},
            "b": {"success": "c", "failure": "failure"},
            "c": {"success": "b", "failure": "success"},
        },
    )
    outer["children"]["b"] = {**inner, "on": {"done": "c"}}
    result = to_trees(task(outer), CATALOG)
    assert result.task.root.kind == "state_machine"
    inside = result.task.root.children["b"]
    assert inside.kind == "sequence"
    assert inside.on == {"done": "c", "success": "c", "failure": "c"}


def test_there_and_back_gives_the_same_bytes_for_plain_composites() -> None:
    before = task(
        {
            "kind": "sequence",
            "data": {"v": "int"},
            "children": {
                "a": leaf(out={"x": "v"}),
                "f": {"kind": "fallback", "children": {"b": leaf(), "c": leaf()}},
                "r": {"kind": "retry", "times": 2, "child": {"d": leaf()}},
            },
        }
    )
    there = to_state_machines(before, CATALOG).task
    assert there != before
    assert dumps(to_trees(there, CATALOG).task) == dumps(before)


def test_a_machine_of_many_states_is_structured() -> None:
    states = {f"s{i}": {"success": f"s{i + 1}", "failure": "failure"} for i in range(300)}
    states["s300"] = {"success": "success", "failure": "s0"}
    assert to_trees(task(machine("s0", states)), CATALOG).notes == ()


def test_a_structure_that_nobody_could_follow_is_refused() -> None:
    states = {f"s{i}": {"success": f"s{i + 1}", "failure": f"s{min(i + 2, 400)}"} for i in range(400)}
    states["s400"] = {"success": "success", "failure": "failure"}
    (note,) = to_trees(task(machine("s0", states)), CATALOG).notes
    assert "levels" in note.reason
