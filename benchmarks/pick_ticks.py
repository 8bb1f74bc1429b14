"""A pick task of 39 of our nodes, ticked with the journal on while the arm approaches; ports; the machine target.

    .venv/bin/python benchmarks/pick_ticks.py

CPU time of the thread that ticks, sides in turns, the shortest of many short rounds. The peer is the pick task of
`tick_families.py`, also of 39 nodes, ticked by py_trees with a SnapshotVisitor, which is what its users log with.
"""

import tempfile
from pathlib import Path

import py_trees
from cpu_time import seconds
from py_trees.common import Status
from py_trees.visitors import SnapshotVisitor
from tick_families import pick_task

from grip_bt.compilers import Rushing, to_machine, to_tree
from grip_bt.nodes import Leaf
from grip_bt.runtime import Journal, RunContext, TickEngine, WallClock
from grip_bt.runtime.engine import make_ticker
from grip_bt.runtime.observers import Recorder
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

PORTS = {"inputs": {"x": {"type": "int"}}, "outputs": {"y": {"type": "int", "on": ["success"]}}}
CATALOG = Catalog(
    [
        Manifest(id="bench/leaf", doc="Ends at once.", implementation="bench:Quick"),
        Manifest(id="bench/ports", doc="Reads and writes.", implementation="bench:Quick", **PORTS),
    ]
)
ROUNDS = 40
BUDGET = 0.02
"""CPU time of a round [s]."""

SUCCESS, RUNNING = Status.SUCCESS, Status.RUNNING


class Quick(Leaf):
    runs = False

    def update(self):
        return RUNNING if self.runs else SUCCESS


def compiled(root, target=to_tree, data=None):
    task = Task.model_validate({"grip": 1, "name": "bench", "root": root, "data": data or {}})
    made = target(task, CATALOG, leaf_factory=lambda path, node, face: Quick(path, path, face, {}, {}))
    made.prepare(RunContext())
    return made


def leaf():
    return {"node": "bench/leaf"}


def steps(*children):
    return {"kind": "sequence", "children": {f"s{i}": child for i, child in enumerate(children)}}


def motion():
    return {"kind": "timeout", "seconds": 1e6, "child": {"steps": steps(leaf(), leaf(), leaf())}}


def pick():
    """As in `tick_families`: a guard, a retry over candidates, time-outs, a watch beside the motion."""
    watch = {"kind": "parallel", "children": {"approach": motion(), "contact": leaf()}}
    attempt = steps(leaf(), leaf(), watch, motion(), leaf(), motion())
    found = {
        "kind": "fallback",
        "children": {"none": {"kind": "invert", "child": {"look": leaf()}}, "propose": leaf()},
    }
    recover = steps(leaf(), leaf(), motion(), leaf())
    either = {
        "kind": "fallback",
        "children": {"retry": {"kind": "retry", "times": 3, "child": {"attempt": attempt}}, "recover": recover},
    }
    task = steps(leaf(), found, either)
    return {"kind": "guard", "if": "ready", "child": {"task": task}}


def picking(observer=None):
    """Return the compiled task, two of its leaves running: the motion and the watch."""
    made = compiled(pick(), data={"ready": {"type": "bool", "value": True}})
    for path, node in made.leaves.items():
        node.runs = path.endswith(("approach/steps/s1", "contact"))
    if observer is not None:
        made.observe(observer)
    return made


def pick_ticks():
    theirs = py_trees.trees.BehaviourTree(pick_task())
    theirs.add_visitor(SnapshotVisitor())
    with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / "runs.sqlite") as journal:
        made = picking(Recorder(journal.begin("pick"), WallClock()))
        engine, unwatched = (TickEngine(side.root, fixed=True) for side in (made, picking()))  # as the runner does
        whole = picking(Recorder(journal.begin("whole"), WallClock()))
        for side in (engine, unwatched):
            for _ in range(10):
                side.tick()
        count = sum(1 for _ in made.root.iterate())
        ticks = (theirs.tick, engine.tick, unwatched.tick, whole.root.tick_once)
        taken = [[seconds(tick, BUDGET) for tick in ticks] for _ in range(ROUNDS)]
    snapshot, ours, bare, ticked = (min(side) * 1e6 for side in zip(*taken, strict=True))
    print(f"pick task of {count} nodes, the arm approaches: py_trees with a SnapshotVisitor {snapshot:.1f} us a tick;")
    print(
        f"  our nodes, journal on: engine {ours:.2f} us ({snapshot / ours:.0f}x), without journal {bare:.2f};", end=" "
    )
    print(f"by py_trees itself {ticked:.1f}")


def whole_ticks():
    """Every node is entered and ends in each tick, with the journal on."""
    with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / "runs.sqlite") as journal:
        for width, depth in ((100, 1), (5, 3), (10, 3)):

            def nested(depth, width=width):
                return leaf() if depth == 0 else steps(*(nested(depth - 1) for _ in range(width)))

            sides = []
            for observed in (False, True):
                made = compiled(nested(depth))
                if observed:
                    made.observe(Recorder(journal.begin("whole"), WallClock()))
                engine = TickEngine(made.root, fixed=True)
                sides += [made.root.tick_once] if not observed else []
                sides.append(engine.tick)
            count = sum(1 for _ in made.root.iterate())
            taken = zip(*[[seconds(side, BUDGET) for side in sides] for _ in range(ROUNDS)], strict=True)
            theirs, bare, logged = (min(side) / count * 1e6 for side in taken)
            print(f"{count} of our nodes, all entered and ended: py_trees {theirs:.2f} us a node,", end=" ")
            print(f"engine {bare:.2f} ({theirs / bare:.0f}x), with the journal {logged:.2f}")


def ports():
    root = steps({"node": "bench/ports", "in": {"x": "a"}, "out": {"y": "b"}})
    made = compiled(root, data={"a": {"type": "int", "value": 1}, "b": "int"})
    (node,) = made.leaves.values()
    made.data[""].reset()
    read, write = node.readers["x"], node.writers["y"]

    def reads():
        for _ in range(100):
            read()

    def writes():
        for _ in range(100):
            write(3)

    def asks():
        for _ in range(100):
            node.read("x")

    def nothing():
        for _ in range(100):
            pass

    taken = zip(
        *[[seconds(f, BUDGET) / 100 * 1e9 for f in (reads, writes, asks, nothing)] for _ in range(ROUNDS)], strict=True
    )
    read_ns, write_ns, ask_ns, loop = (min(side) for side in taken)
    print(f"typed port: read {read_ns - loop:.0f} ns, write {write_ns - loop:.0f} ns;", end=" ")
    print(f"`leaf.read(port)` {ask_ns - loop:.0f} ns")


def machine():
    times = 5000
    root = {"kind": "repeat", "times": times, "child": {"a": leaf()}}
    sides = [(compiled(root, to_machine), make) for make in (None, make_ticker)]
    taken = [
        [seconds(lambda made=made, p=p: made.execute(Rushing(), p), BUDGET) for made, p in sides] for _ in range(ROUNDS)
    ]
    plain, ours = (2 * times / min(side) / 1e6 for side in zip(*taken, strict=True))
    print(f"machine target: {ours:.2f} M transitions/s, {plain:.2f} by py_trees")


if __name__ == "__main__":
    pick_ticks()
    whole_ticks()
    ports()
    machine()
