"""Machines of what chooses, and of nodes that never begin: exact, with labels for their codes, and stoppable."""

from __future__ import annotations

from typing import Any

import pytest
from test_compilers_machine import LEAF, edges, machine_of

from grip_bt.base.errors import NodeError, NotExpressibleError
from grip_bt.compilers import Halted, Rushing
from grip_bt.smach_compat import StateMachine

ITEMS = {"data": {"some": {"type": "list[int]", "value": [1, 2]}}, "items": "some", "item": "one"}


def switch(**more: Any) -> dict[str, Any]:
    return {"kind": "switch", "on_value": "2", "cases": {"a": 1, "b": 2}, "children": {"a": LEAF, "b": LEAF}, **more}


class Stopping(Rushing):
    """Stops the run when it is asked for the n-th time."""

    def __init__(self, turns: int):
        self.turns = turns

    def turn(self) -> int:
        self.turns -= 1
        if self.turns < 0:
            raise Halted
        return 0


def test_a_switch_is_a_machine_whose_first_state_chooses() -> None:
    compiled, saw = machine_of(switch(), embed=False)
    machine = compiled.by_path["/"]
    assert isinstance(machine, StateMachine)
    assert edges(machine) >= {("again?", "do a", "a"), ("again?", "do b", "b")}
    assert compiled.execute(Rushing()).outcome == "success"
    assert [path for path, _ in saw] == ["b"]


def test_a_loop_a_for_each_and_a_cooldown_are_exact_too() -> None:
    for node, count in (
        ({"kind": "loop", "times": 3, "child": {"a": LEAF}}, 3),
        ({"kind": "for_each", **ITEMS, "child": {"a": LEAF}}, 2),
    ):
        compiled, saw = machine_of(node, embed=False)
        compiled.execute(Rushing())
        assert len(saw) == count
    machine_of({"kind": "cooldown", "seconds": 1, "child": {"a": LEAF}}, embed=False)


def test_the_code_of_a_choice_has_a_label_where_an_edge_uses_it() -> None:
    no_case = switch(on_value="3", on={"success": "done", "failure": "lost", "failure.no_case": "done"})
    outcomes = {"done": "success", "lost": "failure"}
    root = {"kind": "state_machine", "initial": "s", "outcomes": outcomes, "children": {"s": no_case}}
    compiled, saw = machine_of({**root, "on": {"done": "success", "lost": "failure"}}, embed=False)
    assert compiled.execute(Rushing()).outcome == "success"
    assert saw == []


@pytest.mark.parametrize("refused", [{"precondition": "1 > 2", **switch()}, switch(on_value="3")])
def test_a_machine_that_goes_round_without_beginning_anything_can_be_stopped(refused: dict[str, Any]) -> None:
    on = {"on": {"success": "s", "failure": "s"}}
    root = {
        "kind": "state_machine",
        "initial": "s",
        "outcomes": {"success": "success"},
        "children": {"s": refused | on},
    }
    compiled, saw = machine_of(root)
    with pytest.raises(Halted):
        compiled.execute(Stopping(50))
    assert saw == []


def test_a_condition_that_cant_be_computed_is_an_error_of_its_node_in_a_machine_too() -> None:
    compiled, _ = machine_of({"kind": "sequence", "children": {"s": switch(on_value="1 / 0")}})
    with pytest.raises(NodeError, match="s: EvaluationError: `1 / 0`: division by zero"):
        compiled.execute(Rushing())


def test_a_foreign_behaviour_is_one_state_and_a_guard_interrupts() -> None:
    foreign = {"kind": "foreign", "behaviour": "py_trees.behaviours:Success"}
    compiled, _ = machine_of({"kind": "sequence", "children": {"f": foreign}}, embed=False)
    assert compiled.execute(Rushing()).outcome == "success"
    with pytest.raises(NotExpressibleError, match="guard"):
        machine_of({"kind": "guard", "if": "true", "child": {"a": LEAF}}, embed=False)
