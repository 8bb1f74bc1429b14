"""`python -m grip_gui.setup.robot_drawing`: a robot for drawing: its tree of joints, shapes of links in few triangles.

Where the joints are is told apart from it; the page does the forward kinematics, so that a moment of a run is a
handful of numbers.
"""

from __future__ import annotations

import sys
from base64 import b64encode
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, fromstring

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from grip_bt.app.runs.motion_record import coarse
from grip_bt.base.errors import GripError
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.kinematics.shapes import load_mesh
from grip_gui.processes import answer_question

_MIMIC = {"multiplier": 1.0, "offset": 0.0}
_HERE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def _described(robot: object, hands: Mapping[str, str], folder: str) -> dict[str, Any]:
    source = RobotConfig.model_validate(robot) if isinstance(robot, Mapping) else str(robot)
    description = load_robot(source, Path(folder))
    urdf = fromstring(description.urdf)
    colors = {m.get("name"): c.get("rgba") for m in urdf.findall("material") if (c := m.find("color")) is not None}
    meshes = _Meshes()
    grasp = {}
    for hand, group in hands.items():
        frame = description.grasp_frames.get(group, description.grasp_frame)
        grasp[hand] = {"link": frame.link, "at": [*frame.pose.position.tolist(), *frame.pose.quaternion.tolist()]}
    return {
        "name": description.name,
        "links": [
            {"name": link.get("name"), "shapes": list(_shapes(link, meshes, colors))} for link in urdf.iter("link")
        ],
        "joints": [_joint(joint) for joint in urdf.findall("joint")],
        "meshes": meshes.found,
        "rest": description.at_rest,
        "grasp": grasp,
    }


class _Meshes:
    """Meshes by file and scale, each once."""

    def __init__(self) -> None:
        self.found: list[dict[str, str]] = []
        self._numbers: dict[tuple[str, tuple[float, ...]], int | None] = {}

    def number(self, file: str, scale: tuple[float, ...]) -> int | None:
        """Return the number of a mesh, None of one that can't be read."""
        if (file, scale) not in self._numbers:
            try:
                points, triangles = coarse(load_mesh(file.removeprefix("file://"), scale, hollow=True))  # type: ignore[arg-type]
            except GripError:  # `Check the robot` tells of it; the rest is drawn
                self._numbers[file, scale] = None
            else:
                self._numbers[file, scale] = len(self.found)
                self.found.append(
                    {"points": _coded(points.astype("<f4")), "triangles": _coded(triangles.astype("<u4"))}
                )
        return self._numbers[file, scale]


def _shapes(link: Element, meshes: _Meshes, colors: Mapping[str | None, str | None]) -> Iterator[dict[str, Any]]:
    for visual in link.findall("visual") or link.findall("collision"):
        geometry = visual.find("geometry")
        if geometry is None or not len(geometry):
            continue
        shape = _shape(geometry[0], meshes)
        if shape is not None:
            material = visual.find("material")
            named = None if material is None else colors.get(material.get("name"))
            color = visual.find("material/color")
            rgba = named if color is None else color.get("rgba")
            yield {**shape, "at": _origin(visual), "color": _floats(rgba, ())}


def _shape(body: Element, meshes: _Meshes) -> dict[str, Any] | None:
    match body.tag:
        case "box":
            return {"kind": "box", "size": _floats(body.get("size"), (0.0, 0.0, 0.0))}
        case "cylinder" | "capsule":
            return {"kind": "cylinder", "size": [float(body.get("radius", 0)), float(body.get("length", 0))]}
        case "sphere":
            return {"kind": "sphere", "size": [float(body.get("radius", 0))]}
        case "mesh":
            number = meshes.number(body.get("filename", ""), tuple(_floats(body.get("scale"), (1.0, 1.0, 1.0))))
            return None if number is None else {"kind": "mesh", "size": [], "mesh": number}
    return None


def _joint(joint: Element) -> dict[str, Any]:
    has: dict[str, Mapping[str, str]] = {part.tag: part.attrib for part in joint}
    mimic = has.get("mimic")
    return {
        "name": joint.get("name"),
        "type": joint.get("type"),
        "parent": has.get("parent", {}).get("link", ""),
        "child": has.get("child", {}).get("link", ""),
        "at": _origin(joint),
        "axis": _floats(has.get("axis", {}).get("xyz"), (1.0, 0.0, 0.0)),
        "mimic": mimic and {"joint": mimic.get("joint"), **{k: float(mimic.get(k, d)) for k, d in _MIMIC.items()}},
    }


def _origin(part: Element) -> list[float]:
    """Return x y z [m] and the quaternion w x y z of an `origin`."""
    origin = part.find("origin")
    if origin is None:
        return list(_HERE)
    turns = Rotation.from_euler("xyz", _floats(origin.get("rpy"), (0.0, 0.0, 0.0)))  # fixed axes, as URDF has it
    x, y, z, w = turns.as_quat().tolist()
    return [*_floats(origin.get("xyz"), (0.0, 0.0, 0.0)), w, x, y, z]


def _floats(text: str | None, otherwise: tuple[float, ...]) -> list[float]:
    return [float(word) for word in text.split()] if text else list(otherwise)


def _coded(array: NDArray[Any]) -> str:
    return b64encode(np.ascontiguousarray(array).tobytes()).decode()


if __name__ == "__main__":
    sys.exit(answer_question(_described))
