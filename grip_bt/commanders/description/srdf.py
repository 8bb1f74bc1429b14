"""SRDF: what a URDF says nothing about, its groups as joints of the robot's tree, and all that is wrong with it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from grip_bt.base.errors import listing, nearest
from grip_bt.base.issue import Issue, Severity

from .files import errors, robot_issue
from .robot import EndEffector
from .tree import HELD, Tree, loop_in
from .xml import line_of, numbers, required


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


@dataclass(frozen=True)
class Srdf:
    """What an SRDF says.

    Attributes:
        source: the file; empty for one that was made up.
        groups: name -> group.
        states: group -> name -> joint -> position [rad or m].
        end_effectors: in the file's order.
        virtual_joints: how the robot's base stands in the world: name -> type.
        passive: joints that nobody drives.
        disabled: pairs of links that may touch, each sorted.
        doubled: names of groups that come twice; the first one is taken.
    """

    source: str = ""
    groups: Mapping[str, Group] = field(default_factory=dict)
    states: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)
    end_effectors: tuple[EndEffector, ...] = ()
    virtual_joints: Mapping[str, str] = field(default_factory=dict)
    passive: tuple[str, ...] = ()
    disabled: frozenset[tuple[str, str]] = frozenset()
    doubled: tuple[str, ...] = ()


def read_srdf(robot: ET.Element, source: str = "") -> Srdf:
    """Return what an SRDF's tree says. Raises DocumentError: a name is missing, or a position isn't a number."""
    groups: dict[str, Group] = {}
    doubled = []
    for element in robot.findall("group"):
        group = _group(element, source)
        if groups.setdefault(group.name, group) is not group:
            doubled.append(group.name)
    virtual = {e.get("name", ""): e.get("type", "fixed") for e in robot.findall("virtual_joint")}
    return Srdf(
        source,
        groups,
        _states(robot, virtual, source),
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


def _states(robot: ET.Element, virtual: Container[str], source: str) -> dict[str, dict[str, dict[str, float]]]:
    states: dict[str, dict[str, dict[str, float]]] = {}
    for element in robot.findall("group_state"):
        group, name = required(element, "group", source), required(element, "name", source)
        positions = {
            required(joint, "name", source): numbers(joint, "value", 1, "", source)[0]
            for joint in element.findall("joint")
            if joint.get("name") not in virtual and " " not in joint.get("value", "").strip()
        }  # a base that drives has three values or seven; it is held still
        states.setdefault(group, {})[name] = positions
    return states


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


def check_srdf(srdf: Srdf, tree: Tree) -> list[Issue]:
    """Return what is wrong with an SRDF for the robot that `tree` has."""
    return _Known(srdf, tree).found


def with_known_names(srdf: Srdf, tree: Tree) -> tuple[Srdf, list[Issue]]:
    """Return an SRDF without what names links, joints or groups that aren't there, which vendors ship; and that."""
    told = [
        robot_issue("warning", "double-name", f"two groups are called {name!r}; the first one is taken", srdf.source)
        for name in srdf.doubled
    ]
    known = _Known(srdf, tree)
    told += [replace(f, severity="warning", message=f"{f.message}; it is left out") for f in errors(known.found)]
    return known.srdf, told


class _Known:
    """What of an SRDF is there, and what is wrong with the rest."""

    def __init__(self, srdf: Srdf, tree: Tree):
        self.source, self.tree, self.found = srdf.source, tree, list[Issue]()
        joints, links = tree.joints, tree.links
        inner, looped = {name: group.groups for name, group in srdf.groups.items()}, set[str]()
        while loop := loop_in(inner):
            looped.update(loop)
            inner |= dict.fromkeys(loop, ())
        groups = {}
        for name, group in srdf.groups.items():
            where = f"group {name!r}"
            groups[name] = replace(
                group,
                joints=self.known("joint", group.joints, {*joints, *srdf.virtual_joints}, where, group),
                links=self.known("link", group.links, links, where, group),
                groups=self.known("group", group.groups, srdf.groups, where, group),
                chains=tuple(chain for chain in group.chains if self.carries(chain, group)),
            )
            if name in looped:
                self.say("error", "cycle", f"{where} contains itself", group)
                groups[name] = replace(groups[name], groups=())
        ends = []
        for end in srdf.end_effectors:
            where, mine = f"end effector {end.name!r}", [g for g in (end.group, end.parent_group) if g]
            there = self.known("link", [end.parent_link] if end.parent_link else [], links, where)
            if len(there) == bool(end.parent_link) and len(self.known("group", mine, groups, where)) == len(mine):
                ends.append(end)
        for name, kind in srdf.virtual_joints.items():
            if kind in HELD:
                self.say("warning", "held-joint", f"virtual joint {name!r} is {kind}; GRIP holds the base still")
        passive = self.known("joint", srdf.passive, joints, "passive joints")
        if strange := sorted({link for pair in srdf.disabled for link in pair} - set(links)):
            message = f"disabled collisions name links that aren't there: {listing(strange)}; they are left out"
            self.say("warning", "unknown-link", message)
        if not errors(self.found):
            for name, driven in resolve(srdf, tree).items():
                if not driven:
                    message = f"group {name!r} has no joint that can be driven; nothing can be planned for it"
                    self.say("warning", "empty-group", message, groups[name])
        states = {
            group: {name: self.state(positions, f"state {name!r} of group {group!r}") for name, positions in of.items()}
            for group, of in srdf.states.items()
            if self.known("group", [group], groups, "named states")
        }
        self.srdf = replace(srdf, groups=groups, states=states, end_effectors=tuple(ends), passive=passive)

    def carries(self, chain: tuple[str, str], group: Group) -> bool:
        base, tip = chain
        where = f"a chain of group {group.name!r}"
        if len(self.known("link", chain, self.tree.links, where, group)) < 2:
            return False
        if self.tree.chain(base, tip) is None:
            self.say("error", "no-chain", f"{where}: link {base!r} doesn't carry link {tip!r}", group)
            return False
        return True

    def state(self, positions: Mapping[str, float], where: str) -> dict[str, float]:
        known = {name: positions[name] for name in self.known("joint", positions, self.tree.joints, where)}
        for name, q in known.items():
            joint = self.tree.joints[name]
            if joint.type in ("revolute", "prismatic") and not joint.lower - 1e-6 <= q <= joint.upper + 1e-6:
                allowed = f"{joint.lower:g} ... {joint.upper:g}"
                message = f"{where}: joint {name!r} at {q:g} is out of its limits {allowed}; it is clamped"
                self.say("warning", "out-of-limits", message)
        return known

    def known(
        self, kind: str, names: Iterable[str], allowed: Iterable[str], where: str, group: Group | None = None
    ) -> tuple[str, ...]:
        """Return those of some names that are allowed; it is said of the others."""
        names, allowed = tuple(names), list(allowed)
        for name in names:
            if name not in allowed:
                message = f"{where}: there is no {kind} {name!r}{nearest(name, allowed)}"
                self.say("error", f"unknown-{kind}", message, group)
        return tuple(name for name in names if name in allowed)

    def say(self, severity: Severity, code: str, message: str, group: Group | None = None) -> None:
        self.found.append(robot_issue(severity, code, message, self.source, group.line if group else None))
