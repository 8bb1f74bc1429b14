"""Planning again and planning twice: warm starts in a changed scene, and two planning processes that race.

    python benchmarks/plan_again.py [--robot NAME] [--plans N]

Warm starts: each query of `motion.py` is asked, then again with its ends moved by up to 0.05 rad and everything that
stands on the table by up to 3 cm: from nothing, and from the path of before, of which only what is no longer free is
searched anew. CPU time, in turns. The race: wall time of one planning process, and of two that search with different
seeds, until the first has an answer; and what it would be if both had a core to themselves.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import threading
import time
from collections.abc import Callable
from typing import Any
from unittest import mock

import numpy as np

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

import motion
from numpy.typing import NDArray
from plan_ways import queries
from searches import SOLVED

from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning import answer
from grip_bt.commanders.planning import search as planning_search
from grip_bt.commanders.planning.paths import length
from grip_bt.commanders.planning.requests import PlanTo
from grip_bt.commanders.planning.search import MotionCheck
from grip_bt.commanders.planning.service import PlanningProcess
from grip_bt.commanders.scene_state import SceneSnapshot

Array = NDArray[np.float64]
MOVED = ("tower", "block", "wide_block")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="panda_allegro", choices=sorted(ROBOTS))
    parser.add_argument("--plans", type=int, default=60)
    arguments = parser.parse_args()
    model = RobotModel(build_robot(arguments.robot))
    asked = queries(model, arguments.plans)
    print(f"{arguments.robot}, {arguments.plans} queries, load {os.getloadavg()[0]:.1f}")
    warm_starts(model, asked)
    race_with_cores_to_spare(model, asked)
    race(model, asked)


def warm_starts(model: RobotModel, asked: list[PlanTo]) -> None:
    """Print CPU time and length of plans in a changed scene, from nothing and from the path of before."""
    rng = np.random.default_rng(7)
    rows: dict[str, list[tuple[float, float]]] = {"from nothing": [], "warm": [], "warm, only pruned": []}
    answer_keeping(model, asked[0], None)
    for query in asked:
        _, _, path = answer_keeping(model, query, None)
        changed = moved(model, query, rng)
        if path is None or changed is None:
            continue
        names = list(rows)
        order = [names[(len(rows["warm"]) + k) % 3] for k in range(3)]
        for name in order:
            rounds = 0 if "pruned" in name else 60
            took, long, _ = answer_keeping(model, changed, None if name == "from nothing" else path, rounds)
            rows[name].append((took, long))
    base = np.array(rows["from nothing"])
    for name, row in rows.items():
        table = np.array(row)
        ms, paired = table[:, 0] * 1e3, np.median(table[:, 0] / base[:, 0])
        print(
            f"{name:20} {len(row)} plans, median {np.median(ms):.1f}, 95 % {np.percentile(ms, 95):.1f}, mean "
            f"{ms.mean():.1f} ms, paired {paired:.2f}, length {np.nanmean(table[:, 1]):.2f}"
        )


def answer_keeping(
    model: RobotModel, query: PlanTo, warm: Array | None, rounds: int = 60
) -> tuple[float, float, Array | None]:
    """Return CPU time [s], length of the result [rad] and the searched path, None where the straight way is free."""
    kept: list[Array] = []

    def shortened(path: Array, *rest: Any) -> Array:
        kept.append(SHORTENED(path, *rest, rounds=rounds if warm is not None else 60))
        return kept[-1]

    search: Callable[..., Any] = SOLVED if warm is None else lambda *arguments: repaired(warm, *arguments)
    with (
        mock.patch.object(planning_search, "_solved", search),
        mock.patch.object(planning_search, "shortened", shortened),
    ):
        began = time.process_time()
        try:
            long = length(answer.answer(model, query, lambda: False).trajectory.positions)
        except ExpectedError:
            long = float("nan")
        return time.process_time() - began, long, kept[-1] if kept else None


SHORTENED = planning_search.shortened


def repaired(
    before: Array, checker: CollisionChecker, motion_free: MotionCheck, start: Array, goal: Array, *rest: Any
) -> Array | None:
    """Return the path of before with new ends; between free rows that are no longer joined, search."""
    inner = before[1:-1]
    rows = [start, *inner[checker.free_each(inner)], goal] if len(inner) else [start, goal]
    path = [start]
    for row in rows[1:]:
        if motion_free(path[-1], row):
            path.append(row)
            continue
        piece = SOLVED(checker, motion_free, path[-1], row, *rest)
        if piece is None:
            return None
        path.extend(piece[1:])
    return np.stack(path)


def moved(model: RobotModel, query: PlanTo, rng: np.random.Generator) -> PlanTo | None:
    """Return the query with other ends in a changed scene, both free there; None when none was found."""
    assert isinstance(query.goal, JointState)
    situation = query.situation
    scene: SceneSnapshot = situation.scene
    for name in MOVED:
        item = scene.objects[name]
        shift = [*rng.uniform(-0.03, 0.03, 2), 0.0]
        scene = scene.with_object(dataclasses.replace(item, pose=item.pose.moved(shift)))
    n = len(query.goal.names)
    checker = CollisionChecker(model.chain("arm", situation.start), scene, "hand")
    for _ in range(50):
        start, goal = (np.array(p[:n]) + rng.uniform(-0.05, 0.05, n) for p in _ends(query))
        limits = checker.chain.limits
        start, goal = np.clip(start, limits.lower, limits.upper), np.clip(goal, limits.lower, limits.upper)
        if checker.free(start) and checker.free(goal):
            state = JointState(situation.start.names, np.concatenate([start, situation.start.position[n:]]))
            begin = dataclasses.replace(situation, start=state, scene=scene)
            return dataclasses.replace(query, situation=begin, goal=JointState(query.goal.names, goal))
    return None


def _ends(query: PlanTo) -> tuple[Array, Array]:
    assert isinstance(query.goal, JointState)
    return query.situation.start.position, query.goal.position


def race_with_cores_to_spare(model: RobotModel, asked: list[PlanTo]) -> None:
    """Print CPU times of one search and of the quicker of two: what a race takes with a free core for each."""
    one = np.array([answer_keeping(model, query, None)[0] for query in asked]) * 1e3
    other = np.array([answer_keeping(model, _reseeded(query), None)[0] for query in asked]) * 1e3
    for name, ms in (("one search", one), ("the quicker of two", np.minimum(one, other))):
        print(f"{name}: median {np.median(ms):.1f}, 95 % {np.percentile(ms, 95):.1f}, mean {ms.mean():.1f} ms")


def race(model: RobotModel, asked: list[PlanTo]) -> None:
    """Print wall times of one process and of two."""
    walls: dict[str, list[float]] = {"one": [], "two": []}
    with PlanningProcess(model.description) as one, PlanningProcess(model.description) as two:
        for process in (one, two):
            assert process.wait_until_ready()
            for query in asked[:3]:
                process.submit(query).wait(60)
        for number, query in enumerate(asked):
            for name in ("one", "two") if number % 2 else ("two", "one"):
                first = threading.Event()
                seeds = [query] if name == "one" else [query, _reseeded(query)]
                with motion.timed(walls[name], time.perf_counter):
                    running = [p.submit(q) for p, q in zip((one, two), seeds, strict=False)]
                    for operation in running:
                        operation.add_done_callback(first.set)
                    first.wait(60)
                for operation in running:
                    operation.cancel()
                    operation.wait(60)
                assert all(process.wait_until_ready() for process in (one, two))
    for name, row in walls.items():
        ms = np.array(row) * 1e3
        print(f"{name} planning: median {np.median(ms):.1f}, 95 % {np.percentile(ms, 95):.1f}, mean {ms.mean():.1f} ms")
    ratio = np.median(np.array(walls["two"]) / np.array(walls["one"]))
    print(f"two to one, paired: {ratio:.2f}; load {os.getloadavg()[0]:.1f}")


def _reseeded(query: PlanTo) -> PlanTo:
    was = query.situation.settings
    settings = was.model_copy(update={"seed": was.seed + 5000})
    return dataclasses.replace(query, situation=dataclasses.replace(query.situation, settings=settings))


if __name__ == "__main__":
    main()
