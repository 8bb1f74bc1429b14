"""`grip demo reactive` with objects dropped during lifts: success, false placements, and what the check is worth.

    python benchmarks/reactive.py --trials 100 --out trials.jsonl [--jobs 2] [--chances 0 0.1 0.3 0.5] [--first SEED]
    python benchmarks/reactive.py --report trials.jsonl

A trial is a run of the demonstration with its own seed; each lift drops its object with the setting's chance, 0 to
1.5 s after it begins. Rows are appended to the file as trials end; a trial that is in there isn't run again. Exit
status 0 when nothing was placed that the hand didn't hold.
"""

from __future__ import annotations

import argparse
import json
import sys
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from attempts import CHECKS, AttemptRecorder, summary
from scipy.stats import binomtest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.verdict import Verdict
from grip_bt.app.wiring.equipment import Equipment
from grip_bt.base.errors import GripError
from grip_bt.cli.demo import ATTEMPT, demo_task
from grip_bt.compilers.binding import parts_of
from grip_sim.faults import Fault

NODE = f"{ATTEMPT}/pick/lift"


def trial(chance: float, seed: int, journal: Path, equipment: Equipment) -> dict[str, Any]:
    """Run one, with what the one before has left, and return its summary."""
    slip = {"slip": Fault(fault="drop", node=NODE, at=(0.0, 1.5), chance=chance)}
    began = time.monotonic()
    options = RunOptions(seed=seed, journal=journal, faults=slip)
    try:
        with open_session(demo_task("reactive"), options, equipment=equipment) as session:
            runner, referee = session.runner, session.resources.referee
            meaning = parts_of(runner.compiled)[ATTEMPT].meaning
            clock = runner.context.clock.now
            recorder = AttemptRecorder(ATTEMPT, CHECKS["reactive"], clock, referee.truth, meaning=meaning)
            runner.observe(recorder)
            verdict = Verdict(session)
            result = runner.run()
            truth = verdict.facts(result).get("truth", {})
    except GripError as error:
        return {"chance": chance, "seed": seed, "status": "error", "message": str(error)[-2000:], "checks": []}
    placed = sum(state == "placed" for state in truth.values())
    wall = time.monotonic() - began
    return {
        "chance": chance,
        "seed": seed,
        "truth": truth,
        **summary(result, recorder.attempts, placed, len(truth), wall),
    }


def share(number: int, total: int) -> str:
    """Return a share with Wilson's 95 % interval."""
    if not total:
        return "-"
    interval = binomtest(number, total).proportion_ci(method="wilson")
    return f"{number}/{total} = {number / total:.0%} ({interval.low:.0%}-{interval.high:.0%})"


def report(rows: list[dict[str, Any]]) -> int:
    """Print the tables; return how many false placements there were."""
    columns = ("drops", "trials", "table cleared", "objects placed", "attempts a trial", "false placements")
    columns += ("taken, held", "taken, not held", "not taken, held", "not taken, not held")
    print(f"| {' | '.join(columns)} |")
    print("|---" * len(columns) + "|")
    wrong = 0
    for chance in sorted({row["chance"] for row in rows}):
        mine = [row for row in rows if row["chance"] == chance]
        ran = [row for row in mine if row["status"] != "error"]
        said = Counter((c["said"] == "taken", c["held"]) for row in ran for c in row["checks"])
        false = sum(row["false_placements"] for row in ran)
        wrong += false
        cells = (
            f"{chance:.0%}",
            str(len(mine)),
            share(sum(row["status"] == "success" and row["placed"] == row["objects"] for row in ran), len(mine)),
            share(sum(row["placed"] for row in ran), sum(row["objects"] for row in ran)),
            f"{sum(row['attempts'] for row in ran) / max(1, len(ran)):.2f}",
            str(false),
            *(str(said[taken, held]) for taken in (True, False) for held in (True, False)),
        )
        print(f"| {' | '.join(cells)} |")
    why = Counter(reason for row in rows for reason in row.get("failures", [row.get("message", "")[-80:]]))
    print("\nwhy attempts failed:", ", ".join(f"{number}x {reason}" for reason, number in why.most_common(12)))
    ends = Counter(row["message"].split(":")[0] for row in rows if row["status"] != "success")
    print(
        "how trials failed:", ", ".join(f"{number}x {reason}" for reason, number in ends.most_common(6)) or "none did"
    )
    return wrong


def main() -> int:
    """Run what is missing, and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--chances", type=float, nargs="+", default=[0.0, 0.1, 0.3, 0.5])
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--report", type=Path)
    args = parser.parse_args()
    file = args.report or args.out
    if file is None:
        parser.error("give --out FILE or --report FILE")
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    if args.report is None:
        done, lock = {(row["chance"], row["seed"]) for row in rows}, threading.Lock()
        left = [
            (c, args.first + k) for k in range(args.trials) for c in args.chances if (c, args.first + k) not in done
        ]

        ready: SimpleQueue[Equipment] = SimpleQueue()
        for _ in range(args.jobs):
            ready.put(Equipment(lasting=True))

        def run(which: tuple[float, int]) -> None:
            equipment = ready.get()
            row = trial(*which, file.with_suffix(".sqlite"), equipment)
            if row["status"] == "error":
                equipment.close()
                equipment = Equipment(lasting=True)
            ready.put(equipment)
            with lock, file.open("a") as out:
                rows.append(row)
                print(json.dumps(row), file=out)

        with ThreadPoolExecutor(args.jobs) as pool:
            list(pool.map(run, left))
    return 1 if report(rows) else 0


if __name__ == "__main__":
    sys.exit(main())
