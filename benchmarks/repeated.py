"""Runs pairs of a seed of `reactive_pick` and tells in what they differ; the figures stand in `docs/benchmarks.md`.

    python benchmarks/repeated.py [--seeds 10] [--first 0] [--as bt,sm] [--busy 2]

Each run is a process of its own. The first of a pair is left alone. The second has its plans, answers of components and
code in workers come late, by up to 0.3 s at random, and `--busy` processes beside it that do nothing but compute. Exit
status 0 when no pair differs.
"""

import argparse
import contextlib
import os
import random
import resource
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))
TASK = ROOT / "examples" / "tasks" / "reactive_pick.yaml"
LATEST = 0.3
"""The most by which an answer comes late [s]."""


def one(seed: int, target: str, journal: str, late: bool) -> None:
    """Run the task once, in this process, and print the run's id."""
    from grip_bt.app.runs.execute import RunOptions, open_session

    if late:
        delay_answers()
    options = RunOptions(target=target, seed=seed, journal=Path(journal))
    with open_session(TASK, options) as session:
        result = session.runner.run()
        print(session.runner.run_id, result.status, result.outcome, f"{result.duration:.3f}")


def delay_answers() -> None:
    """Have everything that isn't physics come late, each time by another random time."""
    from grip_bt.commanders.planning.service import PlanningProcess
    from grip_bt.ros.component import RosComponent
    from grip_bt.runtime import context

    chance = random.SystemRandom()

    def later(operation):
        late = type(operation)(on_cancel=operation.cancel)

        def answer():
            try:
                late.succeed(operation.result())
            except BaseException as error:  # noqa: BLE001 - handed on
                late.fail(error)

        operation.add_done_callback(lambda: threading.Timer(chance.uniform(0, LATEST), answer).start())
        return late

    for kind, name in ((PlanningProcess, "submit"), (RosComponent, "call")):
        original = getattr(kind, name)
        setattr(kind, name, lambda self, asked, original=original: later(original(self, asked)))
    in_worker = context.in_worker
    context.in_worker = lambda work: later(in_worker(work))


def in_a_process(*arguments: object) -> tuple[str, str, float]:
    """Run `one` in a process of its own; return the run's id, how it ended, and the CPU of all its processes [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, __file__, "--one", *map(str, arguments)]
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(done.stderr)
    run, ending = done.stdout.strip().splitlines()[-1].split(" ", 1)
    return run, ending, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@contextlib.contextmanager
def busy(count: int):
    """Have some processes compute meanwhile."""
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()


def main() -> int:
    """Run the pairs and print the table."""
    from same_run import compared

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--as", dest="targets", default="bt,sm")
    parser.add_argument("--busy", type=int, default=2)
    args = parser.parse_args()
    pairs = differing = events = kept = written = 0
    print("| seed | form | end, simulated s | events | kept states | values | differences | CPU s: alone, late |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        journal = Path(folder) / "runs.sqlite"
        for seed in range(args.first, args.first + args.seeds):
            for target in args.targets.split(","):
                first, ending, alone = in_a_process(seed, target, journal, 0)
                with busy(args.busy):
                    second, _, delayed = in_a_process(seed, target, journal, 1)
                found = compared((journal, first), (journal, second))
                pairs, differing = pairs + 1, differing + bool(found.differences)
                events, kept, written = events + found.events[0], kept + found.kept, written + found.written
                cpu = f"{alone:.1f}, {delayed:.1f}"
                cells = (found.events[0], found.kept, found.written, len(found.differences), cpu)
                print("| " + " | ".join(map(str, (seed, target, ending, *cells))) + " |", flush=True)
                for pair in found.differences[:3]:
                    print("   ", *pair, sep="\n      ")
    totals = f"{events} events, {kept} kept states, {written} values"
    print(f"\n{time.strftime('%F')}: {pairs} pairs, {differing} differ; {totals}")
    return int(differing > 0)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        one(int(sys.argv[2]), sys.argv[3], sys.argv[4], sys.argv[5] == "1")
    else:
        sys.exit(main())
