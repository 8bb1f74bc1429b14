"""Runs the demo on many seeds, one after the other, and prints the table that `docs/benchmarks.md` holds.

    python benchmarks/demo_seeds.py [--seeds 20] [--as bt|sm] [--first 0]

Exit status 0 when at least 19 of 20 succeed (or the same share of another number).
"""

import argparse
import json
import statistics
import subprocess
import sys
import time


def one(seed: int, target: str) -> dict:
    """Run one seed in a process of its own and return its result."""
    began = time.monotonic()
    command = [sys.executable, "-m", "grip_bt.cli", "demo", "--seed", str(seed), "--as", target, "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    last = (done.stdout.strip().splitlines() or ["{}"])[-1]
    result = json.loads(last) if last.startswith("{") else {}
    return {**result, "seed": seed, "exit": done.returncode, "wall": time.monotonic() - began, "stderr": done.stderr}


def main() -> int:
    """Run the seeds and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--as", dest="target", choices=("bt", "sm"), default="bt")
    args = parser.parse_args()
    print("| seed | in the crate | why it failed | simulated s | wall s | exit |")
    print("|---|---|---|---|---|---|")
    rows = []
    for seed in range(args.first, args.first + args.seeds):
        row = one(seed, args.target)
        rows.append(row)
        truth, simulated = row.get("truth", {}), row.get("duration", float("nan"))
        placed = sum(state == "placed" for state in truth.values())
        why = row.get("message") or "-"
        cells = (seed, f"{placed} of {len(truth)}", why, f"{simulated:.1f}", f"{row['wall']:.1f}", row["exit"])
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)
        if row["exit"] != 0:
            print(row["stderr"], file=sys.stderr)
    good = sum(r["exit"] == 0 for r in rows)
    walls = [r["wall"] for r in rows]
    print(f"\n{good} of {len(rows)} seeds; wall median {statistics.median(walls):.1f} s, longest {max(walls):.1f} s")
    return int(good < 0.95 * len(rows))


if __name__ == "__main__":
    sys.exit(main())
