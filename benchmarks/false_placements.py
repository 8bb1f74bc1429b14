"""Drops objects at random moments of a pick and tells what the task believed, with the referee's word beside it.

    python benchmarks/false_placements.py --trials 200 --out trials.jsonl [--robot NAME] [--as bt|sm] [--first SEED]
    python benchmarks/false_placements.py --report trials.jsonl

A trial is one attempt of `examples/tasks/reactive_pick.yaml`: look, choose, take, look again, check, place. The trial's
seed decides the table, the moment and the kind of the drop. One simulator serves all trials of a run: the robot is put
back to where it began, and the objects to where the seed has them. Rows are appended to the file as trials end; a seed
that is in there isn't run again. Exit status 0 when no trial placed what the hand didn't hold.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import sys
import tempfile
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import find_project
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening
from grip_bt.base.values import Failure, Grasp, JointState, Pose
from grip_bt.compilers import to_machine, to_tree
from grip_bt.nodes.node import Observer
from grip_bt.runtime import Runner
from grip_bt.task import read_text
from grip_bt.task.model import Task
from grip_sim.worlds import load_world

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
PHASES = ("none", "closing", "lifting", "showing", "carrying", "over the crate")
KINDS = ("opened", "slack", "taken in view", "taken out of view")
STEP = 0.04
"""How often the moment of a drop is looked for [s of simulated time]."""
PROVIDER = """
import numpy as np
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.objects import SEEN
from grip_bt.base.values import Grasp, Pose


class TopGrasps(Leaf):
    '''Grasps of seen boxes from above, for grippers: the fingers across the box's sides.'''

    def update(self):
        scene, grasps = self.context.scene(), []
        for name in scene.names():
            if name.startswith(SEEN):
                size, pose = scene.box(name)
                for k in range(4):
                    x = pose.rotation() @ [np.cos(k * np.pi / 2), np.sin(k * np.pi / 2), 0]
                    down = np.array([0.0, 0.0, -1.0])
                    for turned in (np.stack([x, np.cross(down, x), down], axis=1),):
                        at = np.eye(4)
                        at[:3, :3], at[:3, 3] = turned, [*pose.position[:2], pose.position[2] + size[2] / 2 - 0.03]
                        here = Pose.from_matrix(at)
                        up = here.moved([0, 0, 0.12])
                        grasps.append(Grasp(here, up, here.moved([0, 0, 0.2]), width=float(min(size[:2])), quality=-k))
        return self.end(grasps=grasps)
"""
MANIFEST = """
id: trial/top_grasps
doc: Grasps from above.
implementation: top_grasps.py:TopGrasps
outputs:
  grasps: {type: "list[Grasp]", doc: candidates}
outcomes: {success: success}
"""


class Dropper(Observer):
    """Has the object that is being taken dropped, once, in one phase of the attempt; and keeps what was said and true.

    Args:
        session: the trial's simulation, hand and so on.
        phase: one of `PHASES`.
        kind: one of `KINDS`.
        part: 0..1, when in the phase.
        rng: for places.
    """

    BEGINS = {"pick/close": "closing", "pick/lift": "lifting", "pick/show": "showing", "place/put": "carrying"}
    LASTS = {"closing": 1.2, "lifting": 1.5, "showing": 2.5, "carrying": 2.5, "over the crate": 1.5}

    def __init__(self, session: Session, phase: str, kind: str, part: float, rng: np.random.Generator):
        self._session, self._phase, self._kind, self._part, self._rng = session, phase, kind, part, rng
        self.target: str | None = None
        self.dropped_at: float | None = None
        self.row: dict[str, Any] = {"check": None, "held": None, "place": None, "why": ""}
        self._leaf: str | None = None
        self._armed = False
        self._from: np.ndarray | None = None

    def entered(self, path: str) -> None:
        self._leaf = path
        if path == "check/held":
            self.row["held"] = self._held()
        begins = self.BEGINS.get(path)
        wanted = "carrying" if self._phase == "over the crate" else self._phase
        if begins == wanted and self.target is not None:
            self._from = self._place()
            self._armed = True
            self._wait(self._part * self.LASTS[begins] if begins != "carrying" else STEP)

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        if isinstance(value, Grasp):
            point = value.pose.position + value.pose.rotation()[:, 2] * 0.04
            truth = self._session.truth()
            self.target = min(truth, key=lambda n: float(np.linalg.norm(truth[n].pose.position[:2] - point[:2])))

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        if path in self.BEGINS and self.BEGINS[path] == ("carrying" if "crate" in self._phase else self._phase):
            self._armed = False
        if path in ("check/held", "place/put"):
            self.row["check" if path == "check/held" else "place"] = outcome == "success"
            if failure is not None:
                self.row["why"] = f"{failure.code}: {failure.message}"
        elif failure is not None and not self.row["why"]:
            self.row["why"] = f"{path}: {failure.code}"

    def _held(self) -> bool:
        return self.target is not None and self._session.truth()[self.target].status == "held"

    def _place(self) -> np.ndarray:
        return np.array(self._session.truth()[self.target].pose.position)

    def _wait(self, seconds: float) -> None:
        self._session.after(seconds, self._moment)

    def _moment(self) -> None:
        """In a thread of the simulator's client: drop, or wait for the moment."""
        if not self._armed or self.dropped_at is not None:
            return
        if self._phase in ("carrying", "over the crate"):
            here = self._place()
            over = self._session.crate_holds(here)
            if self._phase == "over the crate" and not over:
                return self._wait(STEP)
            if self._phase == "carrying" and np.linalg.norm(here - self._from) < 0.03:
                return self._wait(STEP)
            if self._from is not None and self._part > 0:
                part, self._part = self._part, 0.0
                return self._wait(max(STEP, part * self.LASTS[self._phase]))
        held = self._held()
        if self._phase in ("carrying", "over the crate") and not held:
            return None  # let go already: it can't be dropped any more
        self.dropped_at = self._session.clock.simulated
        self.row["held_when_dropped"] = held
        self._session.drop(self.target, self._kind, self._rng)


