"""What a run's robot and scene did, for drawing it: positions of joints, ten times a second while they change.

It lies beside the journal, in `motion/RUN.jsonl`, one object a line: first `parts` (part -> its joints), then whatever
has changed at the time `t` of the run's clock [s]: `q` (part -> positions [rad or m]), `way` (arm -> positions that it
is to go through; none when it is over), `plans` (arm -> the ways that are planned and not begun), `touch` (hand ->
link -> contact force [N]), `press` (hand -> `ContactPoint`s), `scene` (all objects), `bodies` (new ones, see `Bodies`).
It is no part of the journal: it is thinned out, and nothing is decided by it.
"""

from __future__ import annotations

import hashlib
import json
import threading
from base64 import b64encode
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grip_bt.app.wiring.parts import Resources
from grip_bt.base.errors import GripError
from grip_bt.base.ports import Arm, Clock, Hand, TouchPoints
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.base.values.solids import Box, CellMap, Cylinder, Mesh, Solid, Sphere
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot

if TYPE_CHECKING:
    from grip_bt.commanders.kinematics.model import RobotModel

FOLDER = "motion"
PERIOD = 0.1
"""Sampling interval [s]."""
MOVED = 2e-4
"""Smaller changes aren't recorded [rad or m]."""
WAY_POINTS = 32
"""Points by which the path of a motion is recorded."""
LARGEST = 1 << 26
"""Largest size of a file [bytes]: about an hour of constant motion."""
KEPT = 50
"""How many runs' files are kept, the newest ones."""


def motion_file(journal: Path, run: str) -> Path:
    """Return where the motion of a run is kept, beside its journal."""
    return journal.parent / FOLDER / f"{run}.jsonl"


@dataclass(frozen=True)
class Moment:
    """What has changed at a time.

    Attributes:
        t: on the run's clock [s].
        links: link -> its pose in world; empty where no joint moved.
        scene: all objects as `scene` lines have them, where any changed.
        bodies: all that were told so far.
    """

    t: float
    links: Mapping[str, Pose]
    scene: Mapping[str, Any] | None
    bodies: Mapping[str, Mapping[str, str]]


def moments(motion: Path, model: RobotModel) -> Iterator[Moment]:
    """Read how a robot and its scene moved. Raises OSError: there is no such file."""
    joints, state, bodies = dict[str, list[str]](), dict[str, float](), dict[str, Mapping[str, str]]()
    for line in map(json.loads, motion.read_text(encoding="utf-8").splitlines()):
        joints |= line.get("parts", {})
        bodies |= line.get("bodies", {})
        links: Mapping[str, Pose] = {}
        if "q" in line:
            state |= {n: q for part, at in line["q"].items() for n, q in zip(joints[part], at, strict=True)}
            known = {name: q for name, q in state.items() if model.model.existJointName(name)}
            links = model.link_poses(JointState.from_mapping(known))
        if "t" in line:
            yield Moment(line["t"], links, line.get("scene"), dict(bodies))


@contextmanager
def recorded_motion(resources: Resources, clock: Clock, journal: Path, run: str) -> Iterator[None]:
    """Record beside the journal while the block runs; does nothing for a run without a robot."""
    if not resources.arms and not resources.hands:
        yield
        return
    over = threading.Event()
    recorder = threading.Thread(
        target=_record, args=(resources, clock, motion_file(journal, run), over), name="grip_motion", daemon=True
    )
    recorder.start()
    try:
        yield
    finally:
        over.set()
        recorder.join(2.0)


def _record(resources: Resources, clock: Clock, file: Path, over: threading.Event) -> None:
    hands = resources.hands
    parts: dict[str, Arm | Hand] = {**hands, **resources.arms}
    # A robot that is lost, or a full disk, is told by the run itself; the drawing just ends.
    with suppress(GripError, OSError, TimeoutError):
        file.parent.mkdir(parents=True, exist_ok=True)
        _thin_out(file.parent)
        with file.open("a", encoding="utf-8") as out:
            out.write(json.dumps({"parts": {name: part.state().names for name, part in parts.items()}}) + "\n")
            told, bodies, ways, felt = dict[str, Any](), Bodies(), _Ways(), dict[str, Any]()
            scene: SceneSnapshot | None = None
            while True:
                last, line, t = over.is_set(), dict[str, Any](), clock.now()
                now_at = {name: part.state().position for name, part in parts.items()}
                if moved := {name: p for name, p in now_at.items() if _changed(p, told.get(name))}:
                    told |= moved
                    line["q"] = {name: np.round(position, 4).tolist() for name, position in moved.items()}
                line |= ways.new(resources.arms)
                touch = {hand: {link: round(f, 1) for link, f in it.contacts().items()} for hand, it in hands.items()}
                press = {hand: _pressing(hands[hand]) for hand, links in touch.items() if links}
                for key, news in {"touch": touch, "press": press}.items():
                    if news != felt.get(key, {}):
                        felt[key] = line[key] = news
                now = resources.scene.snapshot() if resources.scene is not None else None
                if isinstance(now, SceneSnapshot) and now is not scene:
                    scene, line["scene"] = now, {n: _object(item, bodies) for n, item in now.objects.items()}
                    if new := bodies.new():
                        line["bodies"] = new
                if line:
                    out.write(json.dumps({"t": round(t, 3), **line}, separators=(",", ":")) + "\n")
                    out.flush()
                if last or out.tell() > LARGEST:
                    return
                over.wait(PERIOD)


