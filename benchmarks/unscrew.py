"""Two arms unscrew a bottle: `examples/unscrew` on bottles that seeds draw, by the referee's word.

    python benchmarks/unscrew.py --seeds 0..19 -o rows.jsonl [--workers N]
    python benchmarks/unscrew.py --report rows.jsonl

A seed draws where the bottle stands, how hard its thread goes and how far it has to be turned. The simulator and the
planner stay up. Rows are appended to the file as trials end; a trial that is in there isn't run again. One that can't
be begun, as where a machine is too busy for the controller to appear in time, is told and left out: run it again.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import grip_bt as grip
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.wiring.equipment import Equipment
from grip_bt.base.errors import GripError
from grip_sim.worlds import HERE as WORLDS

PROJECT = Path(__file__).resolve().parents[1] / "examples" / "unscrew"
Row = dict[str, Any]


class Watch(grip.Observer):
    """Remembers what failed first, how often an attempt began, and what the referee has measured after each turn."""

    def __init__(self, referee: Any):
        self.first, self.attempts, self.after, self.pulls, self._referee = "", 0, list[float](), list[float](), referee

    def entered(self, path: str) -> None:
        """Count an attempt."""
        self.attempts += path.endswith("attempt")

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """Note a pull [N]."""
        if variable == "pull" and path.endswith("/pull") and isinstance(value, float):
            self.pulls.append(round(value, 2))

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
    with open_session(folder / "tasks" / "unscrew.yaml", RunOptions(seed=seed), equipment=equipment) as session:
        referee = session.resources.referee
        assert referee is not None, "a simulated run has one"
        watch = Watch(referee)
        session.runner.observe(watch)
        result = session.runner.run()
        measures = {name: round(value, 4) for name, value in referee.measures().items()}
    row = {"seed": seed, "at": bottle["at"], "friction": friction, "needed": turns}
    row |= {"status": result.status, "outcome": result.outcome, "attempts": watch.attempts, "stage": watch.first}
    row |= {"message": str(result.failure or result.error or "")[:300], "after": watch.after, "pulls": watch.pulls}
    return {**row, **measures, "simulated": round(result.duration, 1), "wall": round(time.monotonic() - began, 1)}


def report(rows: Iterable[Row]) -> None:
    """Print the table."""
    rows = sorted(rows, key=lambda row: row["seed"])
    columns = ("seed", "thread [N m]", "turns to go", "cap off", "turned", "turns of the hand", "bottle moved [mm]")
    print("|", " | ".join((*columns, "twisted [deg]", "cap lifted [mm]", "attempts", "ended", "failed first")), "|")
    print("|---" * 12 + "|")
    for row in rows:
        slid, twisted, rise = row["bottle_slid"] * 1000, np.degrees(row["bottle_twisted"]), row["bottle_rise"] * 1000
        cells = [row["seed"], row["friction"], row["needed"], "yes" if row["bottle_off"] else "no"]
        cells += [f"{row['bottle_turns']:.2f}", len(row["after"]), f"{slid:.1f}", f"{twisted:.1f}", f"{rise:.0f}"]
        print("|", " | ".join(map(str, [*cells, row["attempts"], row["outcome"] or row["status"], row["stage"]])), "|")
    off, kept = sum(row["bottle_off"] for row in rows), sum(row["bottle_rise"] > 0.03 for row in rows)
    ended = sum(row["outcome"] == "opened" for row in rows)
    print(f"\n{off:.0f} of {len(rows)} caps off, {kept} lifted in the hand, {ended} successes by the task's word")


def seeds_of(text: str) -> list[int]:
    """Return the seeds that `0..19` or `3,5,8` names."""
    first, dots, last = text.partition("..")
    return list(range(int(first), int(last) + 1)) if dots else [int(word) for word in text.split(",")]


def read(file: Path) -> list[Row]:
    """Return the rows of a file that may not be there yet."""
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def run(seeds: list[int], out: Path) -> None:
    """Run trials and append their rows."""
    with tempfile.TemporaryDirectory() as name, Equipment(lasting=True) as equipment:
        folder = Path(name) / "unscrew"
        shutil.copytree(PROJECT, folder, ignore=shutil.ignore_patterns(".grip"))
        for seed in seeds:
            try:
                row = json.dumps(trial(seed, folder, equipment))
            except GripError as error:
                print(f"seed {seed} isn't run: {error}", file=sys.stderr)
                continue
            with out.open("a") as file:
                file.write(f"{row}\n")


def main() -> int:
    """Run what is missing, and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, default=seeds_of("0..19"), metavar="A..B|A,B")
    parser.add_argument("-o", "--out", type=Path, metavar="FILE")
    parser.add_argument("--workers", type=int, default=1, help="processes that share the seeds (default: 1)")
    parser.add_argument("--report", type=Path, metavar="FILE")
    args = parser.parse_args()
    file = args.report or args.out
    if file is None:
        parser.error("give -o FILE or --report FILE")
    done = {row["seed"] for row in read(file)}
    left = [] if args.report else [seed for seed in args.seeds if seed not in done]
    if args.workers > 1:
        parts = [",".join(map(str, part)) for k in range(args.workers) if (part := left[k :: args.workers])]
        command = [sys.executable, __file__, "-o", str(file), "--seeds"]
        for worker in [subprocess.Popen([*command, part], stdout=subprocess.DEVNULL) for part in parts]:
            worker.wait()
    elif left:
        run(left, file)
    rows = read(file)
    report(rows)
    return 0 if args.report or {row["seed"] for row in rows}.issuperset(args.seeds) else 1


if __name__ == "__main__":
    sys.exit(main())