class Session:
    """One simulated robot, and a task that is one attempt, for many trials."""

    def __init__(self, stack: ExitStack, robot: str, form: str):
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "project"
        shutil.copytree(EXAMPLES, folder, ignore=shutil.ignore_patterns(".grip", "__pycache__"))
        settings = (folder / "grip.yaml").read_text().replace("panda_allegro", robot)
        self._grips = "allegro" not in robot and "shadow" not in robot
        (folder / "grip.yaml").write_text(settings)
        if self._grips:
            (folder / "nodes" / "top_grasps").mkdir()
            (folder / "nodes" / "top_grasps" / "top_grasps.py").write_text(PROVIDER)
            (folder / "nodes" / "top_grasps" / "manifest.yaml").write_text(MANIFEST)
        self.task = one_attempt(folder / "tasks" / "reactive_pick.yaml", self._grips)
        self._compile = to_machine if form == "sm" else to_tree
        project = find_project(folder / "tasks" / "reactive_pick.yaml")
        self._catalog = catalogue_of(project)
        needs = {leaf.manifest.id for leaf in self._compile(self.task, self._catalog).leaves.values()}
        self.resources = stack.enter_context(open_resources(Opening(project), needs, "sim"))
        self.simulation = self.resources.world
        self.clock = self.simulation.clock
        self._begin = self.simulation.kept()
        self._scene = self.resources.scene.snapshot()
        self._hand = self.simulation.hand("hand")
        self._closed: JointState | None = None

    def truth(self) -> dict[str, Any]:
        return self.simulation.referee.truth()

    def crate_holds(self, place: np.ndarray) -> bool:
        return self.simulation.spec.crate.holds(tuple(place))

    def after(self, seconds: float, then: Any) -> None:
        """Call when so much simulated time has passed; time passes for it also while nothing moves."""
        wait = self.simulation.move("wait", seconds=seconds)
        wait.add_done_callback(then)

    def drop(self, name: str, kind: str, rng: np.random.Generator) -> None:
        """Have the hand lose an object."""
        if kind in ("opened", "slack"):
            hand = self.resources.hands["right_hand"]
            closing = hand.closing()
            goal = closing.goal if closing is not None else hand.named_states()["closed"]
            away = hand.named_states()["open"] if kind == "opened" else goal
            self._hand.move(away, 0.25, None if kind == "opened" else 0.005)
            self.after(0.6, lambda: self._hand.move(goal, 0.4, 0.7 if not self._grips else None))
            return
        spec = next(o for o in self.simulation.spec.objects if o.name == name)
        if kind == "taken in view":
            others = [t.pose.position[:2] for t in self.truth().values()]
            for _ in range(200):
                spot = rng.uniform((0.40, -0.10), (0.68, 0.36))
                if all(np.linalg.norm(spot - other) > 0.14 for other in others):
                    break
            pose = Pose([*spot, spec.height / 2])
        elif rng.random() < 0.5:
            pose = Pose([*rng.uniform((0.35, 0.565), (0.9, 0.59)), spec.height / 2])  # on the table, beside the view
        else:
            pose = Pose([1.5, 0.5, -1.0])  # on its way to the floor
        self.simulation.referee.move_object(name, pose)

    def trial(self, seed: int, phase: str | None, kind: str | None) -> dict[str, Any]:
        """Run one trial."""
        rng = np.random.default_rng([seed, 13])
        phase = phase or str(rng.choice(PHASES, p=[0.16, 0.16, 0.17, 0.17, 0.17, 0.17]))
        kind = kind or str(rng.choice(KINDS))
        if phase == "closing":
            kind = str(rng.choice(KINDS[2:]))
        self._reset(seed)
        began, simulated = time.process_time(), self.clock.simulated
        compiled = self._compile(self.task, self._catalog)
        dropper = Dropper(self, phase, kind, float(rng.uniform(0.02, 1.0)), rng)
        runner = Runner(compiled, self.resources.context())
        runner.observe(dropper)
        wall = time.monotonic()
        result = runner.run()
        dropper._armed = False
        self.simulation.settle(0.5)
        truth = {name: state.status for name, state in self.truth().items()}
        row = dropper.row
        return {
            "seed": seed,
            "phase": phase,
            "kind": kind if phase != "none" else "",
            "dropped": dropper.dropped_at is not None,
            "target": dropper.target,
            "status": result.status,
            "outcome": result.outcome,
            **row,
            "placed": dropper.target is not None and truth[dropper.target] == "placed",
            "truth": truth,
            "simulated": round(self.clock.simulated - simulated, 2),
            "wall": round(time.monotonic() - wall, 2),
            "own_cpu": round(time.process_time() - began, 2),
            "error": str(result.error or ""),
        }

    def _reset(self, seed: int) -> None:
        self.simulation.settle(0.7)  # a hand that went slack just now presses again
        self._hand.stop()
        self.simulation.settle(0.5)
        self.simulation.put_back(self._begin)
        for mine, its in zip(self.simulation.spec.objects, load_world("table", seed).objects, strict=True):
            turn = [np.cos(its.yaw / 2), 0, 0, np.sin(its.yaw / 2)]
            self.simulation.referee.move_object(mine.name, Pose([*its.position[:2], mine.height / 2], turn))
        self.simulation.settle(0.3)
        self.resources.scene.restore(self._scene)


