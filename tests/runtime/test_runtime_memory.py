"""A run that goes on for long keeps no more memory than a short one."""

from __future__ import annotations

import gc
import threading
import tracemalloc
from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status
from runtime_world import TARGETS
from timed import ManualClock

from grip_bt.nodes import Leaf
from grip_bt.runtime import Journal, JournalReader, RunContext, Runner
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

CATALOG = Catalog(
    [
        Manifest(
            id="test/turn",
            doc="Counts its turns.",
            implementation="tests:Leaf",
            outputs={"x": {"type": "Any", "on": ["success"]}},
        )
    ]
)
TASK = {
    "grip": 1,
    "name": "t",
    "data": {"v": "Any"},
    "root": {"kind": "repeat", "child": {"turn": {"node": "test/turn", "out": {"x": "v"}}}},
}
WARM, LONG = 500, 2_500


class Turn(Leaf):
    """Ends as often as it is wanted, with a new value each time; then it fails, which ends the task."""

    turns = 0
    journal: Journal
    clock: ManualClock
    held: list[int]

    def update(self) -> Status:
        self.turns += 1
        self.clock.advance(0.01)
        if self.turns in (WARM, LONG):
            self.journal.flush()
            gc.collect()
            self.held.append(tracemalloc.get_traced_memory()[0])
        return self.end(x=[self.turns] * 50) if self.turns < LONG else self.fail("tired")


@pytest.mark.parametrize("target", TARGETS)
def test_thousands_of_turns_leave_nothing_behind(target: Any, tmp_path: Path) -> None:
    held: list[int] = []
    clock = ManualClock()
    threads = threading.active_count()

    def make(path: str, node: Any, face: Manifest) -> Turn:
        leaf = Turn(path, path, face, {}, dict(node.meaning))
        leaf.journal, leaf.clock, leaf.held = journal, clock, held
        return leaf

    tracemalloc.start()
    try:
        with Journal(tmp_path / "runs.sqlite") as journal:
            compiled = target(Task.model_validate(TASK), CATALOG, leaf_factory=make)
            runner = Runner(compiled, RunContext(clock), journal=journal)
            assert runner.run().status == "failure"
    finally:
        tracemalloc.stop()
    with JournalReader(tmp_path / "runs.sqlite") as reader:
        assert reader.count(runner.run_id or "") > 3 * LONG, "everything was recorded"
    early, late = held
    assert late - early < 100_000, f"{late - early} bytes more after {LONG - WARM} turns"
    assert threading.active_count() <= threads + 1
