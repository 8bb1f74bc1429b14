"""`grip demo explore` by the referee's word: registration against the truth, coverage, and grasps from one view or all.

    python benchmarks/explore.py --out rows.jsonl [--seeds 20] [--first 0] [--views registered kinematics fixed]
    python benchmarks/explore.py --report rows.jsonl

A trial is the first attempt of the task `examples/explore/tasks/explore.yaml` with one way to merge what was seen:
`registered`, `kinematics` (as it comes) or `fixed` (one view of the fixed camera). Rows are appended to the file as
trials end; a trial that is in there isn't run again.

* Registration: where the points of the heap's surface end up by a view's corrected pose, against where they end up by
  the others'; RMS over points and pairs of views [mm]. The pose that a frame says is off by a draw of the world's
  `noise`; `off` is the RMS of where the points end up against where they are.
* Coverage: the share of the heap's visible surface (what 40 exact cameras around it see of the objects) that has a
  point of the cloud within 5 mm; and the share of the cloud's points above the floor that are farther from it.
* Grasp: whether the referee sees one object held, and nothing else, when the attempt ends.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import binomtest

from grip_bt.app.project.examples import examples_folder
from grip_bt.app.runs.execute import RunOptions, Session, open_session
from grip_bt.app.wiring.equipment import Equipment
from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError
from grip_bt.base.values import Failure, Pose
from grip_bt.nodes.node import Observer
from grip_sim.specs import CameraSpec, WorldSpec
from grip_sim.world import World

TASK = examples_folder() / "explore" / "tasks" / "explore.yaml"
NEAR, FLOOR = 0.005, 0.012
VIEWPOINTS = 40
CENTRE = np.array([0.5, 0.0, 0.02])


class Referee(Observer):
    """Notes where cameras were, what was merged, and what is held at the first attempt's end; then stops the run."""

    def __init__(self, session: Session):
        self._session, self._looks = session, Counter[str]()
        self.true: list[Pose] = []
        self.said: list[Pose] = []
        self.values: dict[str, Any] = {}
        self.held: list[str] = []
        self.failure = ""

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        self.values[variable] = value

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        camera = {"attempt/explore/overview": "fixed"}.get(path, "wrist" if path.endswith("see/view/look") else "")
        if camera and failure is None:
            self._looks[camera] += 1
            spec = self._session.resources.world.spec
            noise = next(each.noise for each in spec.cameras if each.name == camera)
            self.true.append(self._session.resources.cameras[camera].info().pose)
            seed = [spec.seed, crc32(camera.encode()), self._looks[camera]]
            self.said.append(noise.on_pose(self.true[-1], seed))
        of_view = "/around/" in path  # a place that isn't reached is left out
        if failure is not None and path.startswith("attempt/") and not of_view and not self.failure:
            self.failure = f"{path.removeprefix('attempt/')}: {failure.code}"
        if path == "attempt":
            truth = self._session.resources.referee.truth()
            self.held = [name for name, seen in truth.items() if seen.status == "held"]
            self._session.runner.stop()


def visible_surface(spec: WorldSpec, places: dict[str, Pose]) -> Array:
    """Return points of what can be seen of the objects from anywhere above, a point for each 3 mm, shape (n, 3) [m]."""
    world = World(spec)
    for name, pose in places.items():
        world.move_object(name, pose)
    found = []
    for k in range(VIEWPOINTS):  # Fibonacci's spiral over the upper half of a ball
        height, angle = 0.15 + 0.84 * k / (VIEWPOINTS - 1), k * np.pi * (3 - np.sqrt(5))
        way = np.array([*(np.sqrt(1 - height**2) * np.array([np.cos(angle), np.sin(angle)])), height])
        eye = tuple(float(x) for x in CENTRE + 0.32 * way)
        camera = CameraSpec("eye", 200, 150, 1.0, eye, target=tuple(map(float, CENTRE)), renderer="raster")
        frame = world.cameras.view(camera)
        info = camera.info()
        points = info.pose.apply((info.rays() * frame.depth[..., None]).reshape(-1, 3))
        names = np.array([*frame.names, ""])
        found.append(points[np.isin(names[frame.labels.reshape(-1)], list(places))])
    points = np.concatenate(found)
    _, first = np.unique(np.floor(points / 0.003).astype(int), axis=0, return_index=True)
    return points[first]


