"""What `grip run --durable` costs: the wait for the disk as a motion begins and as it ends.

    python benchmarks/durable.py [--folder FOLDER] [--leaves N] [--rounds R]

Tasks of N leaves that would be asked about, each of which ends at once, are run by turns with and without waiting, in
one process; what a leaf takes more is the cost. `fsync` alone is measured beside it, in the same folder.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from pathlib import Path

from grip_bt.compilers import to_tree
from grip_bt.nodes import Leaf
from grip_bt.nodes.leaf import Status
from grip_bt.runtime import Journal, RunContext, Runner
from grip_bt.runtime.observers import Durable
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

FACE = Manifest(id="my/move", doc="Moves nothing.", implementation="move.py:Move")


class Move(Leaf):
    """Ends at once."""

    def update(self) -> Status:
        """End."""
        return self.end()


def run_once(file: Path, leaves: int, durable: bool) -> float:
    """Return what a leaf takes on average [s]."""
    children = {f"m{i}": {"node": "my/move"} for i in range(leaves)}
    task = Task.model_validate({"grip": 1, "name": "t", "root": {"kind": "sequence", "children": children}})
    compiled = to_tree(task, Catalog([FACE]), leaf_factory=lambda path, node, face: Move(path, path, face, {}, {}))
    with Journal(file) as journal:
        runner = Runner(compiled, RunContext(), journal=journal)
        if durable:
            runner.observe(Durable(journal, list(compiled.leaves)))
        began = time.perf_counter()
        assert runner.run().status == "success"
        return (time.perf_counter() - began) / leaves


def fsync_time(folder: Path, times: int) -> float:
    """Return the median of writing 4 kB and having them on the disk [s]."""
    took = []
    with (folder / "fsync").open("wb") as file:
        for _ in range(times):
            began = time.perf_counter()
            file.write(b"x" * 4096)
            file.flush()
            os.fsync(file.fileno())
            took.append(time.perf_counter() - began)
    return statistics.median(took)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path(), help="on which disk; here by default")
    parser.add_argument("--leaves", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.folder) as name:
        folder = Path(name)
        run_once(folder / "warm.sqlite", args.leaves, True)
        plain, waiting = [], []
        for number in range(args.rounds):
            plain.append(run_once(folder / f"plain{number}.sqlite", args.leaves, False))
            waiting.append(run_once(folder / f"durable{number}.sqlite", args.leaves, True))
        sync = fsync_time(folder, 200)
    without, with_ = statistics.median(plain), statistics.median(waiting)
    print(f"load {os.getloadavg()[0]:.1f}; {args.leaves} leaves a run, {args.rounds} runs each")
    print(f"without: {without * 1e6:.1f} us a leaf; durable: {with_ * 1e3:.3f} ms a leaf, two waits each")
    print(f"a wait: {(with_ - without) / 2 * 1e3:.3f} ms; fsync of 4 kB alone: {sync * 1e3:.3f} ms")


if __name__ == "__main__":
    main()
