"""Ticks of trees by py_trees, by py_trees with its three known fixes, and by plans.

    .venv/bin/python benchmarks/plan_ticks.py

CPU time; the sides in turns, medians of several rounds; every node has the same status on all sides, which is checked.
"""

from __future__ import annotations

import gc
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import py_trees
from plan_families import FULL, STEADY, pick_task
from plan_patched import patch
from plan_timing import seconds
from py_trees.visitors import SnapshotVisitor

from grip_bt.runtime import Plan

ROUNDS = 5
SIZES = (1000, 10000)


class Patched:
    """The process that ticks with the patched py_trees."""

    def __init__(self, folder: Path):
        patch(Path(py_trees.__file__).parent, folder)
        command = [sys.executable, str(Path(__file__).with_name("plan_patched.py")), str(folder)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def seconds(self, family: str, nodes: int) -> float:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(f"{family} {nodes}\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline())


def plan_of(root, **options):
    plan = Plan(root, **options)
    plan.optimise()
    for _ in range(10):
        plan.tick()
    return plan


def compare(family, nodes, make, patched):
    """Return the number of nodes and the median seconds of a tick of each side."""
    theirs, ours, fixed = make(nodes), make(nodes), make(nodes)
    plans = [plan_of(ours), plan_of(fixed, fixed_methods=True)]
    for _ in range(10):
        theirs.tick_once()
    same = [node.status for node in theirs.iterate()]
    assert all([node.status for node in root.iterate()] == same for root in (ours, fixed)), family
    rounds = [
        (
            seconds(theirs.tick_once),
            patched.seconds(family, nodes),
            seconds(plans[0].tick),
            seconds(plans[1].tick),
        )
        for _ in range(ROUNDS)
    ]
    return len(same), [statistics.median(side) for side in zip(*rounds, strict=True)]


def full_visits(patched):
    print("| every node visited | nodes | py_trees | patched | plan | | | plan, fixed methods | | |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for family, make in FULL.items():
        for size in SIZES:
            count, (theirs, fixes, ours, fixed) = compare(family, size, make, patched)
            cells = [f"{t / count * 1e6:.3f}" for t in (theirs, fixes)]
            for t in (ours, fixed):
                cells += [f"{t / count * 1e6:.3f}", f"{theirs / t:.0f}x", f"{fixes / t:.1f}x"]
            print(f"| {family} | {count} | {' | '.join(cells)} |", flush=True)


def steady(patched):
    print("\n| nothing changes | nodes | py_trees [us] | patched | plan | | plan, fixed methods | |")
    print("|---|---|---|---|---|---|---|---|")
    for family, make in STEADY.items():
        for size in SIZES:
            count, (theirs, fixes, ours, fixed) = compare(family, size, make, patched)
            cells = [f"{t * 1e6:.2f}" for t in (theirs, fixes)]
            for t in (ours, fixed):
                cells += [f"{t * 1e6:.2f}", f"{theirs / t:.1f}x"]
            print(f"| {family} | {count} | {' | '.join(cells)} |", flush=True)


def pick(patched):
    count, (theirs, fixes, ours, fixed) = compare("pick", 0, lambda nodes: pick_task(), patched)
    tree = py_trees.trees.BehaviourTree(pick_task())
    tree.add_visitor(SnapshotVisitor())
    shown = statistics.median(seconds(tree.tick) for _ in range(ROUNDS))
    print(f"\npick task of {count} nodes, the arm approaches, us a tick: BehaviourTree with a SnapshotVisitor", end=" ")
    print(f"{shown * 1e6:.1f}, tick_once {theirs * 1e6:.1f}, patched {fixes * 1e6:.1f}", end=", ")
    print(f"plan {ours * 1e6:.2f} ({shown / ours:.0f}x), with fixed methods {fixed * 1e6:.2f} ({shown / fixed:.0f}x)")


def preparing():
    gc.collect()
    for size in SIZES:
        made, linked = [], []
        for _ in range(ROUNDS):
            root = FULL["sequences"](size)
            gc.disable()
            began = time.thread_time()
            plan = Plan(root)
            made.append(time.thread_time() - began)
            plan.optimise()
            linked.append(time.thread_time() - began - made[-1])
            gc.enable()
        print(
            f"a plan of {size} nodes is made in {statistics.median(made) * 1e3:.1f} ms, its source generated", end=" "
        )
        print(f"in {statistics.median(linked) * 1e3:.1f} ms where the shape is known, without collections of garbage")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        other = Patched(Path(folder))
        preparing()
        full_visits(other)
        steady(other)
        pick(other)
        other.process.stdin.close()
        other.process.wait()
