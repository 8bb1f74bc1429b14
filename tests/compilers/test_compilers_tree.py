"""Graph -> tree: structure, bindings, and everything that is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import py_trees
import pytest
from py_trees.common import Status

from grip_bt.base.errors import DataError, InvalidTaskError, NodeError
from grip_bt.compilers import Rushing, to_machine, to_tree
from grip_bt.compilers.scopes import UNSET
from grip_bt.nodes import Leaf
from grip_bt.task.catalog import Catalog, Manifest, TaskTexts
from grip_bt.task.model import KINDS, Task

FACE = Manifest(
    id="test/copy",
    doc="Copies its input.",
    implementation=f"{Path(__file__).resolve()}:Copy",
    parameters={"plus": {"type": "int", "default": 1}, "label": {"type": "str"}},
    inputs={"a": {"type": "int", "required": False}},
    outputs={"x": {"type": "Any"}},
)
INNER = Task.model_validate(
    {
        "grip": 1,
        "name": "inner",
        "inputs": {"i": {"type": "int", "value": 7}},
        "outputs": {"o": "Any"},
        "root": {"node": "test/copy", "with": {"label": "l"}, "in": {"a": "i"}, "out": {"x": "o"}},
    }
)
CATALOG = Catalog([FACE], TaskTexts({"inner.yaml": INNER}))


class Copy(Leaf):
    def update(self) -> Status:
        if self.params["label"] == "text":
            return self.end(x="not a number")
        return self.end(x=self.read("a") + self.params["plus"])


class Context:
    preempt_requested = False

    def wake(self) -> None:
        """Nobody waits."""


def leaf(label: str = "l", **more: Any) -> dict[str, Any]:
    return {"node": "test/copy", "with": {"label": label}, **more}


def compiled(root: dict[str, Any], values: dict[str, Any] | None = None, target: Any = to_tree, **task: Any) -> Any:
    return target(Task.model_validate({"grip": 1, "name": "tested", "root": root, **task}), CATALOG, data=values)


def every_kind() -> dict[str, Any]:
    machine = {
        "kind": "state_machine",
        "initial": "s",
        "outcomes": {"success": "success"},
        "children": {"s": leaf(on={"success": "success", "failure": "success"})},
    }
    return {
        "kind": "sequence",
        "children": {
            "fallback": {"kind": "fallback", "memory": False, "children": {"c": leaf()}},
            "parallel": {"kind": "parallel", "children": {"c": leaf()}},
            "state_machine": machine,
            "retry": {"kind": "retry", "times": 2, "child": {"c": leaf()}},
            "repeat": {"kind": "repeat", "times": 2, "child": {"c": leaf()}},
            "timeout": {"kind": "timeout", "seconds": 1, "child": {"c": leaf()}},
            "guard": {"kind": "guard", "if": "true", "child": {"c": leaf()}},
            "switch": {"kind": "switch", "on_value": "1", "cases": {"c": 1}, "children": {"c": leaf()}},
            "for_each": {
                "kind": "for_each",
                "data": {"some": {"type": "list[int]", "value": []}},
                "items": "some",
                "item": "one",
                "child": {"c": leaf()},
            },
            "loop": {"kind": "loop", "times": 2, "child": {"c": leaf()}},
            "foreign": {"kind": "foreign", "behaviour": "py_trees.behaviours:Success"},
            "subtask": {"kind": "subtask", "task": "inner.yaml"},
            "once": {"kind": "once", "child": {"c": leaf()}},
            "cooldown": {"kind": "cooldown", "seconds": 1, "child": {"c": leaf()}},
            "invert": {"kind": "invert", "child": {"c": leaf()}},
            "force": {"kind": "force", "as": "success", "child": {"c": leaf()}},
            "round_robin": {"kind": "round_robin", "children": {"c": leaf()}},
            "control": {"kind": "control", "children": {"by": leaf(), "c": leaf()}},
        },
    }


def test_every_kind_becomes_the_class_of_py_trees_that_it_is() -> None:
    tree = compiled(every_kind())
    assert {type(tree.by_path[k]).__name__ for k in KINDS if k != "sequence"} == {
        "Fallback",
        "Control",
        "Parallel",
        "StateMachine",
        "Retry",
        "Repeat",
        "Timeout",
        "Guard",
        "Switch",
        "ForEach",
        "Loop",
        "Cooldown",
        "Once",
        "Foreign",
        "Subtask",
        "Invert",
        "Force",
        "RoundRobin",
    }
    assert isinstance(tree.root, py_trees.composites.Sequence)
    assert isinstance(tree.by_path["fallback"], py_trees.composites.Selector)
    assert not tree.by_path["fallback"].memory
    assert isinstance(tree.by_path["parallel"], py_trees.composites.Parallel)
    for kind in ("retry", "repeat", "timeout", "invert"):
        assert isinstance(tree.by_path[kind], py_trees.decorators.Decorator)


def test_the_tree_has_the_documents_names_and_order_and_py_trees_draws_it() -> None:
    tree = compiled(every_kind())
    assert [child.name for child in tree.root.children] == list(every_kind()["children"])
    assert list(tree.leaves) == [path for path in tree.by_path if path.endswith(("/c", "/s", "/by", "subtask/"))]
    drawn = py_trees.display.unicode_tree(tree.root)
    assert drawn.splitlines()[0].strip().endswith("tested")
    assert len(drawn.splitlines()) == len(tree.by_path) + 1  # what the foreign node holds
    assert len(py_trees.display.dot_tree(tree.root).get_nodes()) >= len(tree.by_path)


def test_parameters_have_their_defaults_and_ports_reach_the_innermost_variable() -> None:
    inner = {
        "kind": "sequence",
        "data": {"n": {"type": "int", "value": 10}},
        "children": {"a": leaf(**{"in": {"a": "n"}, "out": {"x": "m"}})},
    }
    tree = compiled(
        {"kind": "sequence", "children": {"s": inner}}, values={"m": 0}, **{"data": {"n": "int", "m": "int"}}
    )
    tree.prepare(Context())
    assert tree.execute(Rushing()).outcome == "success"
    assert tree.data.snapshot() == {("", "m"): 11, ("s", "n"): 10}


@pytest.mark.parametrize("target", [to_tree, to_machine])
def test_reading_an_unwritten_variable_names_path_port_and_variable(target: Any) -> None:
    run = compiled(leaf(**{"in": {"a": "n"}}), target=target, **{"data": {"n": "int"}})
    run.prepare(Context())
    with pytest.raises(NodeError, match="/: port 'a': variable 'n' was read before it was written") as raised:
        run.execute(Rushing())
    assert isinstance(raised.value.cause, DataError)


@pytest.mark.parametrize("target", [to_tree, to_machine])
def test_writing_a_value_of_a_wrong_type_is_refused_and_leaves_the_variable_alone(target: Any) -> None:
    run = compiled(leaf("text", out={"x": "n"}), target=target, **{"data": {"n": "int"}})
    run.prepare(Context())
    with pytest.raises(NodeError, match="variable 'n' is int"):
        run.execute(Rushing())
    assert run.data[""].cells["n"].value is UNSET


def test_values_given_for_a_run_replace_initial_ones() -> None:
    tree = compiled(leaf(**{"in": {"a": "n"}, "out": {"x": "n"}}), values={"n": 41}, **{"data": {"n": "int"}})
    tree.prepare(Context())
    tree.execute(Rushing())
    assert tree.data[""].cells["n"].value == 42


@pytest.mark.parametrize("target", [to_tree, to_machine])
def test_all_problems_are_told_at_once(target: Any) -> None:
    root = {
        "kind": "sequence",
        "exits": {"a.succes": "success", "q.success": "nowhere"},
        "children": {
            "a": {"node": "test/copy", "in": {"b": "n", "a": "nn"}, "with": {"pluss": 1}},
            "b": {"node": "test/cop"},
            "c": leaf(on={"success": "a"}),
            "m": {
                "kind": "state_machine",
                "initial": "t",
                "outcomes": {"done": "success"},
                "children": {"s": leaf(on={"success": "dome"})},
            },
        },
    }
    with pytest.raises(InvalidTaskError) as raised:
        compiled(root, target=target, **{"data": {"n": "int"}}, values={"k": 1})
    text = str(raised.value)
    assert {issue.code for issue in raised.value.issues} == {
        "undeclared-variable",
        "missing-parameter",
        "unknown-parameter",
        "unknown-input",
        "unknown-node",
        "misplaced-on",
        "unknown-child",
        "unknown-outcome",
        "unknown-target",
        "missing-target",
    }
    for hint in ("did you mean 'success'", "did you mean 'n'", "did you mean 'test/copy'", "did you mean 'done'"):
        assert hint in text


def test_unknown_types_and_values_of_a_wrong_type_are_refused() -> None:
    with pytest.raises(InvalidTaskError, match="unknown-type") as raised:
        compiled(leaf(**{"in": {"a": "n"}}), {"n": "text"}, data={"n": "int", "m": "list[int"})
    assert "wrong-initial-value" in str(raised.value)


def test_an_end_of_the_root_keeps_its_label_goes_by_its_meaning_or_is_refused() -> None:
    machine = {
        "kind": "state_machine",
        "initial": "s",
        "outcomes": {"done": "success"},
        "children": {"s": leaf(**{"in": {"a": "n"}, "on": {"success": "done", "failure": "done"}})},
    }
    data = {"data": {"n": {"type": "int", "value": 1}}}
    for outcomes, expected in (({"done": "success"}, "done"), ({"success": "success"}, "success")):
        tree = compiled(machine, outcomes=outcomes, **data)
        tree.prepare(Context())
        assert tree.execute(Rushing()).outcome == expected
    with pytest.raises(InvalidTaskError, match="leads to no outcome of the task"):
        compiled(machine, outcomes={"other": "success"}, **data)


def test_of_a_root_that_isnt_known_nothing_is_said_about_its_ends() -> None:
    with pytest.raises(InvalidTaskError) as raised:
        compiled({"node": "test/cop", "on": {"done": "success"}})
    assert {issue.code for issue in raised.value.issues} == {"unknown-node"}
