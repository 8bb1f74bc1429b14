"""What a run's own process loads before its task begins: not what only the planner's, or a rare scene, needs."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = {"ompl", "toppra", "scipy", "coal", "sapien", "pytracik"}


@pytest.mark.parametrize(
    ("modules", "spared"),
    [
        ("grip_bt.commanders.planning.service", HEAVY - {"coal", "pytracik"}),
        ("grip_bt.app.runs.process, grip_bt.app.runs.motion_record", HEAVY),
        ("grip_sim.worlds as worlds; worlds.load_world('bottle_bench', 0)", HEAVY | {"trimesh"}),
    ],
)
def test_heavy_libraries_are_left_to_those_who_need_them(modules, spared):
    code = f"import sys, {modules}; print(sorted({spared!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
