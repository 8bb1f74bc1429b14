"""An imported machine does in each form what upstream recorded, whatever number of ticks its leaves take."""

import json
import os
import random
from pathlib import Path

import pytest
from smach_branches import Branches
from smach_lowerings import (
    FORMS,
    Draw,
    PacedActivation,
    per_path,
    run_compat,
    run_form,
)
from smach_runs import write
from smach_sources import source_of

from grip_bt.nodes import smach_leaf

GOLDEN = Path(__file__).parents[2] / "smach_compat" / "data" / "smach_golden.jsonl"
CASES = [json.loads(line) for line in GOLDEN.read_text().splitlines()]
if "GRIP_FUZZ_TASKS" not in os.environ:
    CASES = CASES[::4]  # the suite takes a sample; `make fuzz` takes all
MACHINES = int(os.environ.get("GRIP_FUZZ_TASKS", "60")) // 5
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))


@pytest.fixture(autouse=True)
def paced(monkeypatch):
    monkeypatch.setattr(smach_leaf, "Activation", PacedActivation)


def imported(spec, folder):
    """Return the legacy file, and the task where it was imported exactly."""
    file = folder / "legacy.py"
    file.write_text(source_of(spec))
    found, paths = write(file, folder / "out")
    exact = {container.verdict for container in found.containers} == {"exact"}
    return file, paths["build"] if exact else None


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_each_form_of_what_was_imported_exactly_replays_upstreams_trace(case, tmp_path):
    file, path = imported(case["spec"], tmp_path)
    at = case["spec"]["preempt_at"]
    preempt_at = () if at is None else (at,)
    outcome, trace = run_compat(file, preempt_at)
    expected = case["trace"]
    assert ["out", outcome] == case["result"]
    assert per_path(json.loads(json.dumps(trace))) == per_path(expected)
    assert path is not None, "each of them is imported exactly"
    for pace, form in enumerate(FORMS):
        outcome, trace = run_form(path, file, form, preempt_at, pace)
        rows = json.loads(json.dumps(trace))
        assert outcome == case["result"][1], form
        assert (per_path(rows) == per_path(expected)) if case["concurrent"] else (rows == expected), form


@pytest.mark.parametrize("when", ["never", "before", "during", "twice"])
def test_random_machines_do_the_same_in_each_form_however_often_they_are_preempted(when, tmp_path):
    _compare(when, Draw, MACHINES, tmp_path, least=MACHINES // 2)


@pytest.mark.parametrize("when", ["never", "before", "during", "twice"])
def test_containers_side_by_side_do_the_same_in_each_form_however_often_they_are_preempted(when, tmp_path):
    # each takes long, and a request before a Concurrence reaches nothing in it
    _compare(when, Branches, MACHINES // 2, tmp_path, least=0)


def _compare(when, draw, machines, tmp_path, least):
    compared = asked = 0
    for seed in range(FIRST, FIRST + machines):
        folder = tmp_path / str(seed)
        folder.mkdir()
        file, path = imported(draw(seed).machine(), folder)
        if path is None:
            continue
        _, whole = run_compat(file)
        drawn = [random.Random(f"{seed} {number}").randrange(max(1, len(whole))) for number in range(2)]
        at = {"during": drawn[:1], "twice": drawn}.get(when, ())
        before = {"before": 1, "twice": seed % 2}.get(when, 0)
        expected = run_compat(file, at, before)
        for pace, form in enumerate(FORMS):
            outcome, trace = run_form(path, file, form, at, pace, before)
            assert (outcome, per_path(trace)) == (expected[0], per_path(expected[1])), (seed, form)
        compared += 1
        asked += any(row[-1] for row in expected[1])
    assert compared > machines * 0.9
    assert (asked > least) == (when != "never")
