"""Ways to search that were tried, against what plans now, in turns on the same queries: CPU time of whole plans.

    python benchmarks/plan_ways.py [--robot NAME] [--plans N] [--seed N] [--ways NAME ...]

Queries are those of `motion.py`, others with `--seed`. `roadmap` keeps what it learnt of the scene from one query to
the next, `roadmap, new scene` learns it anew. `paired` is the median of each query's time over that of `as it is`.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest import mock

import numpy as np

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

import motion
import searches
from shortenings import SHORTENINGS

from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning import answer, search
from grip_bt.commanders.planning.paths import length
from grip_bt.commanders.planning.requests import PlanTo, Situation
from grip_bt.commanders.scene_state import SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings

Way = Callable[..., Any]
HEADINGS = ("median", "95 %", "mean", "search", "length", "paired", "solved")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="panda_allegro", choices=sorted(ROBOTS))
    parser.add_argument("--plans", type=int, default=60)
    parser.add_argument("--seed", type=int, default=4, help="of the queries")
    parser.add_argument("--ways", nargs="*", default=[])
    arguments = parser.parse_args()
    model = RobotModel(build_robot(arguments.robot))
    ways = ways_of(model)
    chosen = {"as it is": ways["as it is"]} | {n: ways[n] for n in arguments.ways or ways}
    print(f"{arguments.robot}, {arguments.plans} queries, load {os.getloadavg()[0]:.1f}")
    results = in_turns(model, queries(model, arguments.plans, arguments.seed), chosen)
    base = np.array(results["as it is"])
    print(f"{'way':28}" + "".join(f"{heading:>8}" for heading in HEADINGS))
    for name, rows in results.items():
        table = np.array(rows)
        ms, done = table[:, 0] * 1e3, ~np.isnan(table[:, 2])
        print(
            f"{name:28}{np.median(ms):8.1f}{np.percentile(ms, 95):8.1f}{ms.mean():8.1f}{table[:, 1].mean() * 1e3:8.2f}"
            f"{np.nanmean(table[:, 2]):8.2f}{np.median(table[:, 0] / base[:, 0]):8.2f}{done.mean():8.2f}"
        )


def ways_of(model: RobotModel) -> dict[str, Way]:
    """Return the searches by name."""
    opened = model.description.named_state("hand", "open")
    began = time.process_time()
    roadmap = searches.Roadmap(CollisionChecker(model.chain("arm", opened), SceneSnapshot(), "hand"))
    print(f"roadmap made in {time.process_time() - began:.2f} s of CPU time")

    def forgetful(*arguments: Any) -> Any:
        roadmap.free, kept = {}, roadmap.free
        found = roadmap(*arguments)
        roadmap.free = kept
        return found

    return {
        "as it is": search._solved,
        "OMPL's own range": searches.own_range,
        "state by state": searches.one_by_one,
        "own trees": searches.own_trees,
        "lazy trees": searches.lazy_trees,
        "roadmap": roadmap,
        "roadmap, new scene": forgetful,
        **SHORTENINGS,
    }


def queries(model: RobotModel, count: int, seed: int = 4) -> list[PlanTo]:
    """Return the queries of `motion.plans`, or others with another seed."""
    rng, scene = np.random.default_rng(seed), motion.scene()
    opened = model.description.named_state("hand", "open")
    chain = model.chain("arm", opened)
    checker = CollisionChecker(chain, scene, "hand")
    ends = [q for q in (motion._above_table(checker, rng) for _ in range(40)) if q is not None]
    asked = []
    for number in range(count):
        start, goal = (ends[k] for k in rng.choice(len(ends), 2, replace=False))
        state = JointState(chain.joints + opened.names, np.concatenate([start, opened.position]))
        settings = PlanningSettings(seed=number, planning_time=2.0)
        asked.append(PlanTo(Situation("arm", state, scene, "hand", settings), JointState(chain.joints, goal)))
    return asked


def in_turns(model: RobotModel, asked: list[PlanTo], ways: dict[str, Way]) -> dict[str, list[tuple[float, ...]]]:
    """Return for each way and query: CPU time in all, of the search [s], length of the result [rad]."""
    results: dict[str, list[tuple[float, ...]]] = {name: [] for name in ways}
    names = list(ways)
    for number, query in enumerate([asked[0], *asked]):
        for name in names[number % len(names) :] + names[: number % len(names)]:
            with searched_by(ways[name]) as searching:
                began = time.process_time()
                try:
                    path = answer.answer(model, query, lambda: False).trajectory.positions
                    long = length(path)
                except ExpectedError:
                    long = float("nan")
                took = time.process_time() - began
            if number:  # the first is for the caches
                results[name].append((took, sum(searching), long))
    return results


@contextmanager
def searched_by(way: Way) -> Iterator[list[float]]:
    """Search in another way, or shorten in another way; yields the list of the search's CPU times."""
    spent: list[float] = []

    def timed(*arguments: Any) -> Any:
        with motion.timed(spent):
            return way(*arguments)

    with mock.patch.object(search, *(("shortened", way) if way in SHORTENINGS.values() else ("_solved", timed))):
        yield spent


if __name__ == "__main__":
    main()
