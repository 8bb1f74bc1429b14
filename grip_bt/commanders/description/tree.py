"""The tree of links and joints of a URDF that is known to be right (see `check_urdf`)."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from graphlib import CycleError, TopologicalSorter

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values.pose import Pose, quaternion_about

from .robot import Mimic, RobotDescription
from .xml import numbers, origin_of

MOVABLE = ("revolute", "continuous", "prismatic")
HELD = ("floating", "planar")
"""Joints that GRIP holds still: bases that drive or fly."""
JOINT_TYPES = (*MOVABLE, "fixed", *HELD)


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint.

    Attributes:
        name: its name.
        type: one of `JOINT_TYPES`.
        parent: the link that it sits on.
        child: the link that it moves.
        origin: of the joint in the frame of its parent.
        axis: along which it slides, or about which it turns; of any length.
        lower: [rad or m].
        upper: [rad or m].
        velocity: [rad/s or m/s].
        effort: [N m or N].
        mimic: whom it follows, or None.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: Pose
    axis: tuple[float, ...]
    lower: float = 0.0
    upper: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0
    mimic: Mimic | None = None

    @property
    def movable(self) -> bool:
        """Whether it moves."""
        return self.type in MOVABLE

    @property
    def limited(self) -> bool:
        """Whether it has limits of its position."""
        return self.lower < self.upper

    def pose(self, q: float) -> Pose:
        """Return the pose of its child in its parent, at a position [rad or m]; its origin where it doesn't move."""
        if not self.movable:
            return self.origin
        along = q * np.array(self.axis) / (np.linalg.norm(self.axis) or 1.0)
        return self.origin @ (Pose(along) if self.type == "prismatic" else Pose(quaternion=quaternion_about(along)))


def loop_in(edges: Mapping[str, Iterable[str]]) -> list[str]:
    """Return one of the loops of names that lead to others, its first name at the end again; empty where none is."""
    try:
        TopologicalSorter(edges).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


class Tree:
    """Links and joints, to be asked.

    Attributes:
        links: names, as the file lists them.
        joints: name -> joint, likewise.
        above: link -> the joint that carries it; the root has none.
        root: the link that nothing carries.
    """

    def __init__(self, robot: ET.Element):
        self.links = tuple(e.get("name", "") for e in robot.findall("link"))
        self.joints = {e.get("name", ""): _joint(e) for e in robot.findall("joint")}
        self.above = {joint.child: joint for joint in self.joints.values()}
        self.root = next(link for link in self.links if link not in self.above)
        self._below: dict[str, list[Joint]] = {}
        for joint in self.joints.values():
            self._below.setdefault(joint.parent, []).append(joint)

    @classmethod
    @lru_cache(maxsize=16)
    def of(cls, urdf: str) -> Tree:
        """Read the text of a URDF; what it is asked changes nothing in it."""
        return cls(ET.fromstring(urdf))

    def below(self, link: str) -> list[Joint]:
        """Return the joints that sit on a link."""
        return self._below.get(link, [])

    def upwards(self, link: str) -> Iterator[Joint]:
        """Yield the joints from a link to the root."""
        while (joint := self.above.get(link)) is not None:
            yield joint
            link = joint.parent

    def chain(self, base: str, tip: str) -> tuple[Joint, ...] | None:
        """Return the joints from one link out to another, or None where the one doesn't carry the other."""
        joints: list[Joint] = []
        if base == tip:
            return ()
        for joint in self.upwards(tip):
            joints.append(joint)
            if joint.parent == base:
                return tuple(reversed(joints))
        return None

    def seen_from(self, above: str, link: str, point: Array, positions: Mapping[str, float]) -> Array:
        """Return a point [m] of a link in the frame of one that carries it, at positions [rad or m]."""
        while link != above:
            joint = self.above[link]
            point, link = joint.pose(positions.get(joint.name, 0.0)).apply(point), joint.parent
        return point

    def subtree(self, link: str) -> tuple[str, ...]:
        """Return a link and all that it carries."""
        links = [link]
        for each in links:  # it grows while it is walked through
            links += [joint.child for joint in self.below(each)]
        return tuple(links)

    def mimics(self) -> dict[str, Mimic]:
        """Return the joints that follow others, with the joint that leads in the end."""
        found = {}
        for joint in self.joints.values():
            if joint.mimic is not None and joint.movable:
                leader, k, offset = joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset
                while (next_ := self.joints[leader].mimic) is not None:
                    leader, offset, k = next_.joint, offset + k * next_.offset, k * next_.multiplier
                found[joint.name] = Mimic(leader, k, offset)
        return found


def _joint(element: ET.Element) -> Joint:
    limit, mimic, axis = element.find("limit"), element.find("mimic"), element.find("axis")
    values = dict(limit.attrib) if limit is not None else {}
    lower, upper, velocity, effort = (float(values.get(name, "0")) for name in ("lower", "upper", "velocity", "effort"))
    parent, type_ = link_at(element, "parent"), element.get("type", "")
    return Joint(
        element.get("name", ""),
        type_,
        parent,
        link_at(element, "child"),
        origin_of(element, parent),
        (1.0, 0.0, 0.0) if axis is None or type_ not in MOVABLE else numbers(axis, "xyz", 3, "1 0 0"),
        lower,
        upper,
        velocity,
        effort,
        None
        if mimic is None
        else Mimic(mimic.get("joint", ""), float(mimic.get("multiplier") or "1"), float(mimic.get("offset") or "0")),
    )


def link_at(joint: ET.Element, tag: str) -> str:
    """Return the name of the link at one end of a joint, `parent` or `child`; empty where it names none."""
    end = joint.find(tag)
    return "" if end is None else end.get("link", "")


def links_of_groups(robot: RobotDescription, groups: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Return the links that the joints of groups move, up to the next joint of another group.

    Args:
        robot: its URDF and its groups.
        groups: name, such as an arm's in the project, -> group of the robot.

    Raises:
        UnknownNameError: the robot has no such group.
    """
    tree = Tree.of(robot.urdf)
    found = {}
    for name, group in groups.items():
        mine = robot.group(group)
        links = [joint.child for joint in tree.joints.values() if joint.name in mine]
        for link in links:  # it grows while it is walked through; joints of no group, fixed ones mostly, belong to it
            outwards = [joint.child for joint in tree.below(link) if joint.name not in robot.joints]
            links += [child for child in outwards if child not in links]
        found[name] = tuple(dict.fromkeys(links))
    return found


def joints_of_fingers(robot: RobotDescription, group: str) -> dict[str, tuple[str, ...]]:
    """Return the joints of a hand's group that move each of its fingers: finger -> joints, from the palm outwards.

    Raises:
        UnknownNameError: the robot has no such group.
    """
    joints, mine = Tree.of(robot.urdf).joints, robot.group(group)
    found = {f: tuple(j for j in mine if joints[j].child in links) for f, links in robot.finger_links.items()}
    return {finger: joints for finger, joints in found.items() if joints}


def limits_of_joints(robot: RobotDescription, group: str) -> dict[str, tuple[float, float]]:
    """Return the position limits [rad or m] of those of a group's joints that have some, as the URDF says."""
    joints = Tree.of(robot.urdf).joints
    return {name: (joints[name].lower, joints[name].upper) for name in robot.group(group) if joints[name].limited}
