"""What vendors leave out and can be told from the tree: groups without an SRDF, postures of hands, efforts."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from grip_bt.base.errors import listing
from grip_bt.base.issue import Issue
from grip_bt.base.values import JointState

from .check_urdf import INERTIA, NO_EFFORT
from .files import robot_issue
from .robot import EndEffector, RobotDescription
from .srdf import Group, Srdf
from .tree import Tree
from .xml import origin_of

LONGEST_FINGER = 5
"""Joints of a finger; what branches off into longer chains is no hand."""


def with_groups(srdf: Srdf, tree: Tree) -> tuple[Srdf, Issue | None]:
    """Return an SRDF without groups with those that the tree suggests: `arm`, `hand` or both; and that, told."""
    mimics = tree.mimics()
    active = [joint for joint in tree.joints.values() if joint.movable and joint.name not in mimics]
    if srdf.groups or not active:
        return srdf, None
    chains = {tip: tuple(j for j in reversed([*tree.upwards(tip)]) if j in active) for tip in tree.links}
    longest = max(chains.values(), key=len)
    trunk = list(longest)
    for number in range(len(longest) - 1, -1, -1):  # from the tip inwards: the first link that carries fingers
        link = longest[number].child if number >= 0 else tree.root
        if len(longest) - number - 1 > LONGEST_FINGER:
            break
        if _fingers_on(tree, link, [*(j.name for j in active), *mimics]) > 1:
            trunk = list(longest[: number + 1])
            break
    else:
        if len(longest) <= LONGEST_FINGER:
            trunk = []
    end = trunk[-1].child if trunk else tree.root
    beyond = tree.subtree(end)
    fingers = [joint.name for joint in active if joint.child in beyond and joint not in trunk]
    groups = {}
    if trunk:
        groups["arm"] = Group("arm", tuple(joint.name for joint in trunk))
    if fingers:
        groups["hand"] = Group("hand", tuple(fingers))
    ends = (EndEffector("hand", "hand", end, "arm"),) if trunk and fingers else ()
    said = ", ".join(f"{name} ({len(group.joints)} joints)" for name, group in groups.items())
    message = f"there is no SRDF and no `groups:`; these are taken: {said}"
    return replace(srdf, groups=groups, end_effectors=ends), robot_issue("warning", "no-groups", message)


def _fingers_on(tree: Tree, link: str, moving: list[str]) -> int:
    """Count the moving joints that are next on a link, over fixed ones."""
    found = 0
    for joint in tree.below(link):
        found += 1 if joint.name in moving else _fingers_on(tree, joint.child, moving)
    return found


_OPEN = re.compile(r"open|extend|release|straight|spread")
_CLOSED = re.compile(r"clos|fist|grasp|pinch|grip$|pack")
_PARTLY = re.compile(r"half|semi|mid|part|pre")
ENOUGH = 0.02
"""Part of the fingers' distance by which a joint's motion closes the hand at least."""


def with_postures(robot: RobotDescription) -> tuple[RobotDescription, list[Issue]]:
    """Return a robot whose hands all have the states `open` and `closed`, and how those were found that files lack.

    A state whose name says it is taken. Else a hand is open where its joints are at rest, and closed where each that
    brings the fingers nearer to one another is at nine tenths of its way.
    """
    states = {group: dict(named) for group, named in robot.named_states.items()}
    found: list[Issue] = []
    for hand in robot.hands:
        mine = states.setdefault(hand, {})
        named = {"open": _named(mine, _OPEN), "closed": _named(mine, _CLOSED)}
        lacking = [word for word, name in named.items() if name is None]
        guessed = _guessed(robot, hand) if lacking else {}
        for word, name in named.items():
            if word not in mine:
                mine[word] = mine[name] if name is not None else guessed[word]
        if lacking:
            said = " and ".join(f"`{word}`" for word in lacking)
            message = f"hand {hand!r} has no state {said}; joints that bring its fingers together tell it"
            found.append(robot_issue("warning", "no-postures", message))
    return replace(robot, named_states=states), found


def _named(states: Mapping[str, JointState], word: re.Pattern[str]) -> str | None:
    exact = [name for name in states if name in ("open", "closed") and word.search(name)]
    alike = [name for name in states if word.search(name.lower()) and not _PARTLY.search(name.lower())]
    return next(iter([*exact, *sorted(alike, key=len)]), None)


def _guessed(robot: RobotDescription, hand: str) -> dict[str, JointState]:
    tree, names = Tree.of(robot.urdf), robot.group(hand)
    limits = {name: (tree.joints[name].lower, tree.joints[name].upper) for name in names}
    rest = {name: min(max(0.0, low), high) for name, (low, high) in limits.items()}
    ways = _Ways(robot, tree, hand)
    begin, end, apart = dict(rest), dict(rest), ways.apart(rest)
    for name, (low, high) in limits.items():
        reach = {q: ways.apart({**rest, name: q}) for q in (low, high)}
        near, far = min(reach, key=lambda q: reach[q]), max(reach, key=lambda q: reach[q])
        if apart - reach[near] > ENOUGH * apart:
            end[name] = rest[name] + 0.9 * (near - rest[name])
        elif reach[far] - apart > ENOUGH * apart:  # it rests closed, as a parallel gripper at zero
            begin[name] = far
    return {word: JointState(names, [at[name] for name in names]) for word, at in (("open", begin), ("closed", end))}


def with_efforts(robot: RobotDescription) -> tuple[RobotDescription, list[Issue]]:
    """Return a robot whose arms' drives can accelerate it as its limits say, and which ones couldn't.

    What a joint needs is the inertia of what it carries about its axis, at rest, times its acceleration limit. Where
    its effort limit is less, a tool has filled that in.
    """
    root, there = ET.fromstring(robot.urdf), robot.with_followers(robot.at_rest)
    tree, weak = Tree(root), {}
    bodies = {link.get("name", ""): body for link in root.iter("link") if (body := link.find("inertial")) is not None}
    hands = {joint for hand in robot.hands for joint in robot.groups[hand]}
    for name in (name for name in robot.joints if name not in hands and tree.joints[name].type != "prismatic"):
        joint, inertia = tree.joints[name], 0.0
        for link in bodies.keys() & set(tree.subtree(joint.child)):
            (mass, moment), point = _weight(bodies[link]), origin_of(bodies[link]).position
            point = tree.seen_from(joint.child, link, point, there)
            inertia += moment + mass * float(np.sum(np.cross(joint.axis, point) ** 2))
        if robot.drives[name].limit == joint.effort < inertia * robot.acceleration_limits[name]:
            weak[name] = robot.drives[name].model_copy(update={"limit": NO_EFFORT["rad"]})
    said = f"the efforts of joints {listing(weak)} can't accelerate what they carry as their limits say"
    found = robot_issue("warning", "no-effort", f"{said}; simulation takes {NO_EFFORT['rad']:g}")
    return replace(robot, drives={**robot.drives, **weak}), [found] if weak else []


def _weight(inertial: ET.Element) -> tuple[float, float]:
    """Return a body's mass [kg], and at most its moment of inertia about any axis through its centre [kg m^2]."""
    mass, inertia = ({} if (each := inertial.find(tag)) is None else each.attrib for tag in ("mass", "inertia"))
    return float(mass.get("value", "0")), sum(float(inertia.get(name, "0")) for name in INERTIA[:3]) / 2


class _Ways:
    """How far a hand's fingers are from one another, by forward kinematics."""

    def __init__(self, robot: RobotDescription, tree: Tree, hand: str):
        self.robot, self.tree = robot, tree
        links = set(robot.hands[hand])
        tips = {mine[-1] for mine in robot.finger_links.values() if mine and mine[-1] in links}
        self.middles = {
            link.get("name", ""): np.zeros(3) if (at := link.find("inertial")) is None else origin_of(at).position
            for link in ET.fromstring(robot.urdf).findall("link")
            if link.get("name") in tips
        }

    def apart(self, positions: Mapping[str, float]) -> float:
        tree, there = self.tree, self.robot.with_followers(positions)
        points = [tree.seen_from(tree.root, tip, point, there) for tip, point in self.middles.items()]
        return float(sum(np.linalg.norm(a - b) for a, b in combinations(points, 2)))
