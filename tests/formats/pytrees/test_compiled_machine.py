"""Machine -> graph: the same document, with what was changed on the machine since."""

from __future__ import annotations

import os
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from parity_flows import make_flow
from parity_generate import make_case
from parity_world import ScriptedLeaf, catalog_of

from grip_bt.compilers import CompiledMachine, to_machine
from grip_bt.formats.imported import ImportRefusedError
from grip_bt.formats.smach.objects import to_task
from grip_bt.smach_compat import State
from grip_bt.task import Task, dumps
from grip_bt.task.catalog import Catalog

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "200"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))


def leaf(path: str, node: Any, manifest: Any) -> ScriptedLeaf:
    return ScriptedLeaf(path, path, manifest, dict(node.with_), dict(node.meaning))


def step(**on: str) -> dict[str, Any]:
    return {"node": "flow/wait", "with": {"seconds": 1}, **({"on": on} if on else {})}


def compiled(root: dict[str, Any]) -> CompiledMachine:
    return to_machine(Task.model_validate({"grip": 1, "name": "t", "root": root}), Catalog.builtin())


def machine() -> CompiledMachine:
    children = {"a": step(success="b"), "b": step(success="success")}
    return compiled({"kind": "state_machine", "initial": "a", "outcomes": {"success": "success"}, "children": children})


def expect_back(case: dict[str, Any]) -> None:
    task = Task.model_validate(case["task"])
    again = to_task(to_machine(task, catalog_of(case), leaf_factory=leaf))
    assert dumps(again) == dumps(task)


@settings(max_examples=TASKS // 2, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.randoms(use_true_random=False), st.integers(0, 14))
def test_a_compiled_machine_gives_its_document_back(random: Random, flavour: int) -> None:
    expect_back(make_case(flavour, random=random))


@settings(max_examples=TASKS // 2, deadline=None)
@given(st.integers(FIRST, FIRST + 10**6))
def test_a_compiled_machine_of_any_edges_gives_its_document_back(seed: int) -> None:
    expect_back(make_flow(seed))


def test_an_edge_that_was_changed_on_the_machine_is_an_edge_of_the_task() -> None:
    made = machine()
    made.by_path["/"]._transitions["b"]["success"] = "a"
    made.by_path["/"].set_initial_state(["b"])
    root: Any = to_task(made).root
    assert root.initial == "b"
    assert dict(root.children["b"].on) == {"success": "a"}
    assert dict(root.children["a"].on) == {"success": "b"}


def test_an_end_that_was_changed_on_the_machine_is_an_end_of_the_task() -> None:
    made = machine()
    made.machine._transitions["t"]["success"] = "failure"
    assert dict(to_task(made).root.on) == {"success": "failure"}


def test_a_state_that_was_taken_out_is_no_node_of_the_task() -> None:
    made = machine()
    root = made.by_path["/"]
    del root._states["a"], root._transitions["a"]
    root.set_initial_state(["b"])
    assert list(to_task(made).root.children) == ["b"]


def test_what_no_task_says_is_refused_with_its_place() -> None:
    made = compiled({"kind": "sequence", "children": {"a": step(), "b": step()}})
    made.by_path["/"]._transitions["b"]["success"] = "a"
    with pytest.raises(
        ImportRefusedError, match="/: the transitions of 'b' were changed, and a sequence has fixed ones"
    ):
        to_task(made)
    made = machine()
    with made.by_path["/"]:
        made.by_path["/"].add("mine", State(["success"]), {"success": "success"})
    with pytest.raises(ImportRefusedError, match="/: the state 'mine' was added"):
        to_task(made)
