"""Which hands take which objects, by one task file: grasped, lifted, and held through a shake, by the referee's word.

    python benchmarks/hands_objects.py -o rows.jsonl [--hands panda ...] [--objects mug ...] [--poses 5] [--first N]
                                       [--workers N] [--dt S]
    python benchmarks/hands_objects.py --report rows.jsonl [--against OTHER.jsonl]

A trial draws how one object of the library rests on the table in front of the robot, where, and how it is turned, and
runs `examples/tasks/lift_and_shake.yaml`. It rests as it stands in the library at two seeds of five, at the others on
any face that carries it, the larger the more often. The simulator and the planner stay up for all trials of a hand and
an object, which waits on the floor behind the robot; the state of the beginning is put back. Rows are appended to the
file as they come; a trial that is in there isn't run again. A pose for which the proposer has no grasp doesn't count.
With `--against`, the trials that both files have are compared, such as those of half the time step.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import ExitStack
from multiprocessing import get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import yaml
from scipy.spatial import ConvexHull

import grip_bt as grip
from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.runs.execute import check_task
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening
from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import quaternion_of
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.compilers import to_tree
from grip_bt.runtime import Runner
from grip_sim.objects import load_object, object_file, object_files
from grip_sim.shaking import MEASURE

ROOT = Path(__file__).resolve().parents[1]
TASK = ROOT / "examples" / "tasks" / "lift_and_shake.yaml"
HANDS = {
    "panda": ("panda", 40.0),
    "robotiq": ("ur5_robotiq", 40.0),
    "xarm": ("xarm7_gripper", 40.0),
    "allegro": ("panda_allegro", 40.0),
    "allegro left": ("panda_allegro_left", 40.0),
    "shadow": ("ur10_shadow", 40.0),
}
"""Hand -> robot, and its arm's acceleration limit [rad/s^2]: the shake needs more than ready-made robots have."""
PROJECT = """grip: 1
robot: {robot}
arms: {{arm: {{group: arm, hand: hand, speed: 0.8, acceleration: 0.15}}}}
hands: {{hand: {{group: hand}}}}
sensors: {{overhead: {{camera: overhead}}}}
nodes: {nodes}
world: one
"""
WORLD = """grip: 1
fixtures: {table: {box: [0.70, 1.20, 0.10], at: [0.65, 0.0, -0.10]}}
cameras:
  overhead: {at: [0.53, 0, 1.3], quaternion: [0, 0.7071067811865476, -0.7071067811865476, 0], field_of_view: 0.44}
shake: {}
dt: %r
objects: {thing: {model: %s, at: [-2, 0, -0.75]}}
"""
ABOVE = 0.001
"""Of the table, when an object is put there [m]."""
STANDING = 2
"""So many seeds of five have an object as it stands in the library."""
LOST, NO_FIT = "not held through the shake", "propose: no_grasp"
Row = dict[str, Any]


class Stages(grip.Observer):
    """Remembers the first node that failed, and how the object lay in the hand after each part of the motion."""

    def __init__(self, in_hand: Callable[[], Pose]):
        self.first, self.attempts, self.lay = "", 0, dict[str, Pose]()
        self._in_hand = in_hand

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        """Note it."""
        name = path.rpartition("/")[2]
        if failure is not None and not self.first:
            self.first = f"{name}: {failure.code}"
        self.attempts += name == "preshape"
        if name in ("approach", "close", "lift", "shake"):
            self.lay[name] = self._in_hand()

    def moved(self) -> dict[str, list[float]]:
        """Return how far it moved [mm] and turned [deg] while the hand closed, lifted, and was shaken."""
        lay = list(self.lay.items())
        ways = {name: before.inverse() @ now for (_, before), (name, now) in zip(lay, lay[1:], strict=False)}
        return {
            name: [
                round(1000 * float(np.linalg.norm(way.position)), 1),
                round(float(np.degrees(np.linalg.norm(way.rotation_vector()))), 1),
            ]
            for name, way in ways.items()
        }


