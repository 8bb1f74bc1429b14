"""Ticks of trees by py_trees and by the tick engine.

    .venv/bin/python benchmarks/engine_ticks.py

CPU time; the sides in turns, the shortest of many short rounds, so that a machine that is busy with other work shows
least; every node has the same status on all sides, which is checked.
"""

from __future__ import annotations

import gc
import time

import py_trees
from cpu_time import seconds
from py_trees.visitors import SnapshotVisitor
from tick_families import FULL, STEADY, pick_task

from grip_bt.runtime import TickEngine

ROUNDS = 60
BUDGET = 0.01
"""CPU time of a round [s]."""

SIZE = 1000


def compare(family, make):
    """Return the number of nodes, and the seconds of a tick of each side."""
    theirs, ours, fixed = make(SIZE), make(SIZE), make(SIZE)
    sides = [theirs.tick_once, TickEngine(ours).tick, TickEngine(fixed, fixed=True).tick]
    for _ in range(10):
        for side in sides:
            side()
    same = [node.status for node in theirs.iterate()]
    assert all([node.status for node in root.iterate()] == same for root in (ours, fixed)), family
    rounds = [[seconds(side, BUDGET) for side in sides] for _ in range(ROUNDS)]
    return len(same), [min(side) for side in zip(*rounds, strict=True)]


def trees():
    print("| family | nodes | py_trees [us a node] | engine | | engine, fixed | |")
    print("|---|---|---|---|---|---|---|")
    for family, make in {**FULL, **STEADY}.items():
        count, (theirs, ours, fixed) = compare(family, make)
        print(f"| {family} | {count} | {theirs / count * 1e6:.3f} |", end="")
        for taken in (ours, fixed):
            print(f" {taken / count * 1e6:.3f} | {theirs / taken:.1f}x |", end="")
        print(flush=True)


def pick():
    count, (theirs, ours, fixed) = compare("pick", lambda nodes: pick_task())
    tree = py_trees.trees.BehaviourTree(pick_task())
    tree.add_visitor(SnapshotVisitor())
    shown = min(seconds(tree.tick, BUDGET) for _ in range(ROUNDS))
    print(f"\npick task of {count} nodes, the arm approaches, us a tick: BehaviourTree with a SnapshotVisitor", end=" ")
    print(f"{shown * 1e6:.1f}, tick_once {theirs * 1e6:.1f}", end=", ")
    print(f"engine {ours * 1e6:.2f} ({shown / ours:.0f}x), fixed {fixed * 1e6:.2f} ({shown / fixed:.0f}x)")


def preparing():
    root = FULL["sequences"](SIZE)
    gc.collect()
    gc.disable()
    made = []
    for _ in range(ROUNDS):
        began = time.thread_time()
        TickEngine(root)
        made.append(time.thread_time() - began)
    gc.enable()
    print(f"an engine of {SIZE} nodes is made in {min(made) * 1e3:.1f} ms, without collections of garbage")


if __name__ == "__main__":
    preparing()
    trees()
    pick()
