"""URDF surgery on element trees: resolve mesh paths, cut a gripper off, mount a hand, drop the visuals.

Every function returns a new tree and leaves its arguments as they were.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError, MissingPartError

PACKAGE = "package://"


@dataclass(frozen=True, slots=True)
class Mount:
    """How a hand sits on an arm.

    Attributes:
        arm_link: the arm's flange.
        hand_link: the hand's root link, by its name in the hand's own URDF.
        xyz: position of the hand's root in the flange [m].
        rpy: its orientation, fixed-axis roll pitch yaw [rad].
    """

    arm_link: str
    hand_link: str
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)


def load_urdf(path: Path, packages: Mapping[str, Path]) -> ET.Element:
    """Read a URDF and make its mesh paths absolute.

    Args:
        path: the URDF file.
        packages: package name -> folder, to resolve `package://name/...`.

    Raises:
        DocumentError: the file isn't XML, or isn't a robot.
        MissingPartError: a mesh names a package that isn't known.
    """
    try:
        robot = ET.parse(path).getroot()
    except ET.ParseError as error:
        line, column = error.position
        raise DocumentError(f"isn't well-formed XML: {error}", str(path), line, column) from error
    if robot.tag != "robot":
        raise DocumentError(f"a URDF's root element is <robot>, not <{robot.tag}>", str(path))
    for mesh in robot.iter("mesh"):
        mesh.set("filename", str(_resolved(mesh.get("filename", ""), path, packages)))
    return robot


def _resolved(filename: str, urdf: Path, packages: Mapping[str, Path]) -> Path:
    if not filename.startswith(PACKAGE):
        return (urdf.parent / filename.removeprefix("file://")).resolve()
    package, _, rest = filename.removeprefix(PACKAGE).partition("/")
    if package not in packages:
        raise MissingPartError(
            f"package {package!r}, which {urdf.name} takes the mesh {rest!r} from",
            f"install it or name its folder (known packages: {', '.join(sorted(packages))})",
        )
    return packages[package] / rest


def cut_below(robot: ET.Element, link: str) -> ET.Element:
    """Return the robot without everything that hangs on `link`; the link itself stays."""
    robot = copy.deepcopy(robot)
    joints_of: dict[str, list[ET.Element]] = {}
    for joint in robot.findall("joint"):
        if (parent := joint.find("parent")) is not None:
            joints_of.setdefault(parent.get("link", ""), []).append(joint)
    links = {element.get("name", ""): element for element in robot.findall("link")}
    todo = [link]
    while todo:
        for joint in joints_of.get(todo.pop(), []):
            child = joint.find("child").get("link", "")  # type: ignore[union-attr]
            robot.remove(joint)
            robot.remove(links[child])
            todo.append(child)
    return robot


def mounted(arm: ET.Element, hand: ET.Element, mount: Mount, prefix: str, name: str) -> ET.Element:
    """Return one robot: the arm with the hand on its flange.

    Args:
        arm: the arm's URDF.
        hand: the hand's URDF; its links and joints get `prefix`, so that two hands can share a robot.
        mount: where the hand sits.
        prefix: for instance `hand_`.
        name: the new robot's name.
    """
    robot = ET.Element("robot", name=name)
    robot.extend(_with_materials(arm))
    robot.extend(_prefixed(element, prefix) for element in _with_materials(hand))
    joint = ET.SubElement(robot, "joint", name=f"{prefix}mount", type="fixed")
    ET.SubElement(joint, "parent", link=mount.arm_link)
    ET.SubElement(joint, "child", link=prefix + mount.hand_link)
    ET.SubElement(joint, "origin", xyz=_numbers(mount.xyz), rpy=_numbers(mount.rpy))
    return robot


def without_visuals(robot: ET.Element) -> ET.Element:
    """Return the robot without its `<visual>` elements."""
    robot = copy.deepcopy(robot)
    for link in robot.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    return robot


def _with_materials(robot: ET.Element) -> list[ET.Element]:
    """Copy links and joints, and write out materials that are used by name: two robots may share a name."""
    known = {m.get("name"): m for m in robot.iter("material") if len(m)}
    parts = [copy.deepcopy(e) for e in robot if e.tag in ("link", "joint")]
    for part in parts:
        for material in part.iter("material"):
            if not len(material) and material.get("name") in known:
                material.extend(copy.deepcopy(c) for c in known[material.get("name")])
    return parts


def _prefixed(element: ET.Element, prefix: str) -> ET.Element:
    element.set("name", prefix + element.get("name", ""))
    for tag, attribute in (("parent", "link"), ("child", "link"), ("mimic", "joint")):
        if (reference := element.find(tag)) is not None:
            reference.set(attribute, prefix + reference.get(attribute, ""))
    return element


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{v:g}" for v in values)
