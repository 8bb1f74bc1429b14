"""Figures of the motion room: kinematics, collision checks, plans, scene changes, grasp choice.

    python benchmarks/motion.py [--robot NAME] [--plans N] [--json FILE]

Times are CPU time of this process, except for kinematics, batched checks and scene changes: those are
wall time. Threads wait
without spinning, as in the planning process.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")  # read once, when the first of these is imported

import pinocchio as pin

from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.base.values.solids import Box
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.damped_least_squares import Target
from grip_bt.commanders.kinematics.ik import SOLVERS, solver
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.paths import interpolated
from grip_bt.commanders.planning.requests import ChooseGrasp, PlanTo, Situation
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings

TABLE = {
    "table": ((0.7, 1.2, 0.1), (0.65, 0.0, -0.05)),
    "tower": ((0.1, 0.1, 0.4), (0.5, 0.0, 0.2)),
    "block": ((0.1, 0.1, 0.3), (0.5, -0.35, 0.15)),
    "wide_block": ((0.1, 0.3, 0.25), (0.6, 0.35, 0.125)),
    "shelf": ((0.3, 1.0, 0.03), (0.75, 0.0, 0.75)),
    "wall": ((0.02, 1.6, 1.0), (-0.6, 0.0, 0.5)),
}
"""The table-top scene: name -> (edge lengths, centre) [m]."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="panda_allegro", choices=sorted(ROBOTS))
    parser.add_argument("--plans", type=int, default=60)
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    model = RobotModel(build_robot(arguments.robot))
    figures: dict[str, Any] = {"robot": arguments.robot, "cores": os.cpu_count(), "python": platform.python_version()}
    figures |= kinematics(model) | checks(model) | scene_changes(model)
    figures |= plans(model, arguments.plans) | grasps(model)
    for name, value in figures.items():
        print(f"{name:44} {value:.4g}" if isinstance(value, float) else f"{name:44} {value}")
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump(figures, file, indent=2)


@contextmanager
def timed(into: list[float], clock: Callable[[], float] = time.process_time) -> Iterator[None]:
    begin = clock()
    yield
    into.append(clock() - begin)


def spread(name: str, seconds: list[float]) -> dict[str, float]:
    ms = np.array(seconds) * 1e3
    return {
        f"{name}, ms, median": float(np.median(ms)),
        f"{name}, ms, p95": float(np.percentile(ms, 95)),
        f"{name}, ms, max": float(ms.max()),
    }


def scene() -> SceneSnapshot:
    return SceneSnapshot({n: SceneObject(n, Box(size), Pose(at), fixed=True) for n, (size, at) in TABLE.items()})


def random_configurations(model: RobotModel, count: int, seed: int = 0) -> np.ndarray:
    limits = model.limits("arm")
    return np.random.default_rng(seed).uniform(limits.lower, limits.upper, (count, len(limits.lower)))


def kinematics(model: RobotModel, count: int = 2000) -> dict[str, float]:
    """Solve random reachable poses from random seeds, tolerance 1e-4, at most 40 restarts; wall time."""
    chain, figures = model.chain("arm"), {}
    checker = CollisionChecker(chain, scene(), "hand")
    targets = [Target(chain.grasp_pose(q)) for q in random_configurations(model, count)]
    seeds = random_configurations(model, count, 3)
    free_targets = [Target(chain.grasp_pose(q)) for q in random_configurations(model, count, 2) if checker.free(q)]
    for name in SOLVERS:
        next(solver(name)(chain, targets[0], np.random.default_rng(1)), None)
        for what, wanted, free in (("IK", targets, False), ("IK free of collision", free_targets, True)):
            seconds: list[float] = []
            solved, rng = 0, np.random.default_rng(1)
            for target, seed in zip(wanted, seeds, strict=False):
                with timed(seconds, time.perf_counter):
                    solved += any(not free or checker.free(q) for q in solver(name)(chain, target, rng, (seed,), 40))
            figures[f"{what}, {name}, solved"] = solved / len(wanted)
            figures |= spread(f"{what}, {name}", seconds)
    return figures


def checks(model: RobotModel) -> dict[str, float]:
    checker = CollisionChecker(model.chain("arm"), scene(), "hand")
    configurations = random_configurations(model, 8000)
    figures: dict[str, float] = {"collision pairs": float(len(checker._geometry.collisionPairs))}
    for batch in (1, 16, 8000):
        walls: list[float] = []
        for _ in range(3):
            with timed(walls, time.perf_counter):
                for k in range(0, len(configurations), batch):
                    checker.free_each(configurations[k : k + batch])
        figures[f"collision check in batches of {batch}, us"] = min(walls) / len(configurations) * 1e6
    busiest = min(busiest_thread(lambda: checker.free_each(configurations)) for _ in range(9))
    return figures | {"the same, CPU time of the busiest thread, us": busiest / len(configurations) * 1e6}


def busiest_thread(call: Callable[[], object]) -> float:
    """Return the CPU time of the thread that works most [s]: with a core for each, as long as the call takes."""

    def spent() -> dict[str, int]:
        return {
            task.name: int((task / "schedstat").read_text().split()[0]) for task in Path("/proc/self/task").iterdir()
        }

    before = spent()
    call()
    return max(ns - before.get(task, 0) for task, ns in spent().items()) / 1e9


