"""Everything that is wrong with an SRDF for its URDF, at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from grip_bt.base.errors import listing, nearest

from .findings import Finding, Severity
from .groups import resolve
from .srdf import Group, Srdf
from .tree import HELD, Tree

VIRTUAL_TYPES = ("fixed", "planar", "floating")


def check_srdf(srdf: Srdf, tree: Tree) -> list[Finding]:
    """Return what is wrong with an SRDF for the robot that `tree` has."""
    check = _Check(srdf, tree)
    found = [*check.groups(), *check.others()]
    if not any(f.severity == "error" for f in found):
        found += check.joints_of_groups()
    found += check.states()
    return found


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
                yield from self._chain(group, *chain)
            if self._contains_itself(group.name):
                yield self._say("error", "cycle", f"{where} is, in the end, a part of itself", group)

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
                message = f"{where} is of type {joint.type!r} (there are: {listing(VIRTUAL_TYPES)})"
                yield self._say("error", "joint-type", message)
            elif joint.type in HELD:
                yield self._say("warning", "held-joint", f"{where} is {joint.type}; GRIP holds the base still")
        yield from self._known("joint", self.srdf.passive, joints, "passive joints")
        strange = sorted({link for pair in self.srdf.disabled for link in pair} - set(links))
        if strange:
            message = f"disabled collisions name links that aren't there: {listing(strange)}; they are left out"
            yield self._say("warning", "unknown-link", message)

    def joints_of_groups(self) -> Iterator[Finding]:
        for name, joints in resolve(self.srdf, self.tree).items():
            group = self.srdf.groups[name]
            if not joints:
                message = f"group {name!r} has no joint that can be driven; nothing can be planned for it"
                yield self._say("warning", "empty-group", message, group)

    def states(self) -> Iterator[Finding]:
        for group, states in self.srdf.states.items():
            yield from self._known("group", [group], self.srdf.groups, "named states")
            for name, positions in states.items():
                where = f"state {name!r} of group {group!r}"
                yield from self._known("joint", positions, self.tree.joints, where)
                yield from self._within(where, positions.items())

    def _within(self, where: str, positions: Iterable[tuple[str, float]]) -> Iterator[Finding]:
        for name, position in positions:
            joint = self.tree.joints.get(name)
            if joint is None or joint.type not in ("revolute", "prismatic"):
                continue
            if not joint.lower - 1e-6 <= position <= joint.upper + 1e-6:
                allowed = f"{joint.lower:g} ... {joint.upper:g}"
                message = f"{where}: joint {name!r} at {position:g} is out of its limits {allowed}; it is put inside"
                yield self._say("warning", "out-of-limits", message)

    def _chain(self, group: Group, base: str, tip: str) -> Iterator[Finding]:
        where = f"a chain of group {group.name!r}"
        wrong = list(self._known("link", (base, tip), self.tree.links, where, group))
        yield from wrong
        if not wrong and self.tree.chain(base, tip) is None:
            yield self._say("error", "no-chain", f"{where}: link {base!r} doesn't carry link {tip!r}", group)

    def _contains_itself(self, name: str) -> bool:
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
