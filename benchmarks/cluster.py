"""What a trial on a Ray cluster costs besides itself: the driver's serial part, the size of what comes back, start-up.

    python benchmarks/cluster.py [--trials 60] [--workers 1 2 4] [--campaign FILE]

Starts a cluster of one node on the loopback (needs the extra `cluster`), and runs a campaign on it whose trials take a
known time: a task that waits on the wall clock, with fake parts, or the campaign that is given.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

from grip_bt.app.campaign.cluster import run_on
from grip_bt.app.campaign.file import head_of, read_campaign
from grip_bt.app.campaign.results import begin
from grip_bt.app.campaign.trials import Trials

TASK = """grip: 1
name: wait
root: {kind: sequence, children: {it: {node: flow/wait, with: {seconds: 0.5}}}}
"""


def main() -> None:
    """Run the campaign with each number of workers, and print a row of the table for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=60)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--campaign", type=Path)
    args = parser.parse_args()
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    from ray.cluster_utils import Cluster

    folder = Path(tempfile.mkdtemp())
    (folder / "grip.yaml").write_text("grip: 1\n")
    (folder / "t.yaml").write_text(TASK)
    (folder / "c.yaml").write_text(
        f"campaign: 1\ntask: t.yaml\nrobot: fake\nseeds: {{count: {args.trials}}}\nvariants: {{one: {{}}}}\n"
    )
    campaign = read_campaign(args.campaign or folder / "c.yaml")
    print("| workers | trials | wall [s] | first row [s] | trials/s after it | driver's CPU a trial [ms] | kB a run |")
    print("|---|---|---|---|---|---|---|")
    for workers in args.workers:
        nodes = {"num_cpus": workers, "node_ip_address": "127.0.0.2", "include_dashboard": False}
        cluster = Cluster(initialize_head=True, head_node_args={**nodes, "object_store_memory": 80 * 2**20})
        results = begin(folder / f"{workers}.jsonl", head_of(campaign), resume=False)
        ends: list[tuple[float, float]] = []

        def ended(row, add=results.add, ends=ends):
            add(row)
            ends.append((time.monotonic(), time.process_time()))

        journal, began = folder / f"{workers}.sqlite", time.monotonic()
        run_on(cluster.address, campaign, Trials(campaign, journal, ended), campaign.trials())
        cluster.shutdown()
        (first, cpu), (last, cpu_then) = ends[0], ends[-1]
        count, size = len(ends) - 1, journal.stat().st_size / len(ends) / 1000
        rate, own = count / (last - first), 1000 * (cpu_then - cpu) / count
        cells = f"{last - began:.1f} | {first - began:.1f} | {rate:.2f} | {own:.1f} | {size:.0f}"
        print(f"| {workers} | {len(ends)} | {cells} |", flush=True)


if __name__ == "__main__":
    main()