class Bench:
    """A robot in a world with an object behind it, which is put before it again and again."""

    def __init__(self, hand: str, thing: str, dt: float, folder: Path, stack: ExitStack):
        robot, acceleration = HANDS[hand]
        self.hand, self.thing = hand, thing
        (folder / "worlds").mkdir()
        (folder / "tasks").mkdir()
        said = yaml.safe_load(Path(ROBOTS[robot]).read_text())
        said["accelerations"] = {"hand": said.get("accelerations", {}).get("hand", 40.0), "arm": acceleration}
        (folder / "grip.yaml").write_text(PROJECT.format(robot=json.dumps(said), nodes=TASK.parents[1] / "nodes"))
        (folder / "worlds" / "one.yaml").write_text(WORLD % (dt, thing))
        file = folder / "tasks" / TASK.name
        file.write_text(TASK.read_text())
        self._project, document, *_ = check_task(file)
        self._task, self._catalog = document.task, catalogue_of(self._project)
        leaves = [leaf.manifest for leaf in to_tree(self._task, self._catalog).leaves.values()]
        opening = Opening(self._project)
        self._parts = stack.enter_context(open_resources(opening, {each.id for each in leaves}, "sim"))
        self._simulation = self._parts.world
        self._start = self._simulation.kept()
        self._points = np.concatenate(load_object(object_file(thing)).parts)
        self._faces = resting_faces(thing)

    def trial(self, seed: int) -> Row:
        """Run one and return its row."""
        began = time.monotonic()
        place = self._put(seed)
        hand, referee = self._parts.arms["arm"], self._simulation.referee
        stages = Stages(lambda: hand.grasp_pose().inverse() @ referee.truth()["thing"].pose)
        runner = Runner(to_tree(self._task, self._catalog), self._parts.context())
        runner.observe(stages)
        result = runner.run()
        runner.dismiss()
        held = referee.measures()[MEASURE] == 1
        stage = "" if held else stages.first or LOST
        grasp = result.data.get("grasp")
        row = {"hand": self.hand, "object": self.thing, "seed": seed, "held": held, "stage": stage}
        row |= {"message": str(result.failure or "")[:300], "place": place, "moved": stages.moved()}
        if grasp is not None:
            row["palm"] = [*grasp.pose.position.round(3).tolist(), *grasp.pose.quaternion.round(3).tolist()]
        row["attempts"] = stages.attempts
        return {**row, "simulated": round(result.duration, 1), "wall": round(time.monotonic() - began, 1)}

    def _put(self, seed: int) -> list[float]:
        """Put the object before the robot; return x, y [m], yaw [rad], and which way of it is down."""
        rng = np.random.default_rng([seed, *self.thing.encode()])
        x, y, yaw = rng.uniform([0.48, -0.12, -np.pi], [0.60, 0.12, np.pi]).round(4).tolist()
        down = DOWN
        if seed % 5 >= STANDING:
            areas = np.array([area for _, area in self._faces])
            down = self._faces[rng.choice(len(areas), p=areas / areas.sum())][0]
        turn = Pose(quaternion=quaternion_of(0, 0, yaw)) @ Pose.from_matrix(_laid(down))
        height = ABOVE - float(turn.apply(self._points)[:, 2].min())
        poses = np.array([[x, y, height, *turn.quaternion]])
        self._simulation.put_back({**self._start, "poses": poses})
        self._simulation.settle()
        scene = self._parts.scene
        for name in scene.names():
            if not scene.fixed(name):
                scene.detach(name)
                scene.remove(name)
        return [x, y, yaw, *down.round(3).tolist()]


DOWN = np.array([0.0, 0.0, -1.0])


def resting_faces(thing: str) -> list[tuple[Array, float]]:
    """Return the faces of an object's hull on which it can rest: the normal, in its frame, and the area [m^2]."""
    model = load_object(object_file(thing))
    hull = ConvexHull(np.concatenate(model.parts))
    found: dict[bytes, list[Array]] = {}
    normals = hull.equations[:, :3].round(2) + 0.0
    for normal, corners in zip(normals, hull.points[hull.simplices], strict=True):
        found.setdefault(normal.tobytes(), []).append(corners)
    faces = []
    for key, triangles in found.items():
        normal = np.frombuffer(key) / np.linalg.norm(np.frombuffer(key))
        area = sum(float(np.linalg.norm(np.cross(b - a, c - a))) / 2 for a, b, c in triangles)
        below = model.centre + normal * (normal @ (triangles[0][0] - model.centre))
        if any(_inside(below, triangle, normal) for triangle in triangles):
            faces.append((normal, area))
    return faces


def _inside(point: Array, triangle: Array, normal: Array) -> bool:
    sides = [np.cross(b - a, point - a) @ normal for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)]
    return min(sides) >= 0 or max(sides) <= 0


def _laid(down: Array) -> Array:
    """Return the turn that brings a direction of an object down, shape (4, 4)."""
    side = np.cross(DOWN, down)
    if np.linalg.norm(side) < 1e-6:
        return np.diag([1.0, -down[2], -down[2], 1.0])
    axis = side / np.linalg.norm(side)
    frames = [np.stack([axis, way, np.cross(axis, way)], axis=1) for way in (down, DOWN)]
    turn = np.eye(4)
    turn[:3, :3] = frames[1] @ frames[0].T
    return turn


