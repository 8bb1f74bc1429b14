"""A task does the same with a part of it in a file of its own."""

from __future__ import annotations

import os
from dataclasses import replace
from random import Random
from typing import Any

import pytest
from parity_generate import make_case
from parity_world import catalog_of, compare, run_machine, run_tree

from grip_bt.base.errors import EditError
from grip_bt.compilers.restructure import extracted
from grip_bt.task import Subtask, Task, loads, walk
from grip_bt.task.catalog import TaskTexts
from grip_bt.task.edit import Extract, apply
from grip_bt.task.validation import validate

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "300"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
CHUNKS = 4
FILE = "tasks/part.yaml"


def candidates(task: Task) -> list[str]:
    """Return the nodes that may be taken out: neither the root nor what runs other files, whose paths would change."""
    paths = [path for path, node in walk(task.root) if path != "/"]
    files = [path for path, node in walk(task.root) if isinstance(node, Subtask)]
    return [path for path in paths if not any(f == path or f.startswith(f"{path}/") for f in files)]


def taken_out(seed: int) -> tuple[dict[str, Any], Task, str, dict[str, Any]] | None:
    """Return a case, the task with a part of it in a file, the part's path, and the case with that file."""
    case = make_case(seed)
    task, random = Task.model_validate(case["task"]), Random(seed)
    paths = candidates(task)
    random.shuffle(paths)
    for path in paths[:6]:
        try:
            made = extracted(Extract(path=path, file=FILE), task, catalog_of(case))
        except EditError:
            continue
        done = apply(task, made.edit)
        files = {**case.get("files", {}), FILE: loads(made.text)}
        return case, done.task, path, {**case, "files": files}
    return None


def difference(case: dict[str, Any], after: Task, path: str, with_file: dict[str, Any]) -> str | None:
    """Return how the two differ, None when they don't, '' when it can't be told."""
    task = Task.model_validate(case["task"])
    origin = {p: p for p, _ in walk(task.root) if p != path} | {f"{path}/": path}
    before = run_tree(case)
    for name, run in (("tree", run_tree), ("machine", run_machine)):
        found = run(with_file, after, origin)
        kept = {key: found.data[key] for key in before.data if key in found.data}
        if before.end[0] in ("stopped", "error"):  # what was written inside is handed out at its end
            kept = before.data
        old, new = before, replace(found, data=kept)
        if any(p == path and node.precondition for p, node in walk(task.root)):  # it is the subtask that refuses now
            old, new = (replace(r, events=[e for e in r.events if e[0] != path]) for r in (old, new))
        result = compare(case, {"before": old, f"after, as a {name}": new})
        if result != None:  # noqa: E711 - '' is an answer too
            return result
    return None


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_a_part_in_a_file_of_its_own_does_the_same(chunk: int) -> None:
    size = max(1, TASKS // CHUNKS)
    whole = tried = 0
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        made = taken_out(seed)
        if made is None:
            continue
        tried += 1
        found = difference(*made)
        if found:
            pytest.fail(f"seed {seed}, {made[2]}: {found}\n{made[3]['files'][FILE]}")
        whole += found is None
    assert tried >= 0.5 * size - 2, f"only {tried} of {size} tasks have a part that could be taken out"
    assert whole >= 0.8 * tried - 2, f"only {whole} of {tried} tasks were compared to their end"


def test_new_files_are_right() -> None:
    right = 0
    for seed in range(FIRST, FIRST + 150):
        made = taken_out(seed)
        if made is None:
            continue
        case, after, path, with_file = made
        files = {name: Task.model_validate(said) for name, said in with_file["files"].items()}
        catalog = catalog_of(case).with_(tasks=TaskTexts(files))
        task = Task.model_validate(case["task"])
        found = validate(task, catalog_of(case)).issues
        if any(issue.code == "unreachable-node" and f"{path}/".startswith(f"{issue.path}/") for issue in found):
            continue  # in a file of its own it is reached, and what can't be told before is told then
        codes = {issue.code for issue in found if issue.severity == "error"}
        for made_of_it in (files[FILE], after):
            new = [issue for issue in validate(made_of_it, catalog).errors if issue.code not in codes]
            assert not new or (codes and new[0].code == "invalid-subtask"), f"seed {seed}, {path}: {new[0]}"
        right += 1
    assert right > 60
