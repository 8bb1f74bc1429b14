"""A checked URDF as GRIP plans with it: absolute meshes, one kind of limits, nothing but links and joints."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

from grip_bt.base.errors import MissingPartError

from ..moveit_package.settings import JointLimits
from .packages import Packages
from .tree import HELD
from .xml import numbers

TURNS = 2 * math.pi
"""A continuous joint is planned with within so much [rad] to both sides."""
NO_EFFORT = 100.0
"""Effort limit [N m or N] of joints that have none."""


def normal(
    robot: ET.Element, name: str, folder: Path, packages: Packages, limits: Mapping[str, JointLimits]
) -> ET.Element:
    """Return a copy of a URDF without errors.

    Args:
        robot: its tree.
        folder: that relative mesh paths start in.
        packages: for `package://`.
        limits: joint -> limits that override its own.
    """
    result = ET.Element("robot", name=name)
    result.extend(copy.deepcopy(e) for e in robot if e.tag in ("material", "link", "joint"))
    for link in result.findall("link"):
        _with_found_meshes(link, folder, packages)
    for joint in result.findall("joint"):
        _with_limits(joint, limits.get(joint.get("name", ""), JointLimits()))
    return result


def _with_found_meshes(link: ET.Element, folder: Path, packages: Packages) -> None:
    """Make mesh paths absolute; leave out what is only seen and isn't there."""
    for visual in [*link.findall("visual"), *link.findall("collision")]:
        for mesh in visual.iter("mesh"):
            try:
                path = packages.resolve(mesh.get("filename", ""), folder)
            except MissingPartError:
                path = Path()
            mesh.set("filename", str(path))
            if visual.tag == "visual" and not path.is_file():
                link.remove(visual)


def _with_limits(joint: ET.Element, override: JointLimits) -> None:
    kind = joint.get("type", "")
    if kind in HELD:
        joint.set("type", "fixed")
    if joint.get("type") == "fixed":
        return
    if (axis := joint.find("axis")) is not None:
        x, y, z = numbers(axis, "xyz", 3, "1 0 0")
        length = math.hypot(x, y, z)
        axis.set("xyz", f"{x / length!r} {y / length!r} {z / length!r}")
    limit = joint.find("limit")
    if limit is None:
        limit = ET.SubElement(joint, "limit")
    if kind == "continuous":
        joint.set("type", "revolute")
        limit.set("lower", repr(-TURNS))
        limit.set("upper", repr(TURNS))
        limit.set("velocity", limit.get("velocity", repr(math.pi)))
    for key in ("lower", "upper", "velocity"):
        if (value := getattr(override, key)) is not None:
            limit.set(key, repr(value))
    if float(limit.get("effort", "0")) <= 0:
        limit.set("effort", repr(NO_EFFORT))
