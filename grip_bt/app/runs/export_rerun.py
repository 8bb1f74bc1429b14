"""A run of the journal as a recording for the Rerun viewer: the robot as it moved, the scene, and what nodes did."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.base.values import DepthImage, Grasp, Image, PointCloud, Pose, RgbdFrame
from grip_bt.runtime import Event, JournalReader, RunRecord

from .motion_record import moments, motion_file

_AXIS = 0.05
"""Length of the axes of a pose [m]."""
_GREY, _OWN = (150, 150, 150), (225, 170, 40)
"""Of what never moves, and of other objects."""


@contextmanager
def write_rerun(reader: JournalReader, record: RunRecord, file: Path) -> Iterator[Callable[[Event], object]]:
    """Write a run to a `.rrd` file; the time line `run` is the run's own clock.

    Entities: `world/robot/LINK`, `world/scene/OBJECT`, `world/data/VARIABLE` (poses, grasps, clouds), `data/VARIABLE`
    (images, numbers, everything else as text), `nodes/PATH` (lanes of a state time line), `log`.

    Raises:
        MissingPartError: `rerun` isn't installed.
    """
    import rerun as rr  # of the extra `rerun`

    stream = rr.RecordingStream("grip", recording_id=record.id)
    stream.save(file)
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    stream.log("task", rr.TextDocument(f"```yaml\n{record.task_text}\n```", media_type="text/markdown"), static=True)
    with suppress(GripError, ImportError, OSError):  # without its robot, or its motion, the rest is worth a look
        _robot(rr, stream, record, motion_file(reader.file, record.id))
    yield partial(_event, rr, stream, reader)
    stream.flush()
    stream.disconnect()


def _event(rr: Any, stream: Any, reader: JournalReader, event: Event) -> None:
    stream.set_time("run", duration=event.t)
    words = [
        event.event,
        event.outcome,
        event.code,
        *(str(event.data[k]) for k in ("text", "message") if k in event.data),
    ]
    level = "ERROR" if event.event == "error" else "WARN" if event.meaning == "failure" else "INFO"
    stream.log("log", rr.TextLog(f"{event.path}: {' '.join(filter(None, words))}", level=level))
    lane = "nodes/" + (event.path.strip("/") or "task")
    if event.event == "enter":
        stream.log(lane, rr.StateChange(state="running"))
    elif event.outcome is not None or event.event == "interrupted":
        stream.log(lane, rr.StateChange(state=event.outcome or "interrupted"))
    elif event.event == "write":
        with suppress(GripError):  # a value that wasn't kept
            _value(rr, stream, str(event.data["variable"]), reader.value(event))


def _value(rr: Any, stream: Any, name: str, value: Any) -> None:
    match value:
        case Pose():
            stream.log(f"world/data/{name}", *_placed(rr, value), rr.TransformAxes3D(_AXIS))
        case Grasp():
            _value(rr, stream, name, [value])
        case [Grasp(), *_]:
            ways = [(grasp.pre_grasp.position, grasp.pose.position) for grasp in value]
            starts, ends = (np.array(each) for each in zip(*ways, strict=True))
            stream.log(f"world/data/{name}", rr.Arrows3D(origins=starts, vectors=ends - starts))
        case PointCloud():
            stream.log(f"world/data/{name}", rr.Points3D(value.points, colors=value.colors, radii=0.001))
        case RgbdFrame():
            _value(rr, stream, f"{name}/image", value.image)
            _value(rr, stream, f"{name}/depth", value.depth)
        case Image():
            stream.log(f"data/{name}", rr.Image(value.pixels))
        case DepthImage():
            stream.log(f"data/{name}", rr.DepthImage(value.depth, meter=1.0))
        case bool() | int() | float():
            stream.log(f"data/{name}", rr.Scalars(float(value)))
        case _:
            stream.log(f"data/{name}", rr.TextDocument(str(value)[:2000]))


def _placed(rr: Any, pose: Pose) -> tuple[Any, ...]:
    w, x, y, z = map(float, pose.quaternion)
    return (rr.Transform3D(translation=pose.position, quaternion=rr.Quaternion(xyzw=(x, y, z, w))),)


def _robot(rr: Any, stream: Any, record: RunRecord, motion: Path) -> None:
    """Write what the robot looks like, and how it and the scene were at each time."""
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_sim.cameras.looks import visuals_of

    model = RobotModel(find_project(record.task_path).description())
    for link, looks in visuals_of(model.description.urdf).items():
        with suppress(GripError, OSError):  # a mesh that can't be read
            for number, look in enumerate(looks()):
                colour = None if look.colour is None else (*look.colour, 255)
                shape = rr.Mesh3D(
                    vertex_positions=look.points, triangle_indices=look.triangles, albedo_factor=colour or _GREY
                )
                stream.log(f"world/robot/{link}/{number}", shape, static=True)
    there: set[str] = set()
    for moment in moments(motion, model):
        stream.set_time("run", duration=moment.t)
        for link, pose in moment.links.items():
            stream.log(f"world/robot/{link}", *_placed(rr, pose))
        if moment.scene is not None:
            for name in there - set(moment.scene):
                stream.log(f"world/scene/{name}", rr.Clear(recursive=True))
            there = set(moment.scene)
            for name, thing in moment.scene.items():
                pose = Pose(thing["at"][:3], thing["at"][3:])
                stream.log(f"world/scene/{name}", *_placed(rr, pose), _shape(rr, thing, moment.bodies))


def _shape(rr: Any, thing: Mapping[str, Any], bodies: Mapping[str, Mapping[str, str]]) -> Any:
    colour, size = _GREY if thing["fixed"] else _OWN, thing["size"]
    match thing["kind"]:
        case "box":
            return rr.Boxes3D(sizes=[size], colors=[colour], fill_mode="solid")
        case "cylinder":
            return rr.Cylinders3D(radii=[size[0]], lengths=[size[1]], colors=[colour], fill_mode="solid")
        case "sphere":
            return rr.Ellipsoids3D(radii=[size[0]], colors=[colour], fill_mode="solid")
    body = bodies[thing["body"]]
    points = np.frombuffer(base64.b64decode(body["points"]), "<f4").reshape(-1, 3)
    if thing["kind"] == "cells":
        return rr.Boxes3D(centers=points, half_sizes=np.full((len(points), 3), size[0] / 2), colors=[colour])
    triangles = np.frombuffer(base64.b64decode(body["triangles"]), "<u4").reshape(-1, 3)
    return rr.Mesh3D(vertex_positions=points, triangle_indices=triangles, albedo_factor=(*colour, 255))