class _Ways:
    """What arms follow and have planned, as far as it was told."""

    def __init__(self) -> None:
        self._ways, self._plans = dict[str, tuple[Any, bool]](), dict[str, tuple[Trajectory, ...]]()

    def new(self, arms: Mapping[str, Arm]) -> dict[str, Any]:
        """Return what has changed, as `way` and `plans` of a line."""
        found: dict[str, dict[str, Any]] = {}
        for name, arm in arms.items():
            way, moving, plans = arm.ways
            told, over = self._ways.get(name, (None, True))
            if way is not None and way is not told:
                self._ways[name] = way, False
                found.setdefault("way", {})[name] = _points(way, arm)
            elif not over and not moving:
                self._ways[name] = way, True
                found.setdefault("way", {})[name] = []
            if plans is not self._plans.setdefault(name, ()):
                self._plans[name] = plans
                found.setdefault("plans", {})[name] = [_points(each, arm) for each in plans]
        return found


def _pressing(hand: Hand) -> list[list[Any]]:
    points = hand.contact_points() if isinstance(hand, TouchPoints) else ()
    found = [[link, other, np.round(at, 4).tolist(), np.round(force, 1).tolist()] for link, other, at, force in points]
    return [each for each in found if any(each[3])]


def _points(way: Trajectory, part: Arm | Hand) -> list[list[float]]:
    rows, _, _ = way.of(part.state().names).sampled(np.linspace(0.0, way.duration, WAY_POINTS))
    return np.round(rows, 4).tolist()  # type: ignore[no-any-return]


def _changed(now: Any, before: Any) -> bool:
    return before is None or len(now) != len(before) or bool(np.abs(now - before).max(initial=0.0) > MOVED)


def _object(item: SceneObject, bodies: Bodies) -> dict[str, object]:
    place = {"at": _place(item.pose, item.shape), "hand": item.hand, "fixed": item.fixed}
    match item.shape:
        case Box(size=size):
            return {"kind": "box", "size": _rounded(size), **place}
        case Cylinder(radius=radius, height=height):
            return {"kind": "cylinder", "size": _rounded((radius, height)), **place}
        case Sphere(radius=radius):
            return {"kind": "sphere", "size": _rounded((radius,)), **place}
        case shape:
            return {**bodies.shape(shape), **place}


def _place(pose: Pose, shape: Solid) -> list[float]:
    """Return x y z [m], then the quaternion w x y z, of a shape's middle; of a mesh's and of cells' origin."""
    if isinstance(shape, Mesh | CellMap):
        return _rounded((*pose.position, *pose.quaternion))
    middle = pose.position + pose.rotation() @ np.asarray(shape.centre())
    return _rounded((*middle, *pose.quaternion))


def _rounded(numbers: Any) -> list[float]:
    return [round(float(number), 5) for number in numbers]


def _thin_out(folder: Path) -> None:
    files = sorted(folder.glob("*.jsonl"), key=lambda file: file.stat().st_mtime)
    for file in files[:-KEPT]:
        file.unlink(missing_ok=True)


FINE = 1500
"""Meshes with more triangles than this are made coarser."""
CUTS = 36
"""Into how many cells the longest side of such a mesh is cut: what lies in one cell becomes one point."""
MOST_CELLS = 4000
"""Maps with more cells get cells of twice the size, until they are few enough."""


def coarse(points: NDArray[Any], triangles: NDArray[Any]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return points and triangles of a surface; of a fine one, the points of each cell as one (vertex clustering).

    Source: Rossignac and Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993.
    """
    triangles = np.asarray(triangles, dtype=np.int64)
    if len(triangles) <= FINE:
        return points, triangles
    cell = max(float(np.ptp(points, axis=0).max()) / CUTS, 1e-6)
    keys = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    _, which = np.unique(keys, axis=0, return_inverse=True)
    which = which.reshape(-1)
    count = np.bincount(which)
    merged = np.stack([np.bincount(which, points[:, axis]) / count for axis in range(3)], axis=1)
    moved = which[triangles]
    kept = moved[(moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 0] != moved[:, 2])]
    return merged, np.unique(kept, axis=0)


def few_cells(cells: CellMap) -> CellMap:
    """Return a map of at most `MOST_CELLS` cells that covers what the other one covers."""
    while len(cells.cells) > MOST_CELLS:
        cells = CellMap(np.floor_divide(cells.cells, 2), 2 * cells.resolution)
    return cells


class Bodies:
    """Gives each body a name by what it looks like, and tells those that are new."""

    def __init__(self) -> None:
        self._told: set[str] = set()
        self._new: dict[str, dict[str, str]] = {}

    def shape(self, shape: Mesh | CellMap) -> dict[str, Any]:
        """Return what an object of this shape is in the record: `kind`, `size`, `body`."""
        if isinstance(shape, CellMap):
            few = few_cells(shape)
            return {"kind": "cells", "size": [few.resolution], "body": self._name(few.middles(), None)}
        from grip_bt.commanders.kinematics.shapes import surface_of  # a second that only a scene with a mesh needs

        points, triangles = coarse(*surface_of(shape))
        size = [round(side, 5) for side in shape.extents()]
        return {"kind": "mesh", "size": size, "body": self._name(points, triangles)}

    def new(self) -> dict[str, dict[str, str]]:
        """Return the bodies that weren't told before: name -> `points` and `triangles`, each in base64.

        Points are float32 x y z [m] in the object's own frame; triangles uint32, three points each, none for cells.
        """
        new, self._new = self._new, {}
        return new

    def _name(self, points: NDArray[Any], triangles: NDArray[Any] | None) -> str:
        rows = np.ascontiguousarray(points, dtype="<f4").tobytes()
        corners = b"" if triangles is None else np.ascontiguousarray(triangles, dtype="<u4").tobytes()
        name = hashlib.sha256(rows + b"|" + corners).hexdigest()[:16]
        if name not in self._told:
            self._told.add(name)
            self._new[name] = {"points": b64encode(rows).decode(), "triangles": b64encode(corners).decode()}
        return name
