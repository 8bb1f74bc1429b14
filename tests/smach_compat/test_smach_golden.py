"""210 random machines do what upstream smach 2.5 did: data/smach_golden.jsonl holds its traces."""

import json
from collections import defaultdict
from pathlib import Path

import pytest
from smach_scripted_machines import Recorder, build

import grip_bt.smach_compat as smach

GOLDEN = Path(__file__).parent / "data" / "smach_golden.jsonl"
CASES = [json.loads(line) for line in GOLDEN.read_text().splitlines()]


def replay(spec):
    """Return (trace, result, userdata) of one machine."""
    recorder = Recorder(spec["preempt_at"])
    root = recorder.root = build(spec, recorder)
    for key, value in spec["ud"].items():
        root.userdata[key] = value
    try:
        result = ["out", root.execute()]
    except smach.SmachError as error:
        result = ["exc", type(error).__name__]
    return json.loads(json.dumps(recorder.trace)), result, dict(root.userdata._data)


def per_path(trace):
    """Return path -> its activations; children of a Concurrence have no order among each other."""
    rows = defaultdict(list)
    for path, *rest in trace:
        rows[path].append(rest)
    return dict(rows)


def test_the_golden_file_is_whole():
    assert len(CASES) == 210
    assert sum(case["concurrent"] for case in CASES) == 66


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_a_recorded_machine_replays_exactly(case, in_time):
    trace, result, userdata = in_time(lambda: replay(case["spec"]))
    assert result == case["result"]
    assert userdata == case["userdata"]
    if case["concurrent"]:
        assert per_path(trace) == per_path(case["trace"])
    else:
        assert trace == case["trace"]
