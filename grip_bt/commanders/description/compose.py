"""Robots made of robots: with names of their own, a hand on an arm, several in one world."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import JointState

from .build import with_additions
from .config import MountConfig, RobotConfig
from .robot import EndEffector, GraspFrame, Mimic, RobotDescription
from .tree import Tree

WORLD = "world"

KEYED = {
    **dict.fromkeys(("groups", "named_states", "grasp_frames", "hands", "preferences"), "group"),
    **dict.fromkeys(("drives", "acceleration_limits", "jerk_limits", "rest", "mimics"), "joint"),
    "finger_links": "finger",
}
"""Mapping of a `RobotDescription` -> what its keys are names of."""

_NAMES = (("link", "name"), ("joint", "name"), ("parent", "link"), ("child", "link"), ("mimic", "joint"))
Vector = tuple[float, float, float]


def namespaced(robot: RobotDescription, prefix: str, groups: bool = True) -> RobotDescription:
    """Return a robot with `prefix` before the names of its links and joints; of groups and fingers too, if wanted."""

    def named(word: str) -> str:
        return prefix + word if word else word

    def grouped(word: str) -> str:
        return named(word) if groups else word

    def inner(value: Any) -> Any:
        """Rename what a value of a mapping names: joints or links."""
        match value:
            case tuple():
                return tuple(map(named, value))
            case JointState():
                return replace(value, names=tuple(map(named, value.names)))
            case GraspFrame():
                return GraspFrame(named(value.link), replace(value.pose, frame=named(value.link)))
            case Mimic():
                return replace(value, joint=named(value.joint))
            case Mapping():
                return {key: inner(each) for key, each in value.items()}
        return value

    urdf = ET.fromstring(robot.urdf)
    for element in urdf.iter():
        for tag, attribute in _NAMES:
            if element.tag == tag and attribute in element.attrib:
                element.set(attribute, named(element.get(attribute, "")))
    urdf.set("name", robot.name)
    keyed: dict[str, Any] = {
        field: {(named if key == "joint" else grouped)(k): inner(v) for k, v in getattr(robot, field).items()}
        for field, key in KEYED.items()
    }
    ends = [
        EndEffector(named(e.name), grouped(e.group), named(e.parent_link), grouped(e.parent_group))
        for e in robot.end_effectors
    ]
    return replace(
        robot,
        urdf=ET.tostring(urdf, encoding="unicode"),
        base_link=named(robot.base_link),
        grasp_frame=inner(robot.grasp_frame),
        disabled_pairs=frozenset((min(p), max(p)) for p in map(inner, robot.disabled_pairs)),
        end_effectors=tuple(ends),
        **keyed,
    )


def on_arm(
    arm: RobotDescription, hand: RobotDescription, mount: MountConfig, name: str, config: RobotConfig
) -> RobotDescription:
    """Return one robot: an arm with a hand on one of its links.

    Args:
        arm: what it had on that link is left out.
        hand: its links and joints get the mount's namespace; its groups and fingers keep their names.
        mount: where the hand sits.
        config: groups, states and so on that are added.

    Raises:
        UnknownNameError: there is no such link.
    """
    arm = without_below(arm, mount.link)
    root = mount.root or hand.base_link
    _find(root, hand)
    prefix = f"{mount.namespace}_"
    hand = namespaced(hand, prefix, groups=False)
    urdf = ET.Element("robot", name=name)
    _add(urdf, arm)
    _add(urdf, hand)
    _fix(urdf, f"{prefix}mount", mount.link, prefix + root, mount.xyz, mount.rpy)
    carrier = _carrier(arm, mount.link)
    mine = set(arm.groups.get(carrier, ()))
    frames = {group: hand.grasp_frame for group, joints in arm.groups.items() if mine & set(joints)}
    whole = replace(
        _sum([arm, hand], urdf, arm.base_link),
        grasp_frame=hand.grasp_frame,
        grasp_frames={**arm.grasp_frames, **frames},
        end_effectors=(*arm.end_effectors, *(EndEffector(g, g, mount.link, carrier) for g in hand.hands)),
    )
    return with_additions(whole, config)


def in_one_world(robots: Mapping[str, RobotDescription], name: str, config: RobotConfig) -> RobotDescription:
    """Return several robots as one whose base link is the world: they are planned together or apart.

    Args:
        robots: namespace -> robot; an underscore is added.
        config: where each stands; groups, states and so on that are added, such as one group of all arms.
    """
    urdf = ET.Element("robot", name=name)
    ET.SubElement(urdf, "link", name=WORLD)
    parts = []
    for key, robot in robots.items():
        placed, part = config.robots[key], namespaced(robot, f"{key}_")
        _add(urdf, part)
        _fix(urdf, f"{key}_stands", WORLD, part.base_link, placed.xyz, placed.rpy)
        parts.append(part)
    return with_additions(_sum(parts, urdf, WORLD), config)


def _add(urdf: ET.Element, part: RobotDescription) -> None:
    """Add links and joints; materials that are used by name are written out: two robots may share a name."""
    robot = ET.fromstring(part.urdf)
    known = {material.get("name"): material for material in robot.iter("material") if len(material)}
    for element in robot:
        if element.tag in ("link", "joint"):
            for material in element.iter("material"):
                if not len(material) and material.get("name") in known:
                    material.extend(copy.deepcopy(known[material.get("name")])[:])
            urdf.append(element)


def _fix(urdf: ET.Element, joint: str, parent: str, child: str, xyz: Vector, rpy: Vector) -> None:
    element = ET.SubElement(urdf, "joint", name=joint, type="fixed")
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    places = {name: " ".join(repr(float(v)) for v in values) for name, values in (("xyz", xyz), ("rpy", rpy))}
    ET.SubElement(element, "origin", places)


def without_below(robot: RobotDescription, link: str) -> RobotDescription:
    """Return a robot without everything that hangs on a link; the link itself stays. Groups that lose joints are gone.

    Raises:
        UnknownNameError: there is no such link.
    """
    _find(link, robot)
    urdf = ET.fromstring(robot.urdf)
    tree = Tree(urdf)
    below = tree.subtree(link)[1:]
    cut = {("link", name) for name in below} | {("joint", tree.above[name].name) for name in below}
    for element in [e for e in urdf if (e.tag, e.get("name", "")) in cut]:
        urdf.remove(element)
    links = {e.get("name", "") for e in urdf.findall("link")}
    joints = {e.get("name", "") for e in urdf.findall("joint")}
    groups = {group for group, mine in robot.groups.items() if joints.issuperset(mine)}
    kept = {"joint": joints, "group": groups, "finger": set(robot.finger_links)}

    def frame(mine: GraspFrame) -> GraspFrame:
        return mine if mine.link in links else GraspFrame(link, type(mine.pose)((0.0, 0.0, 0.0), frame=link))

    keyed: dict[str, Any] = {
        field: {
            k: frame(v) if isinstance(v, GraspFrame) else v
            for k, v in getattr(robot, field).items()
            if k in kept[key] and (field not in ("finger_links", "hands") or links.issuperset(v))
        }
        for field, key in KEYED.items()
    }
    return replace(
        robot,
        urdf=ET.tostring(urdf, encoding="unicode"),
        grasp_frame=frame(robot.grasp_frame),
        disabled_pairs=frozenset(p for p in robot.disabled_pairs if links.issuperset(p)),
        end_effectors=tuple(
            e for e in robot.end_effectors if e.parent_link in links and (not e.group or e.group in groups)
        ),
        **keyed,
    )


def _sum(parts: Sequence[RobotDescription], urdf: ET.Element, base: str) -> RobotDescription:
    keyed: dict[str, Any] = {
        field: {k: v for part in parts for k, v in getattr(part, field).items()} for field in KEYED
    }
    return replace(
        parts[0],
        name=urdf.get("name", ""),
        urdf=ET.tostring(urdf, encoding="unicode"),
        base_link=base,
        disabled_pairs=frozenset(pair for part in parts for pair in part.disabled_pairs),
        end_effectors=tuple(end for part in parts for end in part.end_effectors),
        **keyed,
    )


def _carrier(arm: RobotDescription, link: str) -> str:
    """Return the smallest group whose joints carry a link; the first group where none does."""
    for joint in Tree.of(arm.urdf).upwards(link):
        able = [g for g, joints in arm.groups.items() if joint.name in joints]
        if able:
            return min(able, key=lambda g: len(arm.groups[g]))
    return next(iter(arm.groups), "")


def _find(link: str, robot: RobotDescription) -> None:
    links = Tree.of(robot.urdf).links
    if link not in links:
        raise UnknownNameError("link", link, links, where=f"robot {robot.name}")