def scene_changes(model: RobotModel) -> dict[str, float]:
    home = model.description.named_state("arm", "home")
    planning_scene = PlanningScene({"hand": lambda: model.grasp_pose(home)})
    for name, (size, at) in TABLE.items():
        planning_scene.set_box(name, size, Pose(at))
    attach: list[float] = []
    change: list[float] = []
    build: list[float] = []
    chain = model.chain("arm")
    for _ in range(200):
        with timed(change, time.perf_counter):
            with timed(attach, time.perf_counter):
                planning_scene.attach("block", "hand")
            planning_scene.detach("block")
        with timed(build, time.perf_counter):
            CollisionChecker(chain, planning_scene.snapshot(), "hand")
    attached = spread("attach", attach) | spread("attach and detach", change)
    return attached | spread("checker of a new scene", build)


def plans(model: RobotModel, count: int) -> dict[str, float]:
    """Plan between free poses above the table, including simplification, timing and the last check."""
    rng = np.random.default_rng(4)
    opened = model.description.named_state("hand", "open")
    chain = model.chain("arm", opened)
    checker, snapshot = CollisionChecker(chain, scene(), "hand"), scene()
    seconds: list[float] = []
    solved = colliding = samples = needed = 0
    ends = [q for q in (_above_table(checker, rng) for _ in range(40)) if q is not None]
    for seed in range(count):
        start, goal = (ends[k] for k in rng.choice(len(ends), 2, replace=False))
        needed += not checker.all_free(interpolated(np.stack([start, goal]), 0.01))
        state = JointState(chain.joints + opened.names, np.concatenate([start, opened.position]))
        begin = Situation("arm", state, snapshot, "hand", PlanningSettings(seed=seed, planning_time=2.0))
        with timed(seconds):
            try:
                trajectory = answer(model, PlanTo(begin, JointState(chain.joints, goal)), lambda: False).trajectory
            except ExpectedError:
                continue
        solved += 1
        fine = interpolated(trajectory.positions, 0.002)
        colliding += int((~checker.free_each(fine)).sum())
        samples += len(fine)
    return {
        "table-top plans, solved within 2 s": solved / count,
        "table-top plans, direct way blocked": needed / count,
        **spread("table-top plan, all in", seconds),
        "samples of returned paths": samples,
        "samples of returned paths in collision": colliding,
    }


def _above_table(checker: CollisionChecker, rng: np.random.Generator) -> np.ndarray | None:
    """Return a free configuration with the fingers level or pointing down, 12 to 55 cm above the table."""
    yaw, pitch = rng.uniform(-np.pi, np.pi), rng.uniform(0, np.pi / 2)
    rotation = pin.exp3(np.array([0, 0, yaw])) @ pin.exp3(np.array([0, pitch, 0]))
    position = [rng.uniform(0.35, 0.65), rng.uniform(-0.4, 0.4), rng.uniform(0.12, 0.55)]
    found = solver("damped_least_squares")(checker.chain, Target(pin.SE3(rotation, np.array(position))), rng)
    return next((q for q in found if checker.free(q)), None)


def grasps(model: RobotModel, count: int = 20) -> dict[str, float]:
    """Choose among 144 side grasps of three upright things."""
    seconds: list[float] = []
    found = 0
    start = [model.description.named_state(*state) for state in (("arm", "home"), ("hand", "open"))]
    state = JointState(start[0].names + start[1].names, np.concatenate([s.position for s in start]))
    for seed in range(count):
        rng = np.random.default_rng(seed)
        snapshot = scene().without(["tower", "block", "wide_block"])
        candidates: list[Grasp] = []
        for k, place in enumerate(_places(rng)):
            item = SceneObject(f"thing_{k}", Box((0.064, 0.064, 0.16)), Pose([*place, 0.08]))
            snapshot = snapshot.with_object(item)
            candidates += _side_grasps(place, rng)
        begin = Situation("arm", state, snapshot, "hand", PlanningSettings(seed=seed))
        with timed(seconds):
            try:
                answer(model, ChooseGrasp(begin, tuple(candidates)), lambda: False)
                found += 1
            except ExpectedError:
                continue
    return {"grasp choice, found": found / count, **spread("grasp choice", seconds)}


def _places(rng: np.random.Generator) -> list[np.ndarray]:
    places: list[np.ndarray] = []
    while len(places) < 3:
        place = np.array([rng.uniform(0.42, 0.64), rng.uniform(-0.08, 0.32)])
        if all(np.linalg.norm(place - other) >= 0.15 for other in places):
            places.append(place)
    return places


def _side_grasps(place: np.ndarray, rng: np.random.Generator) -> Iterator[Grasp]:
    for yaw in np.linspace(-np.pi, np.pi, 24, endpoint=False):
        for flip in (1.0, -1.0):
            z, y = np.array([np.cos(yaw), np.sin(yaw), 0.0]), np.array([0.0, 0.0, flip])
            matrix = np.eye(4)
            matrix[:3, :3] = np.stack([np.cross(y, z), y, z], axis=1)
            matrix[:3, 3] = np.array([*place, 0.1]) - 0.036 * z
            pose = Pose.from_matrix(matrix)
            yield Grasp(
                pose, pose.moved(-0.12 * z + [0, 0, 0.06]), pose.moved([0, 0, 0.15]), width=0.064, quality=rng.random()
            )


if __name__ == "__main__":
    main()