def registration(surface: Array, true: list[Pose], said: list[Pose], corrections: list[Pose]) -> dict[str, float]:
    """Return the errors of `said` and corrected poses [mm]; see the top."""
    points = surface[:: max(1, len(surface) // 500)]

    def errors(poses: list[Pose]) -> tuple[float, float]:
        ends = np.array([(pose @ is_.inverse()).apply(points) for pose, is_ in zip(poses, true, strict=True)])
        spread = ends - ends.mean(axis=0)
        pairs = 2 * (spread**2).sum(axis=2).mean() * len(ends) / max(1, len(ends) - 1)
        return 1000 * float(np.sqrt(pairs)), 1000 * float(np.sqrt(((ends - points) ** 2).sum(axis=2).mean()))

    before, after = errors(said), errors([c @ s for c, s in zip(corrections, said, strict=True)])
    return {"before": before[0], "after": after[0], "off_before": before[1], "off_after": after[1]}


def coverage(surface: Array, cloud: Array) -> dict[str, float]:
    """Return the shares of the surface that is covered, and of the cloud that is elsewhere."""
    away, _ = cKDTree(cloud).query(surface)
    over = cloud[(cloud[:, 2] > FLOOR) & (np.abs(cloud[:, 0] - 0.5) < 0.14) & (np.abs(cloud[:, 1]) < 0.17)]
    astray, _ = cKDTree(surface).query(over)
    return {"covered": float((away < NEAR).mean()), "astray": float((astray > NEAR).mean()) if len(over) else 0.0}


def trial(views: str, seed: int, journal: Path, equipment: Equipment) -> dict[str, Any]:
    """Run one, with what the one before has left."""
    began, row = time.monotonic(), {"views": views, "seed": seed}
    try:
        options = RunOptions(seed=seed, journal=journal, data={"views": views})
        with open_session(TASK, options, equipment=equipment) as session:
            spec = session.resources.world.spec
            places = {name: seen.pose for name, seen in session.resources.referee.truth().items()}
            referee = Referee(session)
            session.runner.observe(referee)
            result = session.runner.run()
    except GripError as error:
        return {**row, "status": "error", "failure": str(error)[-500:], "held": []}
    status = "error" if result.status == "error" else "success" if len(referee.held) == 1 else "failure"
    row |= {"status": status, "held": referee.held, "failure": referee.failure, "views_taken": len(referee.true)}
    if "cloud" in referee.values and referee.values.get("clouds"):
        surface = visible_surface(spec, places)
        clouds = [np.asarray(cloud.points, float) for cloud in referee.values["clouds"]]
        merged = np.asarray(referee.values["cloud"].points, float)
        row["cover"] = {views: coverage(surface, merged)}
        if views == "registered":
            row["cover"]["kinematics"] = coverage(surface, np.concatenate(clouds))
        if views == "registered" and len(referee.values.get("corrections", ())) == len(referee.said):
            row |= registration(surface, referee.true, referee.said, referee.values["corrections"])
    return {**row, "simulated": result.duration, "wall": time.monotonic() - began, "message": str(result.error or "")}


def spread(rows: list[dict[str, Any]], key: str, factor: float = 1.0, name: str = "") -> str:
    """Return median, least and most of a measure."""
    rows = [{**row, **row["cover"][name]} for row in rows if name in row.get("cover", {})] if name else rows
    found = [factor * row[key] for row in rows if key in row]
    return f"{np.median(found):.1f} ({min(found):.1f}-{max(found):.1f})" if found else "-"


def share(number: int, total: int) -> str:
    """Return a share with Wilson's 95 % interval."""
    if not total:
        return "-"
    interval = binomtest(number, total).proportion_ci(method="wilson")
    return f"{number}/{total} = {number / total:.0%} ({interval.low:.0%}-{interval.high:.0%})"


def report(rows: list[dict[str, Any]]) -> None:
    """Print the tables."""
    print("| cloud | surface covered [%] | points astray [%] | taken at the first attempt |")
    print("|---|---|---|---|")
    for views in ("fixed", "kinematics", "registered"):
        mine = [row for row in rows if row["views"] == views]
        good = sum(row["status"] == "success" for row in mine)
        covered, astray = (spread(rows, key, 100, views) for key in ("covered", "astray"))
        print(f"| {views} | {covered} | {astray} | {share(good, len(mine))} |")
    known = [row for row in rows if "after" in row]
    print("\n| registration, RMS [mm] | by kinematics | registered |\n|---|---|---|")
    print(f"| between views | {spread(known, 'before')} | {spread(known, 'after')} |")
    print(f"| from the truth | {spread(known, 'off_before')} | {spread(known, 'off_after')} |")
    for views in sorted({row["views"] for row in rows}):
        why = Counter(r["failure"] or "not held" for r in rows if r["views"] == views and r["status"] != "success")
        print(f"\n{views}: " + (", ".join(f"{n}x {reason}" for reason, n in why.most_common(6)) or "none failed"))


def main() -> int:
    """Run what is missing, and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--views", nargs="+", default=["registered", "fixed", "kinematics"])
    parser.add_argument("--out", type=Path)
    parser.add_argument("--report", type=Path)
    args = parser.parse_args()
    file = args.report or args.out
    if file is None:
        parser.error("give --out FILE or --report FILE")
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["views"], row["seed"]) for row in rows}
    todo = [(v, s) for s in range(args.first, args.first + args.seeds) for v in args.views if (v, s) not in done]
    if args.report is None:
        equipment = Equipment(lasting=True)
        for views, seed in todo:
            row = trial(views, seed, file.with_suffix(".sqlite"), equipment)
            if row["status"] == "error":
                equipment.close()
                equipment = Equipment(lasting=True)
            rows.append(row)
            with file.open("a") as out:
                print(json.dumps(row), file=out)
        equipment.close()
    report(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
