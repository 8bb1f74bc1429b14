"""What it costs to control a run: wake to tick, stop to end, breakpoints, and the parent that watches.

.venv/bin/python benchmarks/run_control.py
"""

from __future__ import annotations

import statistics
import tempfile
import threading
import time
from typing import Any

from py_trees.common import Status

from grip_bt.compilers import to_tree
from grip_bt.compilers.binding import parts_of
from grip_bt.nodes import Leaf
from grip_bt.runtime import RunContext, Runner
from grip_bt.runtime.observers import LARGEST, Heartbeat
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

WAKES, STOPS, NODES, PASSES = 2000, 20, 100, 400


class Woken(Leaf):
    """Notes when it is ticked."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.at, self.ticked = 0.0, threading.Semaphore(0)

    def update(self) -> Status:
        """Note the time."""
        self.at = time.perf_counter()
        self.ticked.release()
        return self.running()


class Hung(Leaf):
    """Hangs in its update."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.inside, self.released = threading.Event(), threading.Event()

    def update(self) -> Status:
        """Hang."""
        self.inside.set()
        self.released.wait(20)
        return self.running()


def runner_of(kind: type[Leaf], root: Any = None) -> Runner:
    """Return a runner of one leaf, or of a task of the built-in nodes."""
    manifest = Manifest(id="bench/leaf", doc="Measured.", implementation="bench:Leaf")
    task = Task.model_validate({"grip": 1, "name": "bench", "root": root or {"node": "bench/leaf"}})
    catalog = Catalog.builtin().with_manifests([manifest])
    factory = None if root else lambda path, node, face: kind(path, path, face, {}, {})
    return Runner(to_tree(task, catalog, leaf_factory=factory), RunContext(), poll=None)


def wake_to_tick() -> list[float]:
    """Return times from a wake in another thread to the leaf's update [s]."""
    runner = runner_of(Woken)
    leaf: Any = runner.compiled.leaves["/"]
    thread = threading.Thread(target=runner.run, daemon=True)
    thread.start()
    leaf.ticked.acquire()
    taken = []
    for _ in range(WAKES):
        time.sleep(0.0002)  # until the run rests
        began = time.perf_counter()
        runner.context.wake()
        leaf.ticked.acquire()
        taken.append(leaf.at - began)
    runner.stop()
    thread.join()
    return taken


def stop_to_end(kind: type[Leaf]) -> list[float]:
    """Return times from a stop to the end of the run [s]."""
    taken = []
    for _ in range(STOPS):
        runner = runner_of(kind)
        leaf: Any = runner.compiled.leaves["/"]
        thread = threading.Thread(target=runner.run, daemon=True)
        thread.start()
        (leaf.inside.wait if kind is Hung else leaf.ticked.acquire)()
        began = time.perf_counter()
        runner.stop()
        thread.join()
        taken.append(time.perf_counter() - began)
        if kind is Hung:
            leaf.released.set()
    return taken


def node_cost(how: str) -> float:
    """Return the time of a node that is ticked and ends [s], of CPU."""
    children = {f"n{i}": {"node": "flow/succeed"} for i in range(NODES)}
    root = {"kind": "repeat", "times": PASSES, "child": {"s": {"kind": "sequence", "children": children}}}
    runner = runner_of(Leaf, root)
    with tempfile.TemporaryFile() as memory:
        memory.truncate(LARGEST)
        if how == "watched":
            runner.observe(Heartbeat(memory.fileno(), list(parts_of(runner.compiled))))
        if how != "nothing" and how != "watched":
            runner.debugger.set("s/n0", condition="1 > 2")
        if how == "cleared":
            runner.debugger.clear()
        began = time.process_time()
        runner.run()
        return (time.process_time() - began) / (NODES + 2) / PASSES


def main() -> None:
    """Print the figures."""
    wakes = sorted(wake_to_tick())
    print(f"wake to tick: median {1e6 * statistics.median(wakes):.0f} us, 99 % {1e6 * wakes[-WAKES // 100]:.0f} us")
    for kind, what in ((Woken, "a leaf that waits"), (Hung, "a leaf that hangs in update()")):
        stops = stop_to_end(kind)
        print(f"stop to end, {what}: median {1e3 * statistics.median(stops):.1f} ms, max {1e3 * max(stops):.1f} ms")
    ways = ("nothing", "cleared", "set elsewhere", "watched")
    costs = {how: statistics.median(node_cost(how) for _ in range(7)) for how in ways}
    for how, cost in costs.items():
        print(f"a node, {how}: {1e6 * cost:.3f} us ({1e9 * (cost - costs['nothing']):+.0f} ns)")


if __name__ == "__main__":
    main()
