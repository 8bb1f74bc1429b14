"""Which links and joints belong together: those of an arm, of a hand, of a finger; and the limits of joints."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

from .robots import RobotDescription


def links_of_groups(robot: RobotDescription, groups: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Return the links that the joints of groups move, up to the next joint of another group.

    Args:
        robot: its URDF and its groups.
        groups: name, such as an arm's in the project, -> group of the robot.

    Raises:
        UnknownNameError: the robot has no such group.
    """
    joints = [(j.get("name", ""), *_ends(j)) for j in ET.fromstring(robot.urdf).iter("joint") if len(j)]
    grouped = {joint for group in robot.groups for joint in robot.group(group)}
    return {name: _moved(robot.group(group), joints, grouped) for name, group in groups.items()}


def joints_of_fingers(robot: RobotDescription, group: str) -> dict[str, tuple[str, ...]]:
    """Return the joints of a hand's group that move each of its fingers: finger -> joints, from the palm outwards.

    Raises:
        UnknownNameError: the robot has no such group.
    """
    child = {j.get("name", ""): _ends(j)[1] for j in ET.fromstring(robot.urdf).iter("joint") if len(j)}
    mine = robot.group(group)
    found = {finger: tuple(j for j in mine if child.get(j) in links) for finger, links in robot.finger_links.items()}
    return {finger: joints for finger, joints in found.items() if joints}


def limits_of_joints(robot: RobotDescription, group: str) -> dict[str, tuple[float, float]]:
    """Return the position limits [rad or m] of those of a group's joints that have some, as the URDF says."""
    mine = robot.group(group)
    limits = {j.get("name", ""): j.find("limit") for j in ET.fromstring(robot.urdf).iter("joint")}
    return {
        name: (float(limit.get("lower", "0")), float(limit.get("upper", "0")))
        for name, limit in limits.items()
        if name in mine and limit is not None and (limit.get("lower") or limit.get("upper"))
    }


def _moved(mine: Sequence[str], joints: Sequence[tuple[str, str, str]], grouped: set[str]) -> tuple[str, ...]:
    """Follow the joints outwards from the group's own; those of no group, fixed ones mostly, belong to it."""
    links = [child for name, _, child in joints if name in mine]
    for link in links:  # it grows while it is walked through
        links += [c for name, parent, c in joints if parent == link and name not in grouped and c not in links]
    return tuple(dict.fromkeys(links))


def _ends(joint: ET.Element) -> tuple[str, str]:
    parent, child = joint.find("parent"), joint.find("child")
    return (
        parent.get("link", "") if parent is not None else "",
        child.get("link", "") if child is not None else "",
    )
