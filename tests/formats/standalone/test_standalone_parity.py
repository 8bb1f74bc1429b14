"""An exported file does what the tree of its task does, on random tasks with scripted leaves."""

from __future__ import annotations

import itertools
import os
from copy import deepcopy
from typing import Any

import py_trees
import pytest
from parity_generate import make_case
from parity_world import CATALOG, Run, World, run_tree
from py_trees.common import Status
from standalone_leaves import PlainScripted

from grip_bt.base.errors import NodeError, NotExpressibleError
from grip_bt.compilers import Halted
from grip_bt.formats.standalone import export
from grip_bt.nodes.node import halt
from grip_bt.task import Task, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Leaf

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "240"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
CHUNKS = 4
REFUSED = ("subtask",)
"""What an export refuses by name."""


def catalog_of(implementation: str) -> Catalog:
    return Catalog(m.model_copy(update={"implementation": implementation}) for m in CATALOG)


GRIPS, PLAIN = catalog_of("standalone_leaves:GripScripted"), catalog_of("standalone_leaves:PlainScripted")


def without_ports(case: dict[str, Any]) -> dict[str, Any]:
    """Return the case with leaves that read and write nothing, and mean what their manifests say."""

    def strip(node: dict[str, Any]) -> None:
        for key in ("in", "out", "meaning"):
            node.pop(key, None)
        children = {**node.get("children", {}), **node.get("child", {})}
        for child in children.values():
            strip(child)

    case = deepcopy(case)
    strip(case["task"]["root"])
    return case


def run_exported(case: dict[str, Any], catalog: Catalog, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Export a case, execute the file, and tick what it builds."""
    task = Task.model_validate(case["task"])
    text = export(task, catalog)
    leaves = [node for _, node in walk(task.root) if isinstance(node, Leaf)]
    assert ("from grip_bt" in text) == (catalog is GRIPS and bool(leaves))
    world = World(case["scripts"], case.get("preempt_at"))
    world.request_preempt = lambda: setattr(world, "preempt_requested", True)
    if world.preempt_at == -1:
        world.request_preempt()
    PlainScripted.world = world
    PlainScripted.paths = {node.with_["script"]: path for path, node in walk(task.root) if isinstance(node, Leaf)}
    # A clock that is read twice never shows the same; so "after" and "not before" a deadline are one.
    readings = itertools.count()
    monkeypatch.setattr(py_trees.decorators.time, "monotonic", lambda: world.clock.now() + next(readings) * 1e-9)
    made: dict[str, Any] = {"__name__": "exported"}
    exec(compile(text, "exported.py", "exec"), made)
    root = made["create_root"]()
    tree = py_trees.trees.BehaviourTree(root)
    tree.setup(context=world)
    try:
        while True:
            world.turn()
            tree.tick()
            if root.status != Status.RUNNING:
                break
        outcome = made["end_of"](root)
        end: tuple[Any, ...] = (outcome, task.outcomes[outcome])
    except Halted:
        halt(root)
        end = ("stopped",)
    except Exception as error:  # noqa: BLE001 - any error of a leaf or a condition
        halt(root)
        end = ("error", error.path if isinstance(error, NodeError) else None)
    return Run(end, world.trace, [], {}, world.over_budget, world.turns)


def before_halts(trace: list[tuple[Any, ...]]) -> list[tuple[Any, ...]]:
    """Return a trace without the halts at its end."""
    return trace[: max((i for i, record in enumerate(trace, 1) if record[3] != "halted"), default=0)]


@pytest.mark.parametrize("chunk", range(CHUNKS))
@pytest.mark.parametrize("plain", [False, True], ids=["leaves of grip", "plain leaves"])
def test_an_exported_file_does_what_the_tree_does(plain: bool, chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    size = max(1, TASKS // CHUNKS)
    compared = 0
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        case = make_case(seed, without=REFUSED)
        case = without_ports(case) if plain else case
        try:
            done = run_exported(case, PLAIN if plain else GRIPS, monkeypatch)
        except NotExpressibleError:
            continue
        expected = run_tree(case)
        if plain and done.end[0] == "error":
            # py_trees terminates nothing after an exception, not even who raised it
            done.trace, expected.trace = before_halts(done.trace), before_halts(expected.trace)
        assert done.trace == expected.trace, f"seed {seed}"
        assert done.turns == expected.turns, f"seed {seed}"
        assert done.end[:1] == expected.end[:1], f"seed {seed}"
        if done.end[0] == "error":
            assert done.end[1] in (None, expected.end[1]), f"seed {seed}"
        else:
            assert done.end == expected.end[:2], f"seed {seed}"
        compared += 1
    assert compared > 0.7 * size, f"only {compared} of {size} tasks were compared"
