"""Edits that only give names don't change what a task does: the same leaves end in the same way, with the same data."""

from __future__ import annotations

import os
from random import Random
from typing import Any

import pytest
from parity_flows import make_flow
from parity_generate import make_case
from parity_world import run_tree

from grip_bt.base.errors import EditError
from grip_bt.task import Task, walk
from grip_bt.task.edit import RenameOutcome, apply

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "200"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
LEAF = "fuzz/"


def declared(task: Task) -> list[tuple[str, str]]:
    """Return every path with an outcome that is declared there; an empty path is the task."""
    nodes = [(path, name) for path, node in walk(task.root) for name in getattr(node, "outcomes", ())]
    return [*(("", name) for name in task.outcomes), *nodes]


@pytest.mark.parametrize("make", [make_case, make_flow])
def test_a_renamed_outcome_changes_nothing_but_its_name(make: Any) -> None:
    renamed = 0
    for seed in range(FIRST, FIRST + TASKS):
        case = make(seed)
        task = Task.model_validate(case["task"])
        path, outcome = Random(seed).choice(declared(task))
        try:
            done = apply(task, RenameOutcome(path=path, outcome=outcome, to="renamed"))
        except EditError:
            continue
        before, after = run_tree(case), run_tree(case, done.task)
        ends = [("renamed" if path == "" and end == outcome else end) for end in before.end[:1]]
        assert after.trace == before.trace, f"seed {seed}: {path} {outcome}"
        assert list(after.end[:1]) == ends, f"seed {seed}: {path} {outcome}"
        assert (after.end[1:], after.data) == (before.end[1:], before.data), f"seed {seed}: {path} {outcome}"
        renamed += 1
    assert renamed > 0.8 * TASKS
