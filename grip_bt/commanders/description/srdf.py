"""SRDF: the groups, end effectors, states and pairs that a URDF says nothing about, as values."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field

from grip_bt.base.errors import DocumentError

from ..robots.description import EndEffector
from .xml import line_of, required


@dataclass(frozen=True, slots=True)
class Group:
    """A planning group as it is written; `resolve` in `groups` makes joints of it.

    Attributes:
        name: its name.
        joints: named joints.
        links: named links: each stands for the joint that carries it.
        chains: pairs of base link and tip link.
        groups: groups that belong to it.
        line: 1-based line in the file, or None.
    """

    name: str
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    chains: tuple[tuple[str, str], ...] = ()
    groups: tuple[str, ...] = ()
    line: int | None = None


@dataclass(frozen=True, slots=True)
class VirtualJoint:
    """How the robot's base stands in the world: `fixed`, `planar` or `floating`."""

    name: str
    type: str
    parent_frame: str
    child_link: str


@dataclass(frozen=True)
class Srdf:
    """What an SRDF says.

    Attributes:
        source: the file; empty for one that was made up.
        name: of the robot.
        groups: name -> group.
        states: group -> name -> joint -> position [rad or m].
        end_effectors: in the file's order.
        virtual_joints: likewise.
        passive: joints that nobody drives.
        disabled: pairs of links that may touch, each sorted.
    """

    source: str = ""
    name: str = ""
    groups: Mapping[str, Group] = field(default_factory=dict)
    states: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)
    end_effectors: tuple[EndEffector, ...] = ()
    virtual_joints: tuple[VirtualJoint, ...] = ()
    passive: tuple[str, ...] = ()
    disabled: frozenset[tuple[str, str]] = frozenset()


def read_srdf(robot: ET.Element, source: str = "") -> Srdf:
    """Return what an SRDF's tree says.

    Raises:
        DocumentError: a name is missing, a group is there twice, or a position isn't a number.
    """
    groups: dict[str, Group] = {}
    for element in robot.findall("group"):
        group = _group(element, source)
        if group.name in groups:
            raise DocumentError(f"two groups are called {group.name!r}; rename one", source, line_of(element))
        groups[group.name] = group
    virtual = tuple(
        VirtualJoint(
            required(e, "name", source), e.get("type", "fixed"), e.get("parent_frame", ""), e.get("child_link", "")
        )
        for e in robot.findall("virtual_joint")
    )
    return Srdf(
        source,
        robot.get("name", ""),
        groups,
        _states(robot, {joint.name for joint in virtual}, source),
        tuple(
            EndEffector(
                required(e, "name", source), e.get("group", ""), e.get("parent_link", ""), e.get("parent_group", "")
            )
            for e in robot.findall("end_effector")
        ),
        virtual,
        tuple(required(e, "name", source) for e in robot.findall("passive_joint")),
        _pairs(robot, "disable_collisions", source) - _pairs(robot, "enable_collisions", source),
    )


def _group(element: ET.Element, source: str) -> Group:
    named = {
        tag: tuple(required(e, "name", source) for e in element.findall(tag)) for tag in ("joint", "link", "group")
    }
    return Group(
        required(element, "name", source),
        named["joint"],
        named["link"],
        tuple((required(e, "base_link", source), required(e, "tip_link", source)) for e in element.findall("chain")),
        named["group"],
        line_of(element),
    )


def _states(robot: ET.Element, virtual: set[str], source: str) -> dict[str, dict[str, dict[str, float]]]:
    states: dict[str, dict[str, dict[str, float]]] = {}
    for element in robot.findall("group_state"):
        group, name = required(element, "group", source), required(element, "name", source)
        positions = {
            required(joint, "name", source): _position(joint, source)
            for joint in element.findall("joint")
            if joint.get("name") not in virtual  # a base that drives has three values or seven; it is held still
        }
        states.setdefault(group, {})[name] = positions
    return states


def _position(joint: ET.Element, source: str) -> float:
    text = required(joint, "value", source)
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DocumentError(
            f"the position of joint {joint.get('name')!r} has to be one finite number, not {text!r}",
            source,
            line_of(joint),
        )
    return value


def _pairs(robot: ET.Element, tag: str, source: str) -> frozenset[tuple[str, str]]:
    pairs = ((required(e, "link1", source), required(e, "link2", source)) for e in robot.findall(tag))
    return frozenset((min(pair), max(pair)) for pair in pairs)
