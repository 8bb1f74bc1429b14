"""SRDF: what a URDF says nothing about, its groups as joints of the robot's tree, and all that is wrong with it."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from grip_bt.base.errors import DocumentError, listing, nearest

from .files import Finding, Severity
from .robot import EndEffector
from .tree import HELD, Tree
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
        doubled: names of groups that come twice; the first one is taken.
    """

    source: str = ""
    name: str = ""
    groups: Mapping[str, Group] = field(default_factory=dict)
    states: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)
    end_effectors: tuple[EndEffector, ...] = ()
    virtual_joints: tuple[VirtualJoint, ...] = ()
    passive: tuple[str, ...] = ()
    disabled: frozenset[tuple[str, str]] = frozenset()
    doubled: tuple[str, ...] = ()


def read_srdf(robot: ET.Element, source: str = "") -> Srdf:
    """Return what an SRDF's tree says.

    Raises:
        DocumentError: a name is missing, or a position isn't a number.
    """
    groups: dict[str, Group] = {}
    doubled = []
    for element in robot.findall("group"):
        group = _group(element, source)
        if groups.setdefault(group.name, group) is not group:
            doubled.append(group.name)
    virtual = tuple(
        VirtualJoint(e.get("name", ""), e.get("type", "fixed"), e.get("parent_frame", ""), e.get("child_link", ""))
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
        tuple(doubled),
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
            if joint.get("name") not in virtual and " " not in joint.get("value", "").strip()
        }  # a base that drives has three values or seven; it is held still
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


def resolve(srdf: Srdf, tree: Tree) -> dict[str, tuple[str, ...]]:
    """Return the joints of each group that can be driven, from the base on, each once.

    Fixed, virtual, passive and mimicking joints belong to none. The SRDF has to be one that `check_srdf` finds no
    error in.
    """
    mimics = tree.mimics()
    return {
        name: tuple(
            dict.fromkeys(
                joint
                for joint in _named(group, srdf, tree)
                if joint in tree.joints
                and tree.joints[joint].movable
                and joint not in mimics
                and joint not in srdf.passive
            )
        )
        for name, group in srdf.groups.items()
    }


def _named(group: Group, srdf: Srdf, tree: Tree) -> Iterator[str]:
    todo, seen = [group], {group.name}
    while todo:
        part = todo.pop()
        for base, tip in part.chains:
            yield from (joint.name for joint in tree.chain(base, tip) or ())
        yield from part.joints
        yield from (tree.above[link].name for link in part.links if link in tree.above)
        inner = [name for name in part.groups if name not in seen]
        seen.update(inner)
        todo += [srdf.groups[name] for name in reversed(inner)]


VIRTUAL_TYPES = ("fixed", "planar", "floating")


def check_srdf(srdf: Srdf, tree: Tree) -> list[Finding]:
    """Return what is wrong with an SRDF for the robot that `tree` has."""
    check = _Check(srdf, tree)
    found = [*check.groups(), *check.others()]
    if not any(f.severity == "error" for f in found):
        for name, joints in resolve(srdf, tree).items():
            if not joints:
                message = f"group {name!r} has no joint that can be driven; nothing can be planned for it"
                found.append(Finding("warning", "empty-group", message, srdf.source, srdf.groups[name].line))
    return [*found, *check.states()]


def with_known_names(srdf: Srdf, tree: Tree) -> tuple[Srdf, list[Finding]]:
    """Return an SRDF without what names links, joints or groups that aren't there, which vendors ship; and that."""
    told = [
        Finding("warning", "double-name", f"two groups are called {name!r}; the first one is taken", srdf.source)
        for name in srdf.doubled
    ]
    wrong = [f for f in check_srdf(srdf, tree) if f.severity == "error"]
    if not wrong:
        return srdf, told
    told += [replace(f, severity="warning", message=f"{f.message}; it is left out") for f in wrong]
    check = _Check(srdf, tree)
    groups = {
        name: replace(
            group,
            joints=tuple(j for j in group.joints if j in tree.joints or j in check.virtual),
            links=tuple(link for link in group.links if link in tree.links),
            chains=tuple(c for c in group.chains if not any(check.chain(group, *c))),
            groups=() if check.contains_itself(name) else tuple(g for g in group.groups if g in srdf.groups),
        )
        for name, group in srdf.groups.items()
    }
    states = {
        group: {name: {j: q for j, q in state.items() if j in tree.joints} for name, state in named.items()}
        for group, named in srdf.states.items()
        if group in groups
    }
    known = replace(
        srdf,
        groups=groups,
        states=states,
        end_effectors=tuple(
            end
            for end in srdf.end_effectors
            if {end.group, end.parent_group} <= {"", *groups} and end.parent_link in ("", *tree.links)
        ),
        virtual_joints=tuple(v for v in srdf.virtual_joints if v.child_link in tree.links and v.type in VIRTUAL_TYPES),
        passive=tuple(joint for joint in srdf.passive if joint in tree.joints),
    )
    return known, told


