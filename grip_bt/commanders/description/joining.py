"""Robots made of robots: with names of their own, a hand on an arm, several in one world."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from grip_bt.base.errors import UnknownNameError

from ..robots.assembly import Mount, cut_below, mounted
from ..robots.description import EndEffector, GraspFrame, Mimic, RobotDescription
from .adding import with_additions
from .config import MountConfig, RobotConfig

WORLD = "world"
T = TypeVar("T")


@dataclass(frozen=True)
class Placed:
    """A robot with where its base stands in the world.

    Attributes:
        robot: what it is.
        xyz: [m].
        rpy: fixed-axis roll, pitch and yaw [rad].
    """

    robot: RobotDescription
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)


def namespaced(robot: RobotDescription, prefix: str, groups: bool = True) -> RobotDescription:
    """Return a robot with `prefix` before the names of its links and joints; of groups and fingers too, if wanted."""

    def named(word: str) -> str:
        return prefix + word if word else word

    def grouped(word: str) -> str:
        return named(word) if groups else word

    urdf = ET.fromstring(robot.urdf)
    for element in urdf.iter():
        for tag, attribute in _NAMES:
            if element.tag == tag and attribute in element.attrib:
                element.set(attribute, named(element.get(attribute, "")))
    urdf.set("name", robot.name)
    return replace(
        robot,
        urdf=ET.tostring(urdf, encoding="unicode"),
        base_link=named(robot.base_link),
        groups={grouped(g): tuple(map(named, joints)) for g, joints in robot.groups.items()},
        named_states={
            grouped(g): {s: replace(state, names=tuple(map(named, state.names))) for s, state in states.items()}
            for g, states in robot.named_states.items()
        },
        grasp_frame=_frame(robot.grasp_frame, named),
        hand_links=tuple(map(named, robot.hand_links)),
        finger_links={grouped(f): tuple(map(named, links)) for f, links in robot.finger_links.items()},
        drives=_keyed(robot.drives, named),
        acceleration_limits=_keyed(robot.acceleration_limits, named),
        jerk_limits=_keyed(robot.jerk_limits, named),
        disabled_pairs=frozenset((min(p), max(p)) for p in (tuple(map(named, p)) for p in robot.disabled_pairs)),
        grasp_frames={grouped(g): _frame(frame, named) for g, frame in robot.grasp_frames.items()},
        hands={grouped(hand): tuple(map(named, links)) for hand, links in robot.hands.items()},
        mimics={named(j): Mimic(named(m.joint), m.multiplier, m.offset) for j, m in robot.mimics.items()},
        rest=_keyed(robot.rest, named),
        preferences={grouped(g): fields for g, fields in robot.preferences.items()},
        end_effectors=tuple(
            EndEffector(named(e.name), grouped(e.group), named(e.parent_link), grouped(e.parent_group))
            for e in robot.end_effectors
        ),
    )


def on_arm(
    arm: RobotDescription, hand: RobotDescription, mount: MountConfig, name: str, config: RobotConfig
) -> RobotDescription:
    """Return one robot: an arm with a hand on one of its links.

    Args:
        arm: what it had on that link is left out.
        hand: its links and joints get the mount's namespace; its groups and fingers keep their names.
        mount: where the hand sits.
        name: of the new robot.
        config: groups, states and so on that are added.

    Raises:
        UnknownNameError: there is no such link.
    """
    arm = without_below(arm, mount.link)
    prefix = f"{mount.namespace}_"
    _find("link", mount.root or hand.base_link, hand)
    root = mount.root or hand.base_link
    place = Mount(mount.link, root, mount.xyz, mount.rpy)
    urdf = mounted(ET.fromstring(arm.urdf), ET.fromstring(hand.urdf), place, prefix, name)
    hand = namespaced(hand, prefix, groups=False)
    carrier = _carrier(arm, mount.link)
    ends = tuple(EndEffector(group, group, mount.link, carrier) for group in hand.hands)
    frames = dict.fromkeys(_arms_of(arm, carrier), hand.grasp_frame)
    whole = _sum([arm, hand], ET.tostring(urdf, encoding="unicode"), arm.base_link, name)
    return with_additions(
        replace(
            whole,
            grasp_frame=hand.grasp_frame,
            grasp_frames={**arm.grasp_frames, **frames},
            end_effectors=(*arm.end_effectors, *ends),
        ),
        config,
    )


def in_one_world(robots: Mapping[str, Placed], name: str, config: RobotConfig) -> RobotDescription:
    """Return several robots as one whose base link is the world: they are planned together or apart.

    Args:
        robots: namespace -> robot; an underscore is added.
        name: of the whole.
        config: groups, states and so on that are added, such as one group of all arms.
    """
    urdf = ET.Element("robot", name=name)
    ET.SubElement(urdf, "link", name=WORLD)
    parts = []
    for key, placed in robots.items():
        part = namespaced(placed.robot, f"{key}_")
        tree = ET.fromstring(part.urdf)
        urdf.extend(e for e in tree if e.tag in ("link", "joint"))
        joint = ET.SubElement(urdf, "joint", name=f"{key}_stands", type="fixed")
        ET.SubElement(joint, "parent", link=WORLD)
        ET.SubElement(joint, "child", link=part.base_link)
        ET.SubElement(joint, "origin", xyz=_numbers(placed.xyz), rpy=_numbers(placed.rpy))
        parts.append(_with_own_frames(part))
    whole = _sum(parts, ET.tostring(urdf, encoding="unicode"), WORLD, name)
    return with_additions(whole, config)


def without_below(robot: RobotDescription, link: str) -> RobotDescription:
    """Return a robot without everything that hangs on a link; the link itself stays. Groups that lose joints are gone.

    Raises:
        UnknownNameError: there is no such link.
    """
    _find("link", link, robot)
    tree = cut_below(ET.fromstring(robot.urdf), link)
    links = {e.get("name", "") for e in tree.findall("link")}
    joints = {e.get("name", "") for e in tree.findall("joint")}
    groups = {g: tuple(j for j in mine if j in joints) for g, mine in robot.groups.items()}
    groups = {g: mine for g, mine in groups.items() if mine == robot.groups[g]}
    return replace(
        robot,
        urdf=ET.tostring(tree, encoding="unicode"),
        groups=groups,
        named_states={g: states for g, states in robot.named_states.items() if g in groups},
        grasp_frame=_kept(robot.grasp_frame, links, link),
        hand_links=tuple(x for x in robot.hand_links if x in links),
        finger_links={f: mine for f, mine in robot.finger_links.items() if set(mine) <= links},
        drives={j: d for j, d in robot.drives.items() if j in joints},
        acceleration_limits={j: a for j, a in robot.acceleration_limits.items() if j in joints},
        jerk_limits={j: most for j, most in robot.jerk_limits.items() if j in joints},
        disabled_pairs=frozenset(p for p in robot.disabled_pairs if set(p) <= links),
        grasp_frames={g: _kept(frame, links, link) for g, frame in robot.grasp_frames.items() if g in groups},
        hands={hand: mine for hand, mine in robot.hands.items() if hand in groups and set(mine) <= links},
        mimics={j: m for j, m in robot.mimics.items() if j in joints},
        rest={j: q for j, q in robot.rest.items() if j in joints},
        preferences={g: fields for g, fields in robot.preferences.items() if g in groups},
        end_effectors=tuple(
            e for e in robot.end_effectors if e.parent_link in links and (not e.group or e.group in groups)
        ),
    )


def _sum(parts: list[RobotDescription], urdf: str, base: str, name: str) -> RobotDescription:
    def joined(attribute: str) -> dict[str, T]:
        return {key: value for part in parts for key, value in getattr(part, attribute).items()}

    first = parts[0]
    return replace(
        first,
        name=name,
        urdf=urdf,
        base_link=base,
        groups=joined("groups"),
        named_states=joined("named_states"),
        hand_links=tuple(link for part in parts for link in part.hand_links),
        finger_links=joined("finger_links"),
        drives=joined("drives"),
        acceleration_limits=joined("acceleration_limits"),
        jerk_limits=joined("jerk_limits"),
        disabled_pairs=frozenset(pair for part in parts for pair in part.disabled_pairs),
        grasp_frames=joined("grasp_frames"),
        hands=joined("hands"),
        mimics=joined("mimics"),
        rest=joined("rest"),
        preferences=joined("preferences"),
        end_effectors=tuple(end for part in parts for end in part.end_effectors),
    )


def _with_own_frames(robot: RobotDescription) -> RobotDescription:
    """Give the groups of a robot with one grasp frame that frame by name, and its one hand to its one arm."""
    arms = [group for group in robot.groups if group not in robot.hands]
    frames = robot.grasp_frames or dict.fromkeys(arms, robot.grasp_frame)
    ends = robot.end_effectors
    if not ends and len(arms) == 1:
        ends = tuple(EndEffector(hand, hand, robot.grasp_frame.link, arms[0]) for hand in robot.hands)
    return replace(robot, grasp_frames=frames, end_effectors=ends)


def _carrier(arm: RobotDescription, link: str) -> str:
    """Return the smallest group whose joints carry a link; the first group where none does."""
    parents = {j.find("child").get("link"): j for j in ET.fromstring(arm.urdf).findall("joint")}  # type: ignore[union-attr]
    at = link
    while (joint := parents.get(at)) is not None:
        able = [g for g, joints in arm.groups.items() if joint.get("name") in joints]
        if able:
            return min(able, key=lambda g: len(arm.groups[g]))
        at = joint.find("parent").get("link", "")  # type: ignore[union-attr]
    return next(iter(arm.groups), "")


def _arms_of(arm: RobotDescription, carrier: str) -> list[str]:
    mine = set(arm.groups.get(carrier, ()))
    return [g for g, joints in arm.groups.items() if mine & set(joints)]


def _find(kind: str, link: str, robot: RobotDescription) -> None:
    links = [e.get("name", "") for e in ET.fromstring(robot.urdf).findall("link")]
    if link not in links:
        raise UnknownNameError(kind, link, links, where=f"robot {robot.name}")


def _frame(frame: GraspFrame, named: Callable[[str], str]) -> GraspFrame:
    return GraspFrame(named(frame.link), replace(frame.pose, frame=named(frame.link)))


def _kept(frame: GraspFrame, links: set[str], link: str) -> GraspFrame:
    if frame.link in links:
        return frame
    return GraspFrame(link, type(frame.pose)((0.0, 0.0, 0.0), frame=link))


def _keyed(values: Mapping[str, T], named: Callable[[str], str]) -> dict[str, T]:
    return {named(key): value for key, value in values.items()}


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(repr(float(v)) for v in values)


_NAMES = (("link", "name"), ("joint", "name"), ("parent", "link"), ("child", "link"), ("mimic", "joint"))
