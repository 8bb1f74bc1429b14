"""Composites -> state machines: what becomes what, and what stays."""

from __future__ import annotations

from typing import Any

import pytest
from restructure_tasks import CATALOG, leaf, task

from grip_bt.base.errors import InvalidTaskError, NotExpressibleError
from grip_bt.compilers.restructure import to_state_machines
from grip_bt.compilers.restructure.result import COMMON
from grip_bt.task import Fallback, Sequence, StateMachine, dumps, exploration, loads


def converted(root: dict[str, Any], **more: Any) -> dict[str, Any]:
    return to_state_machines(task(root, **more), CATALOG).task.root.model_dump(by_alias=True, exclude_defaults=True)


def edges(root: dict[str, Any]) -> dict[str, dict[str, str]]:
    return {name: child["on"] for name, child in converted(root)["children"].items()}


def test_a_sequence_goes_on_with_success_and_a_fallback_with_failure() -> None:
    children = {"a": leaf(), "b": leaf()}
    assert edges({"kind": "sequence", "children": children}) == {
        "a": {"success": "b", "failure": "failure"},
        "b": {"success": "success", "failure": "failure"},
    }
    assert edges({"kind": "fallback", "children": children}) == {
        "a": {"success": "success", "failure": "b"},
        "b": {"success": "success", "failure": "failure"},
    }


def test_exits_become_edges_and_outcomes_are_declared() -> None:
    root = {
        "kind": "sequence",
        "outcomes": {"lost": "failure"},
        "exits": {"a.failure.no_ik": "success", "b.success": "lost"},
        "children": {"a": leaf(), "b": leaf()},
    }
    assert edges(root)["a"] == {"success": "b", "failure.no_ik": "success", "failure": "failure"}
    assert edges(root)["b"] == {"success": "lost", "failure": "failure"}
    assert converted(root)["outcomes"] == {"success": "success", "failure": "failure", "lost": "failure"}


def test_a_changed_meaning_is_followed() -> None:
    root = {"kind": "sequence", "children": {"a": leaf(meaning={"failure": "success"}), "b": leaf()}}
    assert edges(root)["a"] == {"success": "b", "failure": "b"}


def test_variables_documentation_and_free_data_stay() -> None:
    root = {
        "kind": "fallback",
        "doc": "Either.",
        "x": {"x-place": 3},
        "data": {"v": {"type": "int", "value": 1}},
        "children": {"a": leaf(doc="First.", out={"x": "v"})},
    }
    text = dumps(to_state_machines(task(root), CATALOG).task)
    for kept in ("doc: Either.", "x-place: 3", "v: {type: int, value: 1}", "doc: First.", "out: {x: v}"):
        assert kept in text
    assert dumps(loads(text)) == text


def test_the_inside_of_decorators_and_parallels_that_join_is_converted() -> None:
    inside = {"s": {"kind": "sequence", "children": {"a": leaf(), "b": leaf()}}}
    for outer in (
        {"kind": "retry", "times": 2, "child": inside},
        {"kind": "invert", "child": inside},
        {"kind": "parallel", "cancel": "join", "children": inside},
    ):
        result = to_state_machines(task(outer), CATALOG)
        assert (
            dict(result.task.root.child if "child" in outer else result.task.root.children)["s"].kind == "state_machine"
        )
        assert [note.path for note in result.notes] == ["/"]
        assert result.notes[0].by_design
        result.require_all("a state machine")


@pytest.mark.parametrize(
    "outer",
    [
        {"kind": "timeout", "seconds": 3},
        {"kind": "parallel"},
        {"kind": "sequence", "memory": False},
    ],
    ids=["timeout", "parallel", "reactive"],
)
def test_what_may_be_interrupted_at_any_tick_stays(outer: dict[str, Any]) -> None:
    inside = {"s": {"kind": "sequence", "children": {"a": leaf(), "b": leaf()}}}
    key = "child" if outer["kind"] == "timeout" else "children"
    before = task({**outer, key: inside})
    result = to_state_machines(before, CATALOG)
    assert result.task == before
    note = next(note for note in result.notes if note.path == "s")
    assert "at any tick" in note.reason
    with pytest.raises(NotExpressibleError, match="state machine"):
        result.require_all("a state machine")


def test_a_composite_of_one_child_is_equal_even_where_ticks_are_seen() -> None:
    inside = {"s": {"kind": "sequence", "children": {"a": leaf()}}}
    result = to_state_machines(task({"kind": "timeout", "seconds": 3, "child": inside}), CATALOG)
    assert result.task.root.child["s"].kind == "state_machine"


def test_a_child_with_the_name_of_an_outcome_that_is_led_to_is_refused() -> None:
    root = {"kind": "sequence", "children": {"failure": leaf(), "b": leaf()}}
    result = to_state_machines(task(root), CATALOG)
    assert result.task.root.kind == "sequence"
    assert "'failure'" in result.notes[0].reason


def test_a_wrong_task_is_refused() -> None:
    with pytest.raises(InvalidTaskError):
        to_state_machines(
            task({"kind": "sequence", "exits": {"z.success": "success"}, "children": {"a": leaf()}}), CATALOG
        )


def test_every_key_of_these_kinds_is_kept_or_translated() -> None:
    assert {"doc", "data", "on", "x"} <= COMMON
    assert set(StateMachine.model_fields) - COMMON == {"kind", "initial", "outcomes", "children"}
    for composite in (Sequence, Fallback):
        assert set(composite.model_fields) - COMMON == {"kind", "memory", "outcomes", "exits", "children"}


@pytest.mark.parametrize("kind", ["sequence", "fallback"])
def test_the_work_grows_with_the_children_and_not_with_their_square(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    answered, asked = exploration.answered, 0

    def counted(*args: Any) -> Any:
        nonlocal asked
        asked += 1
        return answered(*args)

    monkeypatch.setattr(exploration, "answered", counted)
    work = []
    for number in (20, 40):
        asked = 0
        converted({"kind": kind, "children": {f"n{i}": leaf() for i in range(number)}})
        work.append(asked)
    assert 0 < work[0] < work[1] < 2.5 * work[0]