class _Check:
    def __init__(self, srdf: Srdf, tree: Tree):
        self.srdf, self.tree = srdf, tree
        self.virtual = {joint.name for joint in srdf.virtual_joints}

    def groups(self) -> Iterator[Finding]:
        for group in self.srdf.groups.values():
            where = f"group {group.name!r}"
            yield from self._known("joint", group.joints, {*self.tree.joints, *self.virtual}, where, group)
            yield from self._known("link", group.links, self.tree.links, where, group)
            yield from self._known("group", group.groups, self.srdf.groups, where, group)
            for chain in group.chains:
                yield from self.chain(group, *chain)
            if self.contains_itself(group.name):
                yield self._say("error", "cycle", f"{where} contains itself", group)

    def others(self) -> Iterator[Finding]:
        links, joints, groups = self.tree.links, self.tree.joints, self.srdf.groups
        for end in self.srdf.end_effectors:
            where = f"end effector {end.name!r}"
            yield from self._known("link", [end.parent_link] if end.parent_link else [], links, where)
            yield from self._known("group", [g for g in (end.group, end.parent_group) if g], groups, where)
        for joint in self.srdf.virtual_joints:
            where = f"virtual joint {joint.name!r}"
            yield from self._known("link", [joint.child_link], links, where)
            if joint.type not in VIRTUAL_TYPES:
                message = f"{where} is of type {joint.type!r} (available: {listing(VIRTUAL_TYPES)})"
                yield self._say("error", "joint-type", message)
            elif joint.type in HELD:
                yield self._say("warning", "held-joint", f"{where} is {joint.type}; GRIP holds the base still")
        yield from self._known("joint", self.srdf.passive, joints, "passive joints")
        strange = sorted({link for pair in self.srdf.disabled for link in pair} - set(links))
        if strange:
            message = f"disabled collisions name links that aren't there: {listing(strange)}; they are left out"
            yield self._say("warning", "unknown-link", message)

    def states(self) -> Iterator[Finding]:
        for group, states in self.srdf.states.items():
            yield from self._known("group", [group], self.srdf.groups, "named states")
            for name, positions in states.items():
                where = f"state {name!r} of group {group!r}"
                yield from self._known("joint", positions, self.tree.joints, where)
                for joint in (self.tree.joints[name] for name in positions if name in self.tree.joints):
                    q = positions[joint.name]
                    limited = joint.type in ("revolute", "prismatic")
                    if limited and not joint.lower - 1e-6 <= q <= joint.upper + 1e-6:
                        allowed = f"{joint.lower:g} ... {joint.upper:g}"
                        message = (
                            f"{where}: joint {joint.name!r} at {q:g} is out of its limits {allowed}; it is clamped"
                        )
                        yield self._say("warning", "out-of-limits", message)

    def chain(self, group: Group, base: str, tip: str) -> Iterator[Finding]:
        where = f"a chain of group {group.name!r}"
        wrong = list(self._known("link", (base, tip), self.tree.links, where, group))
        yield from wrong
        if not wrong and self.tree.chain(base, tip) is None:
            yield self._say("error", "no-chain", f"{where}: link {base!r} doesn't carry link {tip!r}", group)

    def contains_itself(self, name: str) -> bool:
        seen, todo = set(), [name]
        while todo:
            for inner in self.srdf.groups[todo.pop()].groups:
                if inner == name:
                    return True
                if inner in self.srdf.groups and inner not in seen:
                    seen.add(inner)
                    todo.append(inner)
        return False

    def _known(
        self, kind: str, names: Iterable[str], allowed: Iterable[str], where: str, group: Group | None = None
    ) -> Iterator[Finding]:
        allowed = list(allowed)
        for name in names:
            if name not in allowed:
                message = f"{where}: there is no {kind} {name!r}{nearest(name, allowed)}"
                yield self._say("error", f"unknown-{kind}", message, group)

    def _say(self, severity: Severity, code: str, message: str, group: Group | None = None) -> Finding:
        return Finding(severity, code, message, self.srdf.source, group.line if group else None)
