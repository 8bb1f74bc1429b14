"""What a run's robot and scene did, for drawing it: positions of joints, ten times a second while they change.

It lies beside the journal, in `motion/RUN.jsonl`, one object a line: first `parts` (part -> its joints), then whatever
has changed at the time `t` of the run's clock [s]: `q` (part -> positions [rad or m]), `scene` (all objects), `bodies`
(new ones, see `motion_bodies`). It is no part of the journal: it is thinned out, and nothing is decided by it.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from grip_bt.base.errors import GripError
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box, CellMap, Cylinder, Mesh, Solid, Sphere

from .motion_bodies import Bodies

if TYPE_CHECKING:
    from grip_bt.base.ports import Arm, Clock, Hand

    from .resources import Resources

FOLDER = "motion"
PERIOD = 0.1
"""How often is looked [s]."""
MOVED = 2e-4
"""What changes less isn't told [rad or m]."""
LARGEST = 1 << 26
"""Where a file ends [bytes]: at full tilt after about an hour."""
KEPT = 50
"""How many runs' files are kept, the newest ones."""


def motion_file(journal: Path, run: str) -> Path:
    """Return where the motion of a run is kept, beside its journal."""
    return journal.parent / FOLDER / f"{run}.jsonl"


@contextmanager
def recorded_motion(resources: Resources, clock: Clock, journal: Path, run: str) -> Iterator[None]:
    """Record while the block runs; does nothing for a run without a robot.

    Args:
        resources: whose arms, hands and scene.
        clock: the run's.
        journal: beside which the file goes.
        run: the run's id.
    """
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
    parts: dict[str, Arm | Hand] = {**resources.hands, **resources.arms}
    # A robot that is lost, or a full disk, is told by the run itself; the drawing just ends.
    with suppress(GripError, OSError, TimeoutError):
        file.parent.mkdir(parents=True, exist_ok=True)
        _thin_out(file.parent)
        with file.open("a", encoding="utf-8") as out:
            states = {name: part.state() for name, part in parts.items()}
            out.write(json.dumps({"parts": {name: list(state.names) for name, state in states.items()}}) + "\n")
            told: dict[str, Any] = {}
            scene: Any = None
            bodies = Bodies()
            while True:
                last = over.is_set()
                line: dict[str, Any] = {}
                moved = {
                    name: p for name, part in parts.items() if _changed(p := part.state().position, told.get(name))
                }
                if moved:
                    told |= moved
                    line["q"] = {name: np.round(position, 4).tolist() for name, position in moved.items()}
                now = resources.scene.snapshot() if resources.scene is not None else None
                if now is not None and now is not scene:
                    scene, line["scene"] = now, _objects(now.objects, bodies)
                    if new := bodies.new():
                        line["bodies"] = new
                if line:
                    out.write(json.dumps({"t": round(clock.now(), 3), **line}, separators=(",", ":")) + "\n")
                    out.flush()
                if last or out.tell() > LARGEST:
                    return
                over.wait(PERIOD)


def _changed(now: Any, before: Any) -> bool:
    return before is None or len(now) != len(before) or bool(np.abs(now - before).max(initial=0.0) > MOVED)


def _objects(objects: Mapping[str, Any], bodies: Bodies) -> dict[str, Any]:
    return {
        name: {
            **_shape(item.shape, bodies),
            "at": _place(item.pose, item.shape),
            "hand": item.hand,
            "fixed": item.fixed,
        }
        for name, item in objects.items()
    }


def _shape(shape: Solid, bodies: Bodies) -> dict[str, Any]:
    match shape:
        case Box():
            return {"kind": "box", "size": _rounded(shape.size)}
        case Cylinder():
            return {"kind": "cylinder", "size": _rounded((shape.radius, shape.height))}
        case Sphere():
            return {"kind": "sphere", "size": _rounded((shape.radius,))}
        case Mesh() | CellMap():
            return bodies.shape(shape)


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
