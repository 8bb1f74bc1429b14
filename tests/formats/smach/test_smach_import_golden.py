import json
from collections import defaultdict
from pathlib import Path

import pytest
from smach_runs import run_task, write
from smach_sources import source_of

from grip_bt.nodes.smach_source import load_legacy

GOLDEN = Path(__file__).parents[2] / "smach_compat" / "data" / "smach_golden.jsonl"
CASES = [case for line in GOLDEN.read_text().splitlines() if (case := json.loads(line))["spec"]["preempt_at"] is None]
FEWEST_EXACT = 66


def per_path(trace):
    rows = defaultdict(list)
    for path, *rest in trace:
        rows[path].append(rest)
    return dict(rows)


def imported_exactly(case, folder):
    """Import a case and return its task; None where the import says why it isn't exact."""
    file = folder / "legacy.py"
    file.write_text(source_of(case["spec"]))
    imported, paths = write(file, folder / "out")
    assert all(c.issues for c in imported.containers if c.verdict != "exact")
    return paths["build"] if {c.verdict for c in imported.containers} == {"exact"} else None


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_what_is_imported_exactly_does_what_upstream_did(case, tmp_path):
    path = imported_exactly(case, tmp_path)
    for target in ("bt", "sm") if path is not None and case["result"][0] == "out" else ():
        legacy = load_legacy(tmp_path / "legacy.py")
        trace = legacy.TRACE
        trace.clear()
        legacy.ENDED.clear()
        outcome, _, _ = run_task(path, target)
        assert outcome == case["result"][1]
        rows = json.loads(json.dumps(trace))
        if case["concurrent"]:
            assert per_path(rows) == per_path(_unasked(case["trace"]))
        else:
            assert rows == _unasked(case["trace"])


def test_this_many_random_machines_at_least_are_imported_exactly(tmp_path):
    exact = 0
    for number, case in enumerate(CASES):
        folder = tmp_path / str(number)
        folder.mkdir()
        exact += imported_exactly(case, folder) is not None
    assert (len(CASES), exact >= FEWEST_EXACT) == (112, True), exact


def _unasked(trace):
    return [[path, outcome, read, False] for path, outcome, read, _ in trace]
