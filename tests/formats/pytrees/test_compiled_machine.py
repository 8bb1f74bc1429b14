"""Machine -> graph: the same document, or a refusal where the machine was changed since."""

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


@settings(max_examples=TASKS // 4, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.randoms(use_true_random=False), st.integers(0, 14))
def test_a_compiled_machine_gives_its_document_back(random: Random, flavour: int) -> None:
    expect_back(make_case(flavour, random=random))


@settings(max_examples=TASKS // 4, deadline=None)
@given(st.integers(FIRST, FIRST + 10**6))
def test_a_compiled_machine_of_any_edges_gives_its_document_back(seed: int) -> None:
    expect_back(make_flow(seed))


def test_a_machine_that_was_changed_since_is_refused_with_its_place() -> None:
    made = machine()
    made.by_path["/"]._transitions["b"]["success"] = "a"
    with pytest.raises(ImportRefusedError, match="/: its states or edges were changed since"):
        to_task(made)
    made = machine()
    made.machine._transitions["t"]["success"] = "failure"
    with pytest.raises(ImportRefusedError, match="/: its states"):
        to_task(made)
    made = machine()
    with made.by_path["/"]:
        made.by_path["/"].add("mine", State(["success"]), {"success": "success"})
    with pytest.raises(ImportRefusedError, match="/: its states"):
        to_task(made)
    made = machine()
    made.by_path["/"].set_initial_state(["b"])
    with pytest.raises(ImportRefusedError, match="/: its states"):
        to_task(made)
