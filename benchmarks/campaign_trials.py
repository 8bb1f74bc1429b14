"""What a trial of a campaign costs, in processes of its own and in shared ones; figures stand in `docs/benchmarks.md`.

    python benchmarks/campaign_trials.py TASK.yaml [--trials 12] [--cold 3] [--first 0]

CPU time of each process by `/proc`, and its memory. `--cold` seeds, evenly spread over the trials, are run again in new
processes and compared bit by bit; exit status 0 when nothing differs and every trial has ended.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import sys
import tempfile
from pathlib import Path

from grip_bt.app.campaign.results import difference
from grip_bt.app.runs.execute import RunOptions
from grip_bt.app.runs.supervisor import RunProcess, Supervisor

KINDS = {"grip_sim": "simulator", "planning.service": "planner", "server.py": "component"}
TICK, PAGE = os.sysconf("SC_CLK_TCK"), os.sysconf("SC_PAGE_SIZE")


def used(root: int) -> dict[str, tuple[float, float]]:
    """Return CPU time [s] and memory [MB] of a process and all below it, by kind."""
    parents, found = dict[int, tuple[int, str, float, float]](), dict[str, tuple[float, float]]()
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            words = Path("/proc", name, "cmdline").read_text().replace("\0", " ")
            fields = Path("/proc", name, "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended meanwhile
        cpu, memory = (int(fields[11]) + int(fields[12])) / TICK, int(fields[21]) * PAGE / 1e6
        parents[int(name)] = int(fields[1]), words, cpu, memory
    mine = {root}
    while more := {pid for pid, (parent, *_) in parents.items() if parent in mine} - mine:
        mine |= more
    for pid in mine & parents.keys():
        _, words, cpu, memory = parents[pid]
        kind = "run" if pid == root else next((kind for word, kind in KINDS.items() if word in words), "others")
        before = found.get(kind, (0.0, 0.0))
        found[kind] = before[0] + cpu, before[1] + memory
    return found


def trial(task: str, seed: int, journal: Path, process: RunProcess | None = None) -> tuple[str, str]:
    """Run one; return its run and how it ended."""
    options = RunOptions(seed=seed, journal=journal, watchdog=10.0)
    supervisor = Supervisor(task, options, lambda event: None, 10.0, terminal=False, process=process)
    supervisor.start()
    end = supervisor.wait()
    return (supervisor.started or {"run": ""})["run"], end.get("status", "failed")


def main() -> int:
    """Run the trials and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task")
    parser.add_argument("--trials", type=int, default=12)
    parser.add_argument("--cold", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    args = parser.parse_args()
    seeds, wrong = range(args.first, args.first + args.trials), 0
    with tempfile.TemporaryDirectory() as folder:
        journal, runs = Path(folder) / "runs.sqlite", dict[int, str]()
        costs: list[dict[str, float]] = []
        with RunProcess(terminal=False) as process:
            before: dict[str, tuple[float, float]] = {}
            for seed in seeds:
                runs[seed], status = trial(args.task, seed, journal, process)
                now = used(process.child.pid)
                costs.append({kind: now[kind][0] - before.get(kind, (0.0, 0.0))[0] for kind in now})
                before, wrong = now, wrong + (not process.waits)
                memory = ", ".join(f"{kind} {mb:.0f}" for kind, (_, mb) in now.items())
                shown = ", ".join(f"{kind} {seconds:.2f}" for kind, seconds in costs[-1].items())
                print(f"seed {seed}: {status}; {sum(costs[-1].values()):.2f} s: {shown}; MB: {memory}", flush=True)
        for kind in costs[-1]:
            middle = statistics.median(cost.get(kind, 0.0) for cost in costs[1:])
            print(f"median of {kind}, but for the first: {middle:.3f} s")
        for seed in seeds[:: max(1, args.trials // args.cold)]:
            begun = resource.getrusage(resource.RUSAGE_CHILDREN)
            run, status = trial(args.task, seed, journal)
            ended = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = ended.ru_utime + ended.ru_stime - begun.ru_utime - begun.ru_stime
            differs = difference(journal, runs[seed], run)
            wrong += bool(differs)
            print(f"seed {seed} in new processes: {status}; {spent:.2f} s; {differs or 'the same'}", flush=True)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
