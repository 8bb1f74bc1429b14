"""Where leaves are at once and share variables, a machine does what the tree does, in the very order of its ticks.

The tree ticks its leaves in some order. Each thread of the machine is let through a turnstile in that order: it has to
come for every turn, see what the tree's leaf saw, and leave no turn over.
"""

from __future__ import annotations

import os

import pytest
from parity_generate import make_turns
from parity_world import run_machine, run_tree

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "400"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
CHUNKS = 4


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_a_machine_follows_the_order_of_the_tree(chunk: int) -> None:
    size = max(1, TASKS // CHUNKS)
    concurrent = shared = 0
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        case = make_turns(seed)
        if not case.get("concurrent"):
            continue
        tree = run_tree(case)
        if tree.over_budget or tree.end[0] in ("error", "stopped"):
            continue  # a run without an end has no order to its end
        machine = run_machine(case, schedule=tree.order)
        for what in ("order", "trace", "end", "data"):
            assert getattr(machine, what) == getattr(tree, what), f"seed {seed}: {what}"
        concurrent += 1
        switches = sum(a != b for a, b in zip(tree.order, tree.order[1:], strict=False))
        shared += switches > len(set(tree.order)) and any(r[2] for r in tree.trace)
    assert concurrent >= 0.3 * size - 2, f"only {concurrent} of {size} tasks have concurrent parts and an end"
    assert shared >= 0.1 * size - 2, f"in only {shared} of {size} leaves take turns and read variables"


def test_another_order_is_found_out() -> None:
    for seed in range(200):
        case = make_turns(seed)
        if not case.get("concurrent"):
            continue
        tree = run_tree(case)
        wrong = [
            i for i in range(len(tree.order) - 1) if tree.order[i].split("/")[0] != tree.order[i + 1].split("/")[0]
        ]
        if not wrong or tree.end[0] in ("error", "stopped"):
            continue
        shortened = tree.order[:-1]
        assert run_machine(case, schedule=shortened).end == ("stopped",), "the last leaf has no turn"
        return
    pytest.fail("no task of these has concurrent parts")
