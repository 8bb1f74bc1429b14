"""Which hands take which objects, by one task file: grasped, lifted, and held through a shake, by the referee's word.

    python benchmarks/hands_objects.py --out rows.jsonl [--hands panda ...] [--objects mug ...] [--poses 5] [--first N]
    python benchmarks/hands_objects.py --report rows.jsonl

A trial draws where one object of the library stands in front of the robot and how it is turned, and runs
`examples/tasks/lift_and_shake.yaml`. The simulator and the planner stay up for all trials of a hand: objects wait on
the floor behind the robot, and the state of the beginning is put back. Rows are appended to the file as trials end; a
trial that is in there isn't run again. An object that the proposer has no grasp for in any pose doesn't fit.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import grip_bt as grip
from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.runs.execute import check_task
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import quaternion_of
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.compilers import to_tree
from grip_bt.runtime import Runner
from grip_sim.objects import object_files
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
objects:
"""
FLOOR = -0.75
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
    """A robot in a world with objects behind it, of which one at a time is put before it."""

    def __init__(self, hand: str, things: Sequence[str], folder: Path, stack: ExitStack):
        robot, acceleration = HANDS[hand]
        self.hand, self.things = hand, list(things)
        (folder / "worlds").mkdir()
        (folder / "tasks").mkdir()
        said = yaml.safe_load(Path(ROBOTS[robot]).read_text())
        said["accelerations"] = {"hand": said.get("accelerations", {}).get("hand", 40.0), "arm": acceleration}
        (folder / "grip.yaml").write_text(PROJECT.format(robot=json.dumps(said), nodes=TASK.parents[1] / "nodes"))
        rows = (
            f"  {name}: {{model: {name}, at: [{-2 - 0.5 * (k // 6)}, {0.5 * (k % 6) - 1.25}, {FLOOR}]}}\n"
            for k, name in enumerate(things)
        )
        (folder / "worlds" / "one.yaml").write_text(WORLD + "".join(rows))
        file = folder / "tasks" / TASK.name
        file.write_text(TASK.read_text())
        self._project, document, _ = check_task(file)
        self._task, self._catalog = document.task, catalogue_of(self._project)
        leaves = [leaf.manifest for leaf in to_tree(self._task, self._catalog).leaves.values()]
        opening = Opening(self._project)
        self._parts = stack.enter_context(open_resources(opening, {each.id for each in leaves}, "sim"))
        self._simulation = self._parts.world
        self._start = self._simulation.kept()

    def trial(self, thing: str, seed: int) -> Row:
        """Run one and return its row."""
        began = time.monotonic()
        x, y, yaw = self._put(thing, seed)
        hand, referee = self._parts.arms["arm"], self._simulation.referee
        stages = Stages(lambda: hand.grasp_pose().inverse() @ referee.truth()[thing].pose)
        runner = Runner(to_tree(self._task, self._catalog), self._parts.context())
        runner.observe(stages)
        result = runner.run()
        runner.dismiss()
        held = referee.measures()[MEASURE] == 1
        stage = "" if held else stages.first or LOST
        grasp = result.data.get("grasp")
        row = {"hand": self.hand, "object": thing, "seed": seed, "held": held, "stage": stage}
        row |= {"message": str(result.failure or "")[:300], "place": [x, y, yaw], "moved": stages.moved()}
        if grasp is not None:
            row["palm"] = [*grasp.pose.position.round(3).tolist(), *grasp.pose.quaternion.round(3).tolist()]
        row["attempts"] = stages.attempts
        return {**row, "simulated": round(result.duration, 1), "wall": round(time.monotonic() - began, 1)}

    def _put(self, thing: str, seed: int) -> tuple[float, float, float]:
        rng = np.random.default_rng([seed, *thing.encode()])
        x, y, yaw = rng.uniform([0.48, -0.12, -np.pi], [0.60, 0.12, np.pi]).round(4).tolist()
        poses = np.array(self._start["poses"])
        here = poses[self.things.index(thing)]
        lying = Pose(here[:3], here[3:])
        there = Pose([x, y, lying.position[2] - FLOOR + 0.001], quaternion_of(0, 0, yaw)) @ Pose(
            quaternion=lying.quaternion
        )
        here[:] = [*there.position, *there.quaternion]
        self._simulation.put_back({**self._start, "poses": poses})
        self._simulation.settle()
        scene = self._parts.scene
        for name in scene.names():
            if not scene.fixed(name):
                scene.detach(name)
                scene.remove(name)
        return x, y, yaw


def report(rows: Iterable[Row]) -> None:
    """Print the table, what failed at which stage, and the share of each hand."""
    rows = list(rows)
    hands = [hand for hand in HANDS if any(row["hand"] == hand for row in rows)]
    fits = {(row["hand"], row["object"]) for row in rows if row["stage"] != NO_FIT}
    print(f"| object | {' | '.join(hands)} |")
    print("|---" * (len(hands) + 1) + "|")
    for thing in sorted({row["object"] for row in rows}):
        cells = []
        for hand in hands:
            mine = [row["held"] for row in rows if (row["hand"], row["object"]) == (hand, thing)]
            cells.append("" if not mine else f"{sum(mine)}/{len(mine)}" if (hand, thing) in fits else "-")
        print(f"| {thing} | {' | '.join(cells)} |")
    counted = {hand: [r for r in rows if r["hand"] == hand and (hand, r["object"]) in fits] for hand in hands}
    shares = (
        f"{sum(r['held'] for r in c)}/{len(c)} = {sum(r['held'] for r in c) / max(1, len(c)):.0%}"
        for c in counted.values()
    )
    print(f"| **held** | {' | '.join(shares)} |")
    for hand, mine in counted.items():
        why = Counter(row["stage"] for row in mine if not row["held"])
        print(f"\n{hand}, {len({r['object'] for r in mine})} objects fit; what failed: ", end="")
        print(", ".join(f"{number}x {stage}" for stage, number in why.most_common()) or "nothing")


def run_hand(hand: str, args: argparse.Namespace, rows: list[Row], file: Path) -> None:
    """Run what is missing of a hand, and append it to the rows and the file."""
    mine = [row for row in rows if row["hand"] == hand]
    done = {(row["object"], row["seed"]) for row in mine}
    misfits = {row["object"] for row in mine if row["stage"] == NO_FIT}
    wanted = [(thing, args.first + k) for k in range(args.poses) for thing in args.objects]
    left = [(thing, seed) for thing, seed in wanted if (thing, seed) not in done]
    if not left:
        return
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        bench = Bench(hand, args.objects, Path(name), stack)
        for thing, seed in left:
            if thing not in misfits:
                row = bench.trial(thing, seed)
                misfits |= {thing} if row["stage"] == NO_FIT else set()
                rows.append(row)
                with file.open("a") as out:
                    print(json.dumps(row), file=out)


def main() -> int:
    """Run what is missing, and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hands", nargs="+", choices=HANDS, default=list(HANDS))
    parser.add_argument("--objects", nargs="+", default=sorted(object_files()))
    parser.add_argument("--poses", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--report", type=Path)
    args = parser.parse_args()
    file = args.report or args.out
    if file is None:
        parser.error("give --out FILE or --report FILE")
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    if args.report is None:
        for hand in args.hands:
            run_hand(hand, args, rows, file)
    report(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
