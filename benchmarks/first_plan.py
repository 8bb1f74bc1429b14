"""How long `grip run` takes until its task begins, and until its first plan is there; and which of its processes works.

    python benchmarks/first_plan.py [--robot NAME] [--times N]

A project of its own, in simulation: a plan to a pose near the hand, for which a goal and a way are searched. Wall time
since the command was given, and CPU time of each process until then, medians. The first run is left out.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

PROJECT = "grip: 1\nrobot: {robot}\narms: {{right: {{hand: right_hand}}}}\nhands: {{right_hand: {{}}}}\nworld: table\n"
TASK = """grip: 1
name: first_plan
outputs: {plan: Plan}
root:
  kind: sequence
  children:
    begun: {node: clock/note}
    plan: {node: arm/plan_through, with: {offsets: [[0.0, 0.1, 0.1]], straight: false}, out: {plan: plan}}
    planned: {node: clock/note}
"""
NODES = '''"""Write down what the time is, and how much the processes of the run have worked."""
import json, os, time
from pathlib import Path

import grip_bt as grip


@grip.leaf("clock/note", quick=True)
def note() -> None:
    """Add a line to the notes."""
    told = {"time": time.monotonic(), "cpu": {}}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().decode().split("\\\\0")
            state = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if f"GRIP_FIRST_PLAN={os.environ['GRIP_FIRST_PLAN']}" in environment(folder):
            name = next((word for word in words if word.startswith(("grip_bt", "grip_sim"))), words[-2])
            ticks = sum(map(int, state[11:13]))
            told["cpu"][name] = told["cpu"].get(name, 0.0) + ticks / os.sysconf("SC_CLK_TCK")
    with Path(__file__).parent.parent.joinpath("times.txt").open("a") as file:
        file.write(json.dumps(told) + "\\\\n")


def environment(folder):
    try:
        return (folder / "environ").read_bytes().decode(errors="replace").split("\\\\0")
    except OSError:
        return []
'''.replace("\\\\", "\\")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="panda_allegro", help="a ready-made robot with a hand")
    parser.add_argument("--times", type=int, default=5)
    arguments = parser.parse_args()
    print(f"{arguments.robot}, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "nodes").mkdir()
        (folder / "nodes" / "clock.py").write_text(NODES)
        (folder / "grip.yaml").write_text(PROJECT.format(robot=arguments.robot))
        (folder / "task.yaml").write_text(TASK)
        runs = [one_run(folder) for _ in range(arguments.times + 1)][1:]
    for moment, what in enumerate(("task begins", "first plan")):
        wall = [run[moment]["time"] for run in runs]
        total = [sum(run[moment]["cpu"].values()) for run in runs]
        print(f"{what}: {np.median(wall):.2f} s (longest {max(wall):.2f}), CPU of all {np.median(total):.2f} s")
        for name in runs[0][moment]["cpu"]:
            print(f"    {name:42} {np.median([run[moment]['cpu'].get(name, 0.0) for run in runs]):5.2f} s of CPU time")
    print(f"load {os.getloadavg()[0]:.1f}")


def one_run(folder: Path) -> list[dict[str, Any]]:
    """Return what was noted at the begin of the task and at its first plan; times since the command [s]."""
    notes = folder / "times.txt"
    notes.unlink(missing_ok=True)
    began = time.monotonic()
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(folder / "task.yaml"), "--robot", "sim"]
    marked = {**os.environ, "GRIP_FIRST_PLAN": str(began)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=marked)
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)
    noted = [json.loads(line) for line in notes.read_text().splitlines()]
    return [{**note, "time": note["time"] - began} for note in noted]


if __name__ == "__main__":
    main()
