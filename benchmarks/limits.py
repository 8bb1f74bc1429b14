"""What motions take of the joints' limits on what a joint_trajectory_controller draws between their points, at 1 kHz.

    python benchmarks/limits.py [--motions N] [--jerk TIMES]

Random motions of every kind that leaves a commander, of several robots, the same ones each time: the largest velocity,
acceleration and, with --jerk, jerk of any joint, over its limit. `--jerk 50` sets each joint's jerk limit to 50 times
its acceleration limit, per second. Collisions are looked at at the same samples.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "commanders"))

from motion_kinds import ARMS, PERIOD, Motions, drawn, kinds, many, used

COLUMNS = ("cubic velocity", "cubic acceleration", "quintic velocity", "quintic acceleration")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motions", type=int, default=25, help="tried of each kind")
    parser.add_argument("--jerk", type=float, help="limits of jerk over those of acceleration [1/s]")
    arguments = parser.parse_args()
    columns = COLUMNS if arguments.jerk is None else (*COLUMNS, "cubic jerk", "quintic jerk")
    print(f"| robot | kind | motions | {' | '.join(columns)} | samples, of these colliding |")
    print("|---|---|---|" + "---|" * (len(columns) + 1))
    for robot, group in ARMS.items():
        motions = Motions(robot, group, jerk=arguments.jerk)
        for kind in kinds():
            most: dict[str, float] = defaultdict(float)
            count = samples = colliding = 0
            for trajectory in many(motions, kind, arguments.motions):
                count += 1
                for what, part in used(motions, trajectory):
                    most[what] = max(most[what], part)
                if len(trajectory.times) > 1:
                    rows = drawn(trajectory, quintic=False)(np.arange(0.0, trajectory.duration, PERIOD))
                    samples += len(rows)
                    colliding += int((~motions.checker.free_each(rows)).sum())
            shown = " | ".join(f"{most[column]:.4f}" if column in most else "-" for column in columns)
            print(f"| {robot} | {kind} | {count} | {shown} | {samples}, {colliding} |", flush=True)


if __name__ == "__main__":
    main()
