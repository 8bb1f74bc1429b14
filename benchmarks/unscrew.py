"""Two arms unscrew a bottle: `examples/unscrew` on bottles that seeds draw, by the referee's word.

    python benchmarks/unscrew.py --out rows.jsonl [--trials 20] [--first N]
    python benchmarks/unscrew.py --report rows.jsonl

A seed draws where the bottle stands, how hard its thread goes and how far it has to be turned. The simulator and the
planner stay up. Rows are appended to the file as trials end; a trial that is in there isn't run again.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import time
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import grip_bt as grip
from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.runs.execute import check_task
from grip_bt.app.wiring.equipment import Equipment
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening
from grip_bt.compilers import to_tree
from grip_bt.runtime import Runner
from grip_sim.worlds import HERE as WORLDS

PROJECT = Path(__file__).resolve().parents[1] / "examples" / "unscrew"
Row = dict[str, Any]


class Watch(grip.Observer):
    """Remembers the first node that failed, and what the referee has measured after each turn."""

    def __init__(self, referee: Any):
        self.first, self.after, self.pulls, self._referee = "", list[float](), list[float](), referee

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """Note a pull."""
        if variable == "pull" and isinstance(value, float):
            self.pulls.append(round(value, 3))

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        """Note it."""
        name = path.rpartition("/")[2]
        if failure is not None and not self.first:
            self.first = f"{name}: {failure.code}"
        if name == "turn":
            self.after.append(round(self._referee.measures()["bottle_turns"], 3))


def trial(seed: int, folder: Path, equipment: Equipment) -> Row:
    """Run one and return its row."""
    began, rng = time.monotonic(), np.random.default_rng(seed)
    said = yaml.safe_load((WORLDS / "bottle_bench.yaml").read_text())
    bottle = said["articulated"]["bottle"]
    x, y = rng.uniform([-0.02, -0.02], [0.02, 0.02])
    bottle["at"] = [round(float(0.55 + x), 4), round(float(y), 4), 0.0]
    friction, turns = (round(float(rng.uniform(*limits)), 3) for limits in ((0.03, 0.07), (0.75, 1.25)))
    bottle["screw_bottle"] |= {"friction": friction, "turns": turns}
    (folder / "worlds").mkdir(exist_ok=True)
    (folder / "worlds" / "bottle_bench.yaml").write_text(yaml.safe_dump(said))
    project, document, _ = check_task(folder / "tasks" / "unscrew.yaml")
    catalog = catalogue_of(project)
    needs = {leaf.manifest.id for leaf in to_tree(document.task, catalog).leaves.values()}
    with ExitStack() as stack:
        parts = stack.enter_context(open_resources(Opening(project, seed, equipment=equipment), needs, "sim"))
        watch = Watch(parts.world.referee)
        runner = Runner(to_tree(document.task, catalog), parts.context())
        runner.observe(watch)
        result = runner.run()
        runner.dismiss()
        measures = {name: round(value, 4) for name, value in parts.world.referee.measures().items()}
    row = {"seed": seed, "at": bottle["at"], "friction": friction, "needed": turns, "status": result.status}
    row |= {
        "stage": watch.first,
        "message": str(result.failure or result.error or "")[:300],
        "after": watch.after,
        "pulls": watch.pulls,
    }
    return {**row, **measures, "simulated": round(result.duration, 1), "wall": round(time.monotonic() - began, 1)}


def report(rows: Iterable[Row]) -> None:
    """Print the table."""
    rows = list(rows)
    columns = ("seed", "thread [N m]", "turns to go", "cap off", "turned", "turns of the hand", "bottle moved [mm]")
    print("|", " | ".join((*columns, "twisted [deg]", "cap lifted [mm]", "failed")), "|")
    print("|---" * 10 + "|")
    for row in rows:
        slid, twisted, rise = row["bottle_slid"] * 1000, np.degrees(row["bottle_twisted"]), row["bottle_rise"] * 1000
        cells = [row["seed"], row["friction"], row["needed"], "yes" if row["bottle_off"] else "no"]
        cells += [f"{row['bottle_turns']:.2f}", 3 * len(row["after"]), f"{slid:.1f}", f"{twisted:.1f}", f"{rise:.0f}"]
        print("|", " | ".join(map(str, [*cells, row["stage"]])), "|")
    off, kept = sum(row["bottle_off"] for row in rows), sum(row["bottle_rise"] > 0.03 for row in rows)
    print(f"\n{off:.0f} of {len(rows)} caps off, {kept} lifted in the hand")


def main() -> int:
    """Run what is missing, and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--report", type=Path)
    args = parser.parse_args()
    file = args.report or args.out
    if file is None:
        parser.error("give --out FILE or --report FILE")
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    left = [seed for seed in range(args.first, args.first + args.trials) if seed not in {r["seed"] for r in rows}]
    with tempfile.TemporaryDirectory() as name, Equipment(lasting=True) as equipment:
        folder = Path(name) / "unscrew"
        shutil.copytree(PROJECT, folder, ignore=shutil.ignore_patterns(".grip"))
        for seed in [] if args.report else left:
            rows.append(trial(seed, folder, equipment))
            with file.open("a") as out:
                print(json.dumps(rows[-1]), file=out)
    report(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
