"""Everything that is wrong with a URDF, at once: its joints, the masses and the shapes of its links."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grip_bt.base.errors import DocumentError, MissingPartError, listing, nearest

from .files import Finding, Severity
from .packages import Packages
from .tree import HELD, JOINT_TYPES, MOVABLE
from .xml import line_of, numbers

SHAPES = {"box": ("size", 3), "cylinder": ("length", 1), "sphere": ("radius", 1), "mesh": ("scale", 3)}
FORMATS = (".dae", ".obj", ".ply", ".stl")
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def check_link(link: ET.Element, reporter: Reporter) -> Iterator[Finding]:
    """Yield what is wrong with a link."""
    name = link.get("name", "")
    for inertial in link.findall("inertial")[:1]:
        yield from _inertial(inertial, name, reporter)
    for tag in ("collision", "visual"):
        for body in link.findall(tag):
            yield from _body(body, tag, name, reporter)


def _inertial(inertial: ET.Element, name: str, reporter: Reporter) -> Iterator[Finding]:
    yield from reporter.check_origin(inertial)
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        tag = "mass" if mass is None else "inertia"
        yield reporter.error("bad-inertia", f"the <inertial> of link {name!r} has no <{tag}>", inertial)
        return
    wrong = list(reporter.check_numbers(mass, "value", 1, ""))
    wrong += [f for attribute in _INERTIA for f in reporter.check_numbers(inertia, attribute, 1, "")]
    yield from wrong
    if wrong:
        return
    value = numbers(mass, "value", 1, "")[0]
    if value < 0:
        yield reporter.error("bad-inertia", f"link {name!r} has a mass of {value:g} kg", mass)
    elif value == 0:
        yield reporter.warning("no-mass", f"link {name!r} has no mass; leave <inertial> out where that is meant", mass)
    else:
        yield from _moments(inertia, name, reporter)


def _moments(inertia: ET.Element, name: str, reporter: Reporter) -> Iterator[Finding]:
    xx, yy, zz, xy, xz, yz = (numbers(inertia, attribute, 1, "0")[0] for attribute in _INERTIA)
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if moments[0] <= 0:
        yield reporter.error(
            "bad-inertia",
            f"link {name!r} has a principal moment of inertia of {moments[0]:.3g} kg m^2; all have to be positive",
            inertia,
        )
    elif moments[2] > 1.01 * (moments[0] + moments[1]):
        yield reporter.warning(
            "odd-inertia",
            f"no body has the moments of inertia of link {name!r}: the largest, {moments[2]:.3g}, exceeds the sum of "
            "the others",
            inertia,
        )


def _body(body: ET.Element, tag: str, link: str, reporter: Reporter) -> Iterator[Finding]:
    yield from reporter.check_origin(body)
    geometry = body.find("geometry")
    shapes = [] if geometry is None else [shape for shape in geometry if shape.tag in SHAPES]
    if not shapes:
        odd = (
            "no <geometry>" if geometry is None else f"<{geometry[0].tag}>" if len(geometry) else "an empty <geometry>"
        )
        yield reporter.error(
            "bad-shape", f"a <{tag}> of link {link!r} has {odd}; it has to be one of: {listing(SHAPES)}", body
        )
    for shape in shapes[:1]:
        yield from _shape(shape, tag, link, reporter)


def _shape(shape: ET.Element, tag: str, link: str, reporter: Reporter) -> Iterator[Finding]:
    attribute, count = SHAPES[shape.tag]
    default = "1 1 1" if shape.tag == "mesh" else ""
    sizes = [(attribute, count)] + ([("radius", 1)] if shape.tag == "cylinder" else [])
    for name, many in sizes:
        wrong = list(reporter.check_numbers(shape, name, many, default))
        yield from wrong
        if not wrong and not all(v > 0 or (shape.tag == "mesh" and v) for v in numbers(shape, name, many, default)):
            yield reporter.error(
                "bad-shape", f"the {name} of a {shape.tag} of link {link!r} is {shape.get(name)!r}", shape
            )
    if shape.tag == "mesh":
        yield from _mesh(shape, tag, link, reporter)


def _mesh(mesh: ET.Element, tag: str, link: str, reporter: Reporter) -> Iterator[Finding]:
    severity: Severity = "error" if tag == "collision" else "warning"  # what is only seen isn't needed to plan
    name = mesh.get("filename", "")
    try:
        path = reporter.packages.resolve(name, reporter.folder)
    except MissingPartError as error:
        yield reporter.say(severity, "missing-package", f"mesh {name!r} of link {link!r}: {error}", mesh)
        return
    if path.suffix.lower() not in FORMATS:
        yield reporter.say(
            severity, "mesh-format", f"mesh {name!r} of link {link!r} isn't one of: {listing(FORMATS)}", mesh
        )
    elif not path.is_file():
        yield reporter.say(
            severity, "missing-mesh", f"link {link!r}: there is no mesh {name!r} (looked for {path})", mesh
        )


DEEPEST = 500
"""Joints from the base to a tip."""


@dataclass(frozen=True)
class Reporter:
    """Makes findings about one file.

    Attributes:
        source: the file.
        packages: where meshes are looked for.
    """

    source: str
    packages: Packages

    @property
    def folder(self) -> Path:
        """The folder that relative paths start in."""
        return Path(self.source).parent

    def say(self, severity: Severity, code: str, message: str, element: ET.Element) -> Finding:
        """Return a finding about an element."""
        return Finding(severity, code, message, self.source, line_of(element))

    def error(self, code: str, message: str, element: ET.Element) -> Finding:
        """Return an error about an element."""
        return self.say("error", code, message, element)

    def warning(self, code: str, message: str, element: ET.Element) -> Finding:
        """Return a warning about an element."""
        return self.say("warning", code, message, element)

    def check_numbers(self, element: ET.Element, attribute: str, count: int, default: str) -> Iterator[Finding]:
        """Yield a finding unless an attribute holds so many finite numbers."""
        try:
            numbers(element, attribute, count, default, self.source)
        except DocumentError as error:
            yield self.error("bad-number", error.message, element)

    def check_origin(self, element: ET.Element) -> Iterator[Finding]:
        """Yield what is wrong with where an element says that it is."""
        for origin in element.findall("origin")[:1]:
            yield from self.check_numbers(origin, "xyz", 3, "0 0 0")
            yield from self.check_numbers(origin, "rpy", 3, "0 0 0")


def check_urdf(robot: ET.Element, source: str, packages: Packages) -> list[Finding]:
    """Return what is wrong with a URDF.

    Args:
        source: the file; relative mesh paths start in its folder.
        packages: where `package://` meshes are looked for.
    """
    reporter = Reporter(source, packages)
    found: list[Finding] = []
    if not robot.get("name"):
        found.append(reporter.warning("no-name", "<robot> has no name; it is called 'robot'", robot))
    links = list(_names(robot, "link", reporter, found))
    joints = list(_names(robot, "joint", reporter, found))
    if not links:
        found.append(reporter.error("no-links", "the robot has no links", robot))
        return found
    for link in robot.findall("link"):
        found += check_link(link, reporter)
    for joint in robot.findall("joint"):
        found += _joint(joint, set(links), joints, reporter)
    found += _structure(robot, links, reporter)
    return found


def _names(robot: ET.Element, tag: str, reporter: Reporter, found: list[Finding]) -> Iterator[str]:
    seen = set()
    for element in robot.findall(tag):
        name = element.get("name", "").strip()
        if not name:
            found.append(reporter.error("no-name", f"a <{tag}> has no name", element))
        elif name in seen:
            found.append(reporter.error("double-name", f"two {tag}s are called {name!r}; rename one", element))
        seen.add(name)
        yield name


def _joint(joint: ET.Element, links: set[str], joints: list[str], reporter: Reporter) -> Iterator[Finding]:
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind not in JOINT_TYPES:
        yield reporter.error(
            "joint-type",
            f"joint {name!r} is of the unknown type {kind!r}{nearest(kind, JOINT_TYPES)} (available: "
            f"{listing(JOINT_TYPES)})",
            joint,
        )
    if kind in HELD:
        yield reporter.warning("held-joint", f"joint {name!r} is {kind}; GRIP holds it still", joint)
    for tag in ("parent", "child"):
        end = joint.find(tag)
        link = "" if end is None else end.get("link", "")
        if link not in links:
            known = f"link {link!r}, which isn't there{nearest(link, links)}" if link else "no link"
            yield reporter.error("unknown-link", f"the {tag} of joint {name!r} is {known}", joint)
    yield from reporter.check_origin(joint)
    if kind in MOVABLE:
        yield from _axis(joint, name, reporter)
        yield from _limit(joint, name, kind, reporter)
    yield from _mimic(joint, name, joints, reporter)


def _axis(joint: ET.Element, name: str, reporter: Reporter) -> Iterator[Finding]:
    if (axis := joint.find("axis")) is None:
        return
    wrong = list(reporter.check_numbers(axis, "xyz", 3, "1 0 0"))
    yield from wrong
    if not wrong and not any(numbers(axis, "xyz", 3, "1 0 0")):
        yield reporter.error("zero-axis", f"the axis of joint {name!r} is 0 0 0", axis)


def _limit(joint: ET.Element, name: str, kind: str, reporter: Reporter) -> Iterator[Finding]:
    limit = joint.find("limit")
    unit = "m" if kind == "prismatic" else "rad"
    if limit is None:
        severity: Severity = "warning" if kind == "continuous" else "error"
        yield reporter.say(
            severity,
            "missing-limit",
            f'joint {name!r} has no <limit>; add <limit lower="..." upper="..." velocity="..." effort="..."/> [{unit}]',
            joint,
        )
        return
    wrong = [f for a in ("lower", "upper", "velocity", "effort") for f in reporter.check_numbers(limit, a, 1, "0")]
    yield from wrong
    if wrong:
        return
    lower, upper, velocity, effort = (numbers(limit, a, 1, "0")[0] for a in ("lower", "upper", "velocity", "effort"))
    if kind != "continuous" and not lower < upper:
        missing = [a for a in ("lower", "upper") if a not in limit.attrib]
        why = f"it lacks {' and '.join(missing)}" if missing else f"lower {lower:g} isn't below upper {upper:g}"
        yield reporter.error("missing-limit", f"joint {name!r} can't move: {why} [{unit}]", limit)
    if velocity <= 0:
        yield reporter.error(
            "missing-limit",
            f"joint {name!r} has no velocity limit above zero [{unit}/s]; motions can't be timed",
            limit,
        )
    if effort <= 0:
        yield reporter.warning("no-effort", f"joint {name!r} has no effort limit; simulation takes 100", limit)


def _mimic(joint: ET.Element, name: str, joints: list[str], reporter: Reporter) -> Iterator[Finding]:
    mimic = joint.find("mimic")
    if mimic is None:
        return
    yield from reporter.check_numbers(mimic, "multiplier", 1, "1")
    yield from reporter.check_numbers(mimic, "offset", 1, "0")
    leader = mimic.get("joint", "")
    if leader not in joints:
        yield reporter.error(
            "unknown-joint",
            f"joint {name!r} mimics {leader!r}, which isn't there{nearest(leader, joints)}",
            mimic,
        )


def _structure(robot: ET.Element, links: list[str], reporter: Reporter) -> Iterator[Finding]:
    """Yield what keeps links and joints from being one tree, and mimics from ending at a joint that leads."""
    above: dict[str, str] = {}
    for joint in robot.findall("joint"):
        parent, child = ((e.get("link", "") if (e := joint.find(t)) is not None else "") for t in ("parent", "child"))
        if child in above:
            yield reporter.error("two-parents", f"link {child!r} has two parent joints; a robot is a tree", joint)
        elif child:
            above[child] = parent
    roots = [link for link in dict.fromkeys(links) if link not in above]
    if len(roots) > 1:
        yield reporter.error(
            "two-roots", f"these links have no parent: {listing(roots)}; connect them with fixed joints", robot
        )
    for link in links:
        depth, at = 0, link
        while at in above and depth <= DEEPEST:
            at, depth = above[at], depth + 1
        if depth > DEEPEST:
            deep = f"link {link!r} hangs more than {DEEPEST} joints deep"
            yield reporter.error("cycle", _loop_above(at, above, links) or deep, robot)
            return
    yield from _mimic_loops(robot, reporter)


def _loop_above(link: str, above: Mapping[str, str], links: Sequence[str]) -> str:
    """Tell the loop that is met on the way up from a link; empty where it ends at a root."""
    seen: list[str] = []
    while link in above and link not in seen:
        seen.append(link)
        link = above[link]
    if link not in above:
        return ""
    loop = seen[seen.index(link) :][::-1]
    order = {name: k for k, name in enumerate(links)}
    first = min(range(len(loop)), key=lambda k: order.get(loop[k], len(order)))
    loop = [*loop[first:], *loop[: first + 1]]
    shown = loop if len(loop) <= 8 else [*loop[:4], "...", *loop[-3:]]
    return f"these links carry one another in a loop: {' -> '.join(shown)}; a robot is a tree, take out one joint"


def _mimic_loops(robot: ET.Element, reporter: Reporter) -> Iterator[Finding]:
    leads = {
        j.get("name", ""): m.get("joint", "") for j in robot.findall("joint") if (m := j.find("mimic")) is not None
    }
    kinds = {j.get("name", ""): j.get("type", "") for j in robot.findall("joint")}
    for joint in robot.findall("joint"):
        name = at = joint.get("name", "")
        seen = set()
        while at in leads and at not in seen:
            seen.add(at)
            at = leads[at]
        if at in leads:
            yield reporter.error("cycle", f"joint {name!r} mimics itself through a chain", joint)
        elif at != name and kinds.get(at) in ("fixed", *HELD):
            yield reporter.error("fixed-leader", f"joint {name!r} mimics {at!r}, which never moves", joint)
