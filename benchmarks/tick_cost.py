"""What a task costs over plain py_trees, per visited node; the machine's transitions; an event of the journal; a stop.

    .venv/bin/python benchmarks/tick_cost.py

CPU time, the best of several rounds, both sides in turns; leaves end at once.
"""

import tempfile
import threading
import time
from pathlib import Path

import py_trees
from py_trees.common import Status

from grip_bt.compilers import Rushing, to_machine, to_tree
from grip_bt.nodes import Leaf
from grip_bt.runtime import Journal, RunContext, Runner
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

CATALOG = Catalog([Manifest(id="bench/leaf", doc="Ends at once.", implementation="bench:Quick")])
ROUNDS = 7


class Quick(Leaf):
    status_to_give = Status.SUCCESS

    def update(self):
        return self.end() if self.status_to_give is Status.SUCCESS else Status.RUNNING


class Plain(py_trees.behaviour.Behaviour):
    def update(self):
        return Status.SUCCESS


def compiled(root, target=to_tree):
    task = Task.model_validate({"grip": 1, "name": "bench", "root": root})
    made = target(task, CATALOG, leaf_factory=lambda path, node, face: Quick(path, path, face, {}, {}))
    made.prepare(RunContext())
    return made


def nested(width, depth):
    if depth == 0:
        return {"node": "bench/leaf"}
    return {"kind": "sequence", "children": {f"n{i}": nested(width, depth - 1) for i in range(width)}}


def plain(width, depth):
    if depth == 0:
        return Plain("leaf")
    return py_trees.composites.Sequence("s", True, [plain(width, depth - 1) for _ in range(width)])


def best(*functions, repeats):
    """Return the best CPU time [s] of one call of each function."""
    times = [float("inf")] * len(functions)
    for _ in range(ROUNDS):
        for i, function in enumerate(functions):
            began = time.thread_time()
            for _ in range(repeats):
                function()
            times[i] = min(times[i], (time.thread_time() - began) / repeats)
    return times


def ticks():
    for width, depth in ((100, 1), (5, 3)):
        ours, theirs = compiled(nested(width, depth)), plain(width, depth)
        nodes = sum(1 for _ in theirs.iterate())
        a, b = best(ours.root.tick_once, theirs.tick_once, repeats=30)
        print(
            f"tick of {nodes} nodes, depth {depth}: {a / nodes * 1e6:.2f} us a node,"
            f" py_trees {b / nodes * 1e6:.2f} ({a / b:.2f}x)"
        )


def machine():
    steps = 2000
    root = {"kind": "repeat", "times": steps, "child": {"a": {"node": "bench/leaf"}}}
    made = compiled(root, to_machine)
    (seconds,) = best(lambda: made.execute(Rushing()), repeats=1)
    print(f"machine: {2 * steps / seconds:,.0f} transitions/s")


def journal():
    burst = 200
    with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / "runs.sqlite") as book:
        log = book.begin("bench")
        ticking, written = [], []
        for _ in range(50):
            began = time.thread_time()
            for n in range(burst):
                log.append(n, "a/b", "enter")
            ticking.append((time.thread_time() - began) / burst)
            began = time.perf_counter()
            book.flush()
            written.append(time.perf_counter() - began)
    print(
        f"journal: {min(ticking) * 1e9:.0f} ns an event in the ticking thread; a burst of {burst} is safe after", end=""
    )
    print(f" {sorted(written)[25] * 1e3:.1f} ms (median)")


def stop():
    taken = []
    for target in (to_tree, to_machine):
        for _ in range(20):
            made = compiled({"node": "bench/leaf"}, target)
            made.leaves["/"].status_to_give = Status.RUNNING
            runner = Runner(made, RunContext(), poll=None)
            thread = threading.Thread(target=runner.run)
            thread.start()
            while not runner.pacing.ticks:
                time.sleep(0.001)
            began = time.perf_counter()
            runner.stop()
            thread.join()
            taken.append(time.perf_counter() - began)
    print(f"stop to ended: median {sorted(taken)[20] * 1e3:.2f} ms, worst {max(taken) * 1e3:.2f} ms")


if __name__ == "__main__":
    ticks()
    machine()
    journal()
    stop()