def one_attempt(file: Path, grips: bool) -> Task:
    """Return the task whose root is one attempt of the example."""
    data = yaml.safe_load(re.sub(r"\bon:", "'on':", file.read_text()))  # YAML 1.1 takes a bare `on` for a truth value
    attempt = data["root"]["children"]["next_object"]["child"]["attempt"]
    if grips:
        children = attempt["children"]
        children["propose"] = {"node": "trial/top_grasps", "out": {"grasps": "grasps"}}
    data["root"] = {**attempt, "on": {"nothing_left": "cleared", "success": "cleared", "failure": "gave_up"}}
    return read_text(yaml.safe_dump(data, sort_keys=False), str(file)).task


def report(rows: list[dict[str, Any]]) -> str:
    """Return the tables."""
    lines = []
    for said, true, no in (("check", "held", "lost"), ("place", "placed", "not there")):
        cells = (f"said {true}, is {true}", f"said {true}, is {no}", f"said lost, is {true}", f"said lost, is {no}")
        lines += ["| drop | trials | " + " | ".join((*cells, "ended before")) + " |", "|" + "---|" * 7]
        lines += [_line(name, [r for r in rows if r["phase"] == name], said, true) for name in PHASES]
        lines += [_line("all", rows, said, true), ""]
    kinds = Counter(r["kind"] for r in rows if r["dropped"])
    false = [r["seed"] for r in rows if r["place"] and not r["placed"]]
    how = ", ".join(f"{n} {kind}" for kind, n in kinds.items())
    lines.append(f"{len(rows)} trials, {sum(r['dropped'] for r in rows)} drops ({how});")
    lines.append(f"false placements: {len(false)}{' at seeds ' + ', '.join(map(str, false)) if false else ''}")
    return "\n".join(lines)


def _line(name: str, rows: list[dict[str, Any]], said: str, true: str) -> str:
    counts = Counter((r[said], bool(r[true])) for r in rows)
    cells = [counts[True, True], counts[True, False], counts[False, True], counts[False, False]]
    ended = counts[None, True] + counts[None, False]
    return f"| {name} | {len(rows)} | " + " | ".join(map(str, [*cells, ended])) + " |"


def main() -> int:
    """Run trials, or print a report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--report", type=Path)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--robot", default="panda_allegro")
    parser.add_argument("--as", dest="form", choices=("bt", "sm"), default="bt")
    parser.add_argument("--phase", choices=PHASES)
    parser.add_argument("--kind", choices=KINDS)
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    if args.report:
        rows = [json.loads(line) for line in args.report.read_text().splitlines()]
        print(report(rows))
        return int(any(r["place"] and not r["placed"] for r in rows))
    rows = []
    if args.out and args.out.exists():
        rows = [json.loads(line) for line in args.out.read_text().splitlines()]
    done = {row["seed"] for row in rows}
    with ExitStack() as stack:
        session = Session(stack, args.robot, args.form)
        for seed in range(args.first, args.first + args.trials):
            if seed in done:
                continue
            row = {"robot": args.robot, "form": args.form, **session.trial(seed, args.phase, args.kind)}
            rows.append(row)
            print(json.dumps(row), flush=True)
            if args.out:
                with args.out.open("a") as file:
                    file.write(json.dumps(row) + "\n")
    print(report(rows))
    return int(any(r["place"] and not r["placed"] for r in rows))


if __name__ == "__main__":
    sys.exit(main())
