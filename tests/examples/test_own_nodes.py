"""The example of a project's own nodes: each kind of them does its work, alone and in the example's task."""

from __future__ import annotations

import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.runs.execute import RunOptions, check_task, open_session
from grip_bt.base.values import PointCloud, Pose
from grip_bt.cli.__main__ import main
from grip_bt.runtime import JournalReader, RunContext
from grip_bt.task.catalog import load_implementation

EXAMPLES = Path(__file__).parents[2] / "examples"
TASK = EXAMPLES / "tasks" / "fill_shelf.yaml"


@pytest.fixture
def make():
    """Make a leaf of the example with parameters and inputs; what it writes is in `data`."""
    catalog, context = project_catalog(EXAMPLES), RunContext()

    def made(node, inputs=None, **params):
        manifest = catalog.get(node)
        defaults = {name: p.default for name, p in manifest.parameters.items()}
        leaf = load_implementation(manifest)("leaf", "task/leaf", manifest, {**defaults, **params}, {})
        data = {}
        for port, value in (inputs or {}).items():
            leaf.readers[port] = lambda value=value: value
        for port in manifest.outputs:
            leaf.writers[port] = lambda value, port=port: data.__setitem__(port, value)
        leaf.setup(context=context)
        return SimpleNamespace(leaf=leaf, data=data)

    return made


def finish(leaf):
    leaf.tick_once()
    while leaf.outcome is None:
        leaf.operation.wait(120)
        leaf.tick_once()
    return leaf.outcome, leaf.failure and leaf.failure.code


def test_a_blocking_function_runs_in_a_worker(make):
    cloud = PointCloud(np.linspace((0, 0, 0), (0, 0, 0.4), 101).astype(np.float32))
    made = make("shelf/height", {"cloud": cloud}, percentile=50.0)
    assert finish(made.leaf) == ("success", None)
    assert made.data["height"] == pytest.approx(0.2)


def test_a_quick_function_ends_in_the_tick_with_an_outcome_of_its_own(make):
    fits, high = make("shelf/is_room", {"height": 0.2}), make("shelf/is_room", {"height": 0.4})
    for made, end in ((fits, ("room", None)), (high, ("too_high", "too_high"))):
        made.leaf.tick_once()
        assert (made.leaf.outcome, made.leaf.failure and made.leaf.failure.code) == end
    assert high.leaf.status.name == "FAILURE"


def test_a_coroutine_waits_without_holding_up_ticks_and_ends_when_interrupted(make, tmp_path):
    go = tmp_path / "go"
    made = make("shelf/wait_for_go", file=str(go), period=0.005)
    made.leaf.tick_once()
    assert made.leaf.status.name == "RUNNING"
    go.touch()
    assert finish(made.leaf) == ("success", None)
    late = make("shelf/wait_for_go", file=str(tmp_path / "never"), timeout=0.01, period=0.005)
    assert finish(late.leaf) == ("failure", "time_out")
    waiting = make("shelf/wait_for_go", file=str(tmp_path / "never"), period=0.005)
    waiting.leaf.tick_once()
    operation = waiting.leaf.operation
    waiting.leaf.stop()
    assert operation.wait(120)
    assert not waiting.leaf.zombie


def test_a_class_keeps_its_memory_over_activations_and_begins_anew_with_a_run(make):
    made = make("shelf/next_slot", {"corner": Pose((1, 0, 0))}, columns=2, rows=1, pitch=0.5)
    slots = []
    for _ in range(2):
        assert finish(made.leaf) == ("slot", None)
        slots.append(made.data["slot"].position.tolist())
    assert slots == [[1, 0, 0], [1.5, 0, 0]]
    assert finish(made.leaf) == ("full", "full")
    made.leaf.prepare()
    assert finish(made.leaf) == ("slot", None)
    with pytest.raises(AttributeError, match="self.end"):
        made.leaf.slot = Pose()


def test_checking_the_task_runs_none_of_the_code(tmp_path):
    (tmp_path / "nodes").mkdir()
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    mark = tmp_path / "was_run"
    source = (
        f"import grip_bt as grip\nopen({str(mark)!r}, 'w').close()\n\n@grip.leaf('my/f', quick=True)\ndef f(): ...\n"
    )
    (tmp_path / "nodes" / "mine.py").write_text(source)
    (tmp_path / "task.yaml").write_text("grip: 1\nname: t\nroot: {node: my/f}\n")
    assert main(["check", str(tmp_path / "task.yaml")]) == 0
    assert not mark.exists()
    assert main(["run", "--in-process", str(tmp_path / "task.yaml")]) == 0
    assert mark.exists()


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_the_task_shows_the_hand_to_every_slot(target, tmp_path):
    threads = threading.active_count()
    assert check_task(TASK)[2].issues == ()
    assert main(["fmt", "--check", str(TASK)]) == 0
    options = RunOptions(target=target, robot="fake", journal=tmp_path / "j.sqlite")
    with open_session(TASK, options) as session:
        assert session.runner.run().status == "success"
    with JournalReader(tmp_path / "j.sqlite") as reader:
        ends = [e for e in reader.events(session.runner.run_id or "") if e.event == "exit"]
    assert [e.outcome for e in ends if e.path == "slots/next"] == ["slot"] * 4 + ["full"]
    assert [e.outcome for e in ends if e.path == "slots/show"] == ["success"] * 4
    assert threading.active_count() <= threads + 4
