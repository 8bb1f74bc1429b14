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
        ("grip_bt.commanders.planning.answer", {"matplotlib"}),
        ("grip_bt.app.runs.process, grip_bt.app.runs.motion_record", HEAVY),
        ("grip_sim.worlds as worlds; worlds.load_world('bottle_bench', 0)", HEAVY | {"trimesh"}),
    ],
)
def test_heavy_libraries_are_left_to_those_who_need_them(modules, spared):
    code = f"import sys, {modules}; print(sorted({spared!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_who_plots_beside_a_planner_has_all_of_matplotlib():
    code = (
        "import grip_bt.commanders.planning.answer, toppra.algorithm.algorithm as lazy; "
        "import matplotlib.pyplot as plt, matplotlib; assert matplotlib.pyplot is plt; "
        "assert lazy.plt.subplots is plt.subplots and plt.gcf; print(type(plt).__name__, matplotlib.__version__[:1])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["module", "3"]
