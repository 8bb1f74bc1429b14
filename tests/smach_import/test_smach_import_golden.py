import json
from collections import defaultdict
from pathlib import Path

import pytest
from smach_runs import run_task, write
from smach_sources import source_of

from grip_bt.nodes.smach_source import load_legacy

GOLDEN = Path(__file__).parents[1] / "smach_compat" / "data" / "smach_golden.jsonl"
CASES = [case for line in GOLDEN.read_text().splitlines() if (case := json.loads(line))["spec"]["preempt_at"] is None]
EXACT = 0


def per_path(trace):
    rows = defaultdict(list)
    for path, *rest in trace:
        rows[path].append(rest)
    return dict(rows)


@pytest.mark.parametrize("target", ["bt", "sm"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_what_is_imported_exactly_does_what_upstream_did(case, target, tmp_path):
    file = tmp_path / "legacy.py"
    file.write_text(source_of(case["spec"]))
    imported, paths = write(file, tmp_path / "out")
    if {c.verdict for c in imported.containers} != {"exact"} or case["result"][0] != "out":
        assert all(c.problems for c in imported.containers if c.verdict != "exact")
        pytest.skip("; ".join({p.text for c in imported.containers for p in c.problems}) or "upstream raised")
    outcome, _, data = run_task(paths["build"], target)
    trace = json.loads(json.dumps(load_legacy(file).TRACE))
    assert outcome == case["result"][1]
    if case["concurrent"]:
        assert per_path(trace) == per_path(_unasked(case["trace"]))
    else:
        assert trace == _unasked(case["trace"])


def _unasked(trace):
    return [[path, outcome, read, False] for path, outcome, read, _ in trace]
