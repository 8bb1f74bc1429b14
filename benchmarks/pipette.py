"""A Shadow hand pipettes: `examples/pipette` on benches that seeds draw, by the referee's word.

    python benchmarks/pipette.py --out rows.jsonl [--trials 20] [--first N]
    python benchmarks/pipette.py --report rows.jsonl

A seed draws where the stand, the beaker and the rack with the tube are, by up to 2 cm each way, how hard the plunger's
spring is, what the pipette weighs, and how much is in the beaker. The simulator and the planner stay up. Rows are
appended to the file as trials end; a trial that is in there isn't run again.
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

PROJECT = Path(__file__).resolve().parents[1] / "examples" / "pipette"
WORLD = Path("worlds") / "pipette_bench.yaml"
Row = dict[str, Any]


class Watch(grip.Observer):
    """Remembers the first node that failed, and what the referee has measured when liquid was drawn and released."""

    def __init__(self, referee: Any):
        self.first, self.after, self._referee = "", dict[str, dict[str, float]](), referee

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        """Note it."""
        name = path.rpartition("/")[2]
        if failure is not None and not self.first:
            self.first = f"{path}: {failure.code}"
        if name in ("lift", "draw", "release", "put_back"):
            self.after[path] = {key: round(value, 3) for key, value in self._referee.measures().items()}


def drawn(seed: int) -> tuple[dict[str, Any], Row]:
    """Return the bench of a seed, and what was drawn."""
    rng, said = np.random.default_rng(seed), yaml.safe_load((PROJECT / WORLD).read_text())
    row: Row = {"seed": seed}
    moved = {
        "stand": [said["fixtures"]["stand"], said["articulated"]["pipette"]],
        "beaker": [said["objects"]["beaker"]],
        "rack": [said["fixtures"]["rack"], said["objects"]["tube"]],
    }
    for name, things in moved.items():
        row[name] = [round(float(by), 4) for by in rng.uniform([-0.02, -0.02], [0.02, 0.02])]
        for thing in things:
            x, y, z = thing["at"]
            thing["at"] = [round(x + row[name][0], 4), round(y + row[name][1], 4), z]
    limits = {"force": (3.0, 5.0), "mass": (0.1, 0.15)}
    row |= {name: round(float(rng.uniform(*between)), 3) for name, between in limits.items()}
    said["articulated"]["pipette"]["pipette"] |= {name: row[name] for name in limits}
    row["water"] = said["objects"]["beaker"]["vessel"]["volume"] = round(float(rng.uniform(60, 90)), 1)
    return said, row


def trial(seed: int, folder: Path, equipment: Equipment) -> Row:
    """Run one and return its row."""
    began = time.monotonic()
    said, row = drawn(seed)
    (folder / WORLD).write_text(yaml.safe_dump(said))
    project, document, *_ = check_task(folder / "tasks" / "pipette.yaml")
    catalog = catalogue_of(project)
    needs = {leaf.manifest.id for leaf in to_tree(document.task, catalog).leaves.values()}
    with ExitStack() as stack:
        parts = stack.enter_context(open_resources(Opening(project, seed, equipment=equipment), needs, "sim"))
        referee = parts.world.referee
        watch = Watch(referee)
        runner = Runner(to_tree(document.task, catalog), parts.context())
        runner.observe(watch)
        result = runner.run()
        runner.dismiss()
        truth, measures = referee.truth(), referee.measures()
    row |= {"status": result.status, "stage": watch.first, "after": watch.after}
    row["message"] = str(result.failure or result.error or "")[:300]
    row |= {name: round(value, 4) for name, value in measures.items()}
    row |= {f"{name}_is": each.status for name, each in truth.items()}
    row["tube_pressed"] = round(truth["tube"].hand_force, 2)
    row["delivered"] = "delivery" in truth["tube"].regions
    return {**row, "simulated": round(result.duration, 1), "wall": round(time.monotonic() - began, 1)}


def success(row: Row) -> bool:
    """Tell whether the project's goal is met."""
    return bool(row["tube_volume"] > 4.5 and row["spilled"] < 0.1 and row["delivered"])


def report(rows: Iterable[Row]) -> None:
    """Print the table."""
    rows = list(rows)
    columns = ("seed", "spring [N]", "pipette [g]", "taken", "drawn [ml]", "in the tube [ml]", "spilled [ml]")
    print("|", " | ".join((*columns, "tube at the pose", "success", "failed")), "|")
    print("|---" * 10 + "|")
    for row in rows:
        pulled = row["after"].get("draw", {}).get("pipette_holds", 0.0)
        cells = [row["seed"], row["force"], round(1000 * row["mass"]), "yes" if "take/lift" in row["after"] else "no"]
        cells += [f"{value:.2f}" for value in (pulled, row["tube_volume"], row["spilled"])]
        cells += ["yes" if row["delivered"] else "no", "yes" if success(row) else "no", row["stage"]]
        print("|", " | ".join(map(str, cells)), "|")
    print(f"\n{sum(map(success, rows))} of {len(rows)} succeeded")


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
        folder = Path(name) / "pipette"
        shutil.copytree(PROJECT, folder, ignore=shutil.ignore_patterns(".grip"))
        for seed in [] if args.report else left:
            rows.append(trial(seed, folder, equipment))
            with file.open("a") as out:
                print(json.dumps(rows[-1]), file=out)
    report(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
