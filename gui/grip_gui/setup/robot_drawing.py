"""What a project's robot looks like: its tree of joints, and shapes of links in few triangles.

Where the joints are is told apart from it; the page does the forward kinematics, so that a moment of a run is a handful
of numbers.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, fromstring

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from grip_bt.app.runs.motion_record import coarse
from grip_bt.base.errors import GripError, InvalidRobotError
from grip_bt.base.values import Pose
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.file_cache import FileCache
from grip_bt.commanders.description.files import errors
from grip_bt.commanders.description.load import inspect_robot
from grip_bt.commanders.description.tree import Joint, Tree
from grip_bt.commanders.description.xml import origin_of
from grip_gui.setup.robot_facts import key_of, states_of

_drawn: FileCache[tuple[str, str, tuple[tuple[str, str], ...]], dict[str, Any]] = FileCache()


def geometry(robot: object, hands: Mapping[str, str], folder: Path) -> dict[str, Any]:
    """Return what a robot looks like: `links`, `joints`, `meshes`, `rest`, `grasp`; else `error`.

    `hands` has the group of each hand's arm, to tell where what it holds is; else see `robot_facts`.
    """
    if not robot:
        return {"error": "grip.yaml names no robot"}
    name, place = key_of(robot, folder)
    try:
        return _drawn.get((name, place, tuple(hands.items())), lambda: _described(robot, hands, folder))
    except (GripError, ValidationError, ImportError) as error:
        return {"error": f"the robot can't be drawn: {error}"}


def _described(robot: object, hands: Mapping[str, str], folder: Path) -> dict[str, Any]:
    from grip_bt.commanders.kinematics.shapes import load_mesh  # of the extra `motion`, which the page does without

    source = RobotConfig.model_validate(robot) if isinstance(robot, Mapping) else str(robot)
    inspected = inspect_robot(source, folder)
    if (description := inspected.description) is None:
        raise InvalidRobotError("robot", errors(inspected.findings))
    urdf = fromstring(description.urdf)
    tree = Tree(urdf)
    colors = {m.get("name"): c.get("rgba") for m in urdf.findall("material") if (c := m.find("color")) is not None}
    meshes: list[dict[str, str]] = []
    frames = {hand: description.grasp_frames.get(group, description.grasp_frame) for hand, group in hands.items()}

    @cache
    def mesh(file: str, scale: tuple[float, ...]) -> int | None:
        """Return the number of a mesh, None of one that can't be read."""
        try:
            found = load_mesh(file.removeprefix("file://"), scale, hollow=True)  # type: ignore[arg-type]
        except GripError:  # `Check the robot` tells of it; the rest is drawn
            return None
        points, triangles = coarse(found.points, found.triangles)
        meshes.append({"points": _coded(points.astype("<f4")), "triangles": _coded(triangles.astype("<u4"))})
        return len(meshes) - 1

    return {
        "name": description.name,
        "links": {link.get("name"): list(_shapes(link, mesh, colors)) for link in urdf.iter("link")},
        "joints": [_drawn_joint(joint) for joint in tree.joints.values()],
        "meshes": meshes,
        "rest": description.at_rest,
        "groups": {group: list(joints) for group, joints in description.groups.items()},
        "states": states_of(description),
        "findings": list(dict.fromkeys(map(str, inspected.findings))),
        "grasp": {
            hand: {"link": each.link, "group": hands[hand], "at": _listed(each.pose)} for hand, each in frames.items()
        },
    }


_FindMesh = Callable[[str, tuple[float, ...]], "int | None"]


def _shapes(link: Element, mesh: _FindMesh, colors: Mapping[str | None, str | None]) -> Iterator[dict[str, Any]]:
    for visual in link.findall("visual") or link.findall("collision"):
        geometry = visual.find("geometry")
        if geometry is None or not len(geometry):
            continue
        shape = _shape(geometry[0], mesh)
        if shape is not None:
            material = visual.find("material")
            named = None if material is None else colors.get(material.get("name"))
            color = visual.find("material/color")
            rgba = named if color is None else color.get("rgba")
            yield {**shape, "at": _listed(origin_of(visual)), "color": _floats(rgba, ())}


def _shape(body: Element, mesh: _FindMesh) -> dict[str, Any] | None:
    match body.tag:
        case "box":
            return {"kind": "box", "size": _floats(body.get("size"), (0.0, 0.0, 0.0))}
        case "cylinder" | "capsule":
            return {"kind": "cylinder", "size": [float(body.get("radius", 0)), float(body.get("length", 0))]}
        case "sphere":
            return {"kind": "sphere", "size": [float(body.get("radius", 0))]}
        case "mesh":
            number = mesh(body.get("filename", ""), tuple(_floats(body.get("scale"), (1.0, 1.0, 1.0))))
            return None if number is None else {"kind": "mesh", "size": [], "mesh": number}
    return None


def _drawn_joint(joint: Joint) -> dict[str, Any]:
    return {
        **{key: getattr(joint, key) for key in ("name", "type", "parent", "child")},
        "at": _listed(joint.origin),
        "axis": list(joint.axis),
        "mimic": None if joint.mimic is None else asdict(joint.mimic),
        "limits": [joint.lower, joint.upper] if joint.type in ("revolute", "prismatic") else [],
    }


def _listed(pose: Pose) -> list[float]:
    """Return x y z [m] and the quaternion w x y z."""
    return [*pose.position.tolist(), *pose.quaternion.tolist()]


def _floats(text: str | None, otherwise: tuple[float, ...]) -> list[float]:
    return [float(word) for word in text.split()] if text else list(otherwise)


def _coded(array: NDArray[Any]) -> str:
    return b64encode(np.ascontiguousarray(array).tobytes()).decode()
