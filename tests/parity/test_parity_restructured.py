"""A task and its restructuring do the same: on random tasks, on random machines, as a tree and as a machine."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from typing import Any

import pytest
from parity_flows import make_flow
from parity_generate import make_case
from parity_shrink import shrink
from parity_world import catalog_of, compare, run_machine, run_tree
from ruamel.yaml import YAML

from grip_bt.base.errors import InvalidTaskError
from grip_bt.compilers.restructure import Restructured, to_state_machines, to_trees
from grip_bt.task import Task, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "300"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
CHUNKS = 4
Convert = Callable[..., Restructured]
Make = Callable[[int], dict[str, Any]]


def difference(case: dict[str, Any], convert: Convert) -> str | None:
    """Return how a case and its restructuring differ, None when they don't, '' when it can't be told."""
    task = Task.model_validate(case["task"])
    result = convert(task, catalog_of(case))
    origin = {new: old for old, new in result.paths.items()}
    assert set(result.paths) == {path for path, _ in walk(task.root)}
    before = run_tree(case)
    found = compare(case, {"before": before, "after": run_tree(case, result.task, origin)})
    return found or compare(case, {"before": before, "after, as a machine": run_machine(case, result.task, origin)})


def report(seed: int, case: dict[str, Any], convert: Convert) -> str:
    """Return the shrunk case, and what differs in it."""

    def differs(candidate: dict[str, Any]) -> bool:
        try:
            return bool(difference(candidate, convert))
        except (InvalidTaskError, ValueError, KeyError):
            return False

    small = shrink(case, differs)
    text = io.StringIO()
    YAML().dump(small, text)
    return f"seed {seed}, {convert.__name__}: {difference(small, convert)}\n{text.getvalue()}"


@pytest.mark.parametrize("chunk", range(CHUNKS))
@pytest.mark.parametrize("make", [make_case, make_flow])
@pytest.mark.parametrize("convert", [to_state_machines, to_trees])
def test_a_restructured_task_does_the_same(convert: Convert, make: Make, chunk: int) -> None:
    size = max(1, TASKS // CHUNKS)
    whole = 0
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        case = make(seed)
        found = difference(case, convert)
        if found:
            pytest.fail(report(seed, case, convert))
        whole += found is None
    assert whole >= 0.85 * size - 2, f"only {whole} of {size} tasks were compared to their end"


@pytest.mark.parametrize("convert", [to_state_machines, to_trees])
def test_a_restructured_task_has_no_new_errors(convert: Convert) -> None:
    for seed in range(FIRST, FIRST + 60):
        for make in (make_case, make_flow):
            case = make(seed)
            task, catalog = Task.model_validate(case["task"]), catalog_of(case)
            before, after = errors(task, catalog), errors(convert(task, catalog).task, catalog)
            assert after <= before, f"seed {seed}: {after - before}"


def errors(task: Task, catalog: Catalog) -> set[str]:
    return {issue.code for issue in validate(task, catalog).issues if issue.severity == "error"}


def test_most_random_machines_have_a_structure() -> None:
    machines = stayed = 0
    for seed in range(FIRST, FIRST + 150):
        case = make_flow(seed)
        task = Task.model_validate(case["task"])
        machines += sum(getattr(node, "kind", "") == "state_machine" for _, node in walk(task.root))
        stayed += len(to_trees(task, catalog_of(case)).notes)
    assert machines > 200
    assert stayed < 0.15 * machines