def report(rows: Iterable[Row]) -> None:
    """Print the table, what failed at which stage, and the share of each hand."""
    rows = list(rows)
    hands = [hand for hand in HANDS if any(row["hand"] == hand for row in rows)]
    fit = [row for row in rows if row["stage"] != NO_FIT]
    print(f"| object | {' | '.join(hands)} |")
    print("|---" * (len(hands) + 1) + "|")
    for thing in sorted({row["object"] for row in rows}):
        cells = []
        for hand in hands:
            tried = [row for row in rows if (row["hand"], row["object"]) == (hand, thing)]
            mine = [row["held"] for row in tried if row["stage"] != NO_FIT]
            cells.append(f"{sum(mine)}/{len(mine)}" if mine else "-" if tried else "")
        print(f"| {thing} | {' | '.join(cells)} |")
    counted = {hand: [row for row in fit if row["hand"] == hand] for hand in hands}
    shares = (
        f"{sum(r['held'] for r in c)}/{len(c)} = {sum(r['held'] for r in c) / max(1, len(c)):.0%}"
        for c in counted.values()
    )
    print(f"| **held** | {' | '.join(shares)} |")
    for hand, mine in counted.items():
        why = Counter(row["stage"] for row in mine if not row["held"])
        poses, things = sum(row["hand"] == hand for row in rows), len({row["object"] for row in mine})
        print(f"\n{hand}: a grasp in {len(mine)} of {poses} poses, of {things} objects; what failed: ", end="")
        print(", ".join(f"{number}x {stage}" for stage, number in why.most_common()) or "nothing")


def compare(rows: Iterable[Row], others: Iterable[Row]) -> None:
    """Print in how many trials with a grasp, of those that both have, the referee saw something else."""
    mine, theirs = ({(row["hand"], row["object"], row["seed"]): row for row in each} for each in (rows, others))
    pairs = [(key, mine[key], theirs[key]) for key in mine.keys() & theirs.keys()]
    pairs = [pair for pair in pairs if NO_FIT not in (pair[1]["stage"], pair[2]["stage"])]
    differ = [
        (*key, one["stage"] or "held", two["stage"] or "held") for key, one, two in pairs if one["held"] != two["held"]
    ]
    print(f"\n{len(differ)} of {len(pairs)} trials of both ended otherwise; held: ", end="")
    print(*(sum(pair[which]["held"] for pair in pairs) for which in (1, 2)), sep=" and ")
    for each in sorted(differ):
        print("*", ", ".join(map(str, each)))


def run_pair(hand: str, thing: str, dt: float, seeds: Iterable[int]) -> list[Row]:
    """Run the trials of a hand and an object, and return their rows."""
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        bench = Bench(hand, thing, dt, Path(name), stack)
        return [bench.trial(seed) for seed in seeds]


def end_with_parent() -> None:
    """Have a worker's process end when the one that started it is gone, however suddenly; nobody else would end it."""
    parent = parent_process()
    assert parent is not None, "this is a worker"

    def watch() -> None:
        parent.join()
        os._exit(1)

    Thread(target=watch, name="parent", daemon=True).start()


def rows_of(file: Path) -> list[Row]:
    """Return what a file holds."""
    return [json.loads(line) for line in file.read_text().splitlines()]


def main() -> int:
    """Run what is missing, and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hands", nargs="+", choices=HANDS, default=list(HANDS))
    parser.add_argument("--objects", nargs="+", default=sorted(object_files()))
    parser.add_argument("--poses", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("-o", "--out", type=Path)
    parser.add_argument("--dt", type=float, default=1 / 240)
    parser.add_argument("--report", type=Path)
    parser.add_argument("--against", type=Path)
    args = parser.parse_args()
    file = args.report or args.out
    if file is None:
        parser.error("give -o FILE or --report FILE")
    rows = rows_of(file) if file.exists() else []
    if args.report is None:
        done = {(row["hand"], row["object"], row["seed"]) for row in rows}
        pairs = [(hand, thing) for thing in args.objects for hand in args.hands]
        seeds = range(args.first, args.first + args.poses)
        left = {pair: [seed for seed in seeds if (*pair, seed) not in done] for pair in pairs}
        pool = ProcessPoolExecutor(args.workers, get_context("spawn"), initializer=end_with_parent)
        with pool, file.open("a") as out:
            running = [pool.submit(run_pair, *pair, args.dt, missing) for pair, missing in left.items() if missing]
            for ended in as_completed(running):
                for row in ended.result():
                    rows.append(row)
                    print(json.dumps(row), file=out, flush=True)
    report(rows)
    if args.against is not None:
        compare(rows, rows_of(args.against))
    return 0


if __name__ == "__main__":
    sys.exit(main())
