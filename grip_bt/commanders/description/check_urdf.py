"""Everything that is wrong with a URDF, at once: its joints, the masses and the shapes of its links.

What vendors ship and simulators shrug at is put right by a rule, in the tree itself, and told as a warning.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError, MissingPartError, listing, nearest

from .files import Finding, Severity
from .packages import Packages
from .tree import HELD, JOINT_TYPES, MOVABLE
from .xml import line_of, numbers

SHAPES = {"box": ("size", 3), "cylinder": ("length", 1), "sphere": ("radius", 1), "mesh": ("scale", 3)}
FORMATS = (".dae", ".obj", ".ply", ".stl")
NO_SPEED = {"rad": 1.0, "m": 0.1}
"""Velocity limits [rad/s, m/s] of joints that have none."""
NO_EFFORT = {"rad": 1000.0, "m": 100.0}
"""Effort limits [N m, N] of joints that have none: what moves an industrial arm; fingers' drives give less."""
NO_LIMIT = {"rad": math.pi, "m": 0.5}
"""How far joints without limits move to both sides [rad, m]."""
BALL = 0.02
"""Radius [m] of the ball whose inertia a link gets that has none."""
INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def _link(link: ET.Element, report: _Report) -> None:
    name = link.get("name", "")
    for inertial in link.findall("inertial")[:1]:
        _inertial(link, inertial, name, report)
    for tag in ("collision", "visual"):
        for body in link.findall(tag):
            _body(link, body, name, report)


def _inertial(link: ET.Element, inertial: ET.Element, name: str, report: _Report) -> None:
    report.check_origin(inertial)
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        tag = "mass" if mass is None else "inertia"
        report.warning("no-mass", f"the <inertial> of link {name!r} has no <{tag}>; it is left out", inertial)
        link.remove(inertial)
        return
    value, *moments = (
        report.numbers(mass, "value", 1, ""),
        *(report.numbers(inertia, attribute, 1, "") for attribute in INERTIA),
    )
    if not value or not all(moments):
        return
    if value[0] < 0:
        report.warning("no-mass", f"link {name!r} has a mass of {value[0]:g} kg; its <inertial> is left out", mass)
        link.remove(inertial)
    elif value[0] == 0:
        report.warning("no-mass", f"link {name!r} has no mass; leave <inertial> out where that is meant", mass)
    else:
        _moments(inertia, [each[0] for each in moments], name, report)


def principal_moments(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> Array:
    """Return the principal moments of an inertia [kg m^2], the least first."""
    return np.asarray(np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), dtype=float)


def _moments(inertia: ET.Element, values: list[float], name: str, report: _Report) -> None:
    xx, yy, zz, xy, xz, yz = values
    moments = principal_moments(xx, yy, zz, xy, xz, yz)
    if moments[0] <= 0:
        taken = f"those of a ball of its mass with a radius of {BALL:g} m are taken"
        report.warning(
            "no-inertia",
            f"link {name!r} has a principal moment of inertia of {moments[0]:.3g} kg m^2, which no body has; {taken}",
            inertia,
        )
    elif moments[2] > 1.01 * (moments[0] + moments[1]):
        report.warning(
            "odd-inertia",
            f"no body has the moments of inertia of link {name!r}: the largest, {moments[2]:.3g}, exceeds the sum of "
            "the others",
            inertia,
        )


def _body(link: ET.Element, body: ET.Element, name: str, report: _Report) -> None:
    report.check_origin(body)
    geometry = body.find("geometry")
    shapes = [] if geometry is None else [shape for shape in geometry if shape.tag in SHAPES]
    if not shapes:
        odd = (
            "no <geometry>" if geometry is None else f"<{geometry[0].tag}>" if len(geometry) else "an empty <geometry>"
        )
        message = f"a <{body.tag}> of link {name!r} has {odd}, none of: {listing(SHAPES)}; it is left out"
        report.warning("bad-shape", message, body)
        link.remove(body)
        return
    shape = shapes[0]
    sizes = [SHAPES[shape.tag]] + ([("radius", 1)] if shape.tag == "cylinder" else [])
    for size, count in sizes:
        values = report.numbers(shape, size, count, "1 1 1" if shape.tag == "mesh" else "")
        if values and not all(v > 0 or (shape.tag == "mesh" and v) for v in values):
            message = f"the {size} of a {shape.tag} of link {name!r} is {shape.get(size)!r}; it is left out"
            report.warning("bad-shape", message, shape)
            link.remove(body)
            return
    if shape.tag == "mesh" and (fault := _fault_of_mesh(shape, report)) is not None:
        code, message = fault
        report.warning(code, f"link {name!r}: {message}; {_without(link, body, report)}", shape)


def _without(link: ET.Element, body: ET.Element, report: _Report) -> str:
    """Take out what has no mesh, or put the shape that is seen in its place where it is for collisions; say which."""
    at = list(link).index(body)
    link.remove(body)
    for seen in link.findall("visual") if body.tag == "collision" else ():
        mesh = seen.find("geometry/mesh")
        if mesh is not None and _fault_of_mesh(mesh, report) is None:
            taken = copy.deepcopy(seen)
            taken.tag = "collision"
            link.insert(at, taken)
            return "the mesh that is seen is taken"
    return "it is left out" if body.tag == "visual" else "it is left out, and nothing keeps clear of it"


def _fault_of_mesh(mesh: ET.Element, report: _Report) -> tuple[str, str] | None:
    """Return what keeps a mesh from being read, as a code and a message."""
    name = mesh.get("filename", "")
    try:
        path = report.packages.resolve(name, Path(report.source).parent)
    except MissingPartError as error:
        return "missing-package", f"mesh {name!r}: {error}".rstrip(".")
    if path.suffix.lower() not in FORMATS:
        return "mesh-format", f"mesh {name!r} isn't one of: {listing(FORMATS)}"
    if not path.is_file():
        return "missing-mesh", f"there is no mesh {name!r} (looked for {path})"
    with path.open("rb") as file:
        if (begin := file.read(len(_POINTER))) == _POINTER or not begin:
            return "missing-mesh", f"the mesh {name!r} wasn't downloaded: {path} is a pointer of Git LFS, or empty"
    return None


_POINTER = b"version https://git-lfs"
DEEPEST = 500
"""Joints from the base to a tip."""


class _Report:
    """What is found about one file."""

    def __init__(self, source: str, packages: Packages):
        self.source, self.packages = source, packages
        self.found: list[Finding] = []

    def say(self, severity: Severity, code: str, message: str, element: ET.Element) -> None:
        self.found.append(Finding(severity, code, message, self.source, line_of(element)))

    def error(self, code: str, message: str, element: ET.Element) -> None:
        self.say("error", code, message, element)

    def warning(self, code: str, message: str, element: ET.Element) -> None:
        self.say("warning", code, message, element)

    def numbers(self, element: ET.Element, attribute: str, count: int, default: str) -> tuple[float, ...]:
        """Return so many finite numbers of an attribute; none, and it is said, where it doesn't hold them."""
        try:
            return numbers(element, attribute, count, default, self.source)
        except DocumentError as error:
            self.error("bad-number", error.message, element)
            return ()

    def check_origin(self, element: ET.Element) -> None:
        for origin in element.findall("origin")[:1]:
            self.numbers(origin, "xyz", 3, "0 0 0")
            self.numbers(origin, "rpy", 3, "0 0 0")


def check_urdf(robot: ET.Element, source: str, packages: Packages) -> list[Finding]:
    """Return what is wrong with a URDF.

    Args:
        source: the file; relative mesh paths start in its folder.
        packages: where `package://` meshes are looked for.
    """
    report = _Report(source, packages)
    if not robot.get("name"):
        report.warning("no-name", "<robot> has no name; it is called 'robot'", robot)
    links, joints = _names(robot, "link", report), _names(robot, "joint", report)
    if not links:
        report.error("no-links", "the robot has no links", robot)
        return report.found
    for link in robot.findall("link"):
        _link(link, report)
    for joint in robot.findall("joint"):
        _joint(joint, set(links), joints, report)
    _structure(robot, links, report)
    return report.found


def _names(robot: ET.Element, tag: str, report: _Report) -> list[str]:
    names: list[str] = []
    for element in robot.findall(tag):
        name = element.get("name", "").strip()
        if not name:
            report.error("no-name", f"a <{tag}> has no name", element)
        elif name in names:
            report.error("double-name", f"two {tag}s are called {name!r}; rename one", element)
        names.append(name)
    return names


def _joint(joint: ET.Element, links: set[str], joints: list[str], report: _Report) -> None:
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind not in JOINT_TYPES:
        report.error(
            "joint-type",
            f"joint {name!r} is of the unknown type {kind!r}{nearest(kind, JOINT_TYPES)} (available: "
            f"{listing(JOINT_TYPES)})",
            joint,
        )
    if kind in HELD:
        report.warning("held-joint", f"joint {name!r} is {kind}; GRIP holds it still", joint)
    for tag in ("parent", "child"):
        end = joint.find(tag)
        link = "" if end is None else end.get("link", "")
        if link not in links:
            known = f"link {link!r}, which isn't there{nearest(link, links)}" if link else "no link"
            report.error("unknown-link", f"the {tag} of joint {name!r} is {known}", joint)
    report.check_origin(joint)
    if kind in MOVABLE:
        _axis(joint, name, report)
        _limit(joint, name, kind, report)
    _mimic(joint, name, joints, report)


def _axis(joint: ET.Element, name: str, report: _Report) -> None:
    if (axis := joint.find("axis")) is None:
        return
    values = report.numbers(axis, "xyz", 3, "1 0 0")
    if values and not any(values):
        report.warning("zero-axis", f"the axis of joint {name!r} is 0 0 0; it is held still", axis)
        joint.set("type", "fixed")


def _limit(joint: ET.Element, name: str, kind: str, report: _Report) -> None:
    limit = joint.find("limit")
    unit = "m" if kind == "prismatic" else "rad"
    if limit is None:
        reach = "" if kind == "continuous" else f" -{NO_LIMIT[unit]:.4g} ... {NO_LIMIT[unit]:.4g} {unit} are taken;"
        report.warning(
            "missing-limit",
            f"joint {name!r} has no <limit>;{reach} add "
            f'<limit lower="..." upper="..." velocity="..." effort="..."/> [{unit}]',
            joint,
        )
        if kind != "continuous":
            ET.SubElement(joint, "limit", lower=repr(-NO_LIMIT[unit]), upper=repr(NO_LIMIT[unit]))
        return
    values = [report.numbers(limit, a, 1, "0") for a in ("lower", "upper", "velocity", "effort")]
    if not all(values):
        return
    lower, upper, velocity, effort = (each[0] for each in values)
    if kind != "continuous" and not lower < upper:
        missing = [a for a in ("lower", "upper") if a not in limit.attrib]
        why = f"it lacks {' and '.join(missing)}" if missing else f"lower {lower:g} isn't below upper {upper:g}"
        done = "they are swapped" if lower > upper else "it is held still"
        report.warning("missing-limit", f"joint {name!r} can't move: {why} [{unit}]; {done}", limit)
        if lower > upper:
            limit.attrib.update(lower=repr(upper), upper=repr(lower))
        else:
            joint.set("type", "fixed")
            return
    if velocity <= 0:
        taken = f"{NO_SPEED[unit]:g} {unit}/s is taken, unless joint_limits.yaml has one"
        report.warning("no-speed", f"joint {name!r} has no velocity limit above zero; {taken}", limit)
    if effort <= 0:
        taken = f"simulation takes {NO_EFFORT[unit]:g}"
        report.warning("no-effort", f"joint {name!r} has no effort limit above zero; {taken}", limit)


def _mimic(joint: ET.Element, name: str, joints: list[str], report: _Report) -> None:
    mimic = joint.find("mimic")
    if mimic is None:
        return
    report.numbers(mimic, "multiplier", 1, "1")
    report.numbers(mimic, "offset", 1, "0")
    leader = mimic.get("joint", "")
    if leader not in joints:
        report.warning(
            "unknown-joint",
            f"joint {name!r} mimics {leader!r}, which isn't there{nearest(leader, joints)}; it leads itself",
            mimic,
        )
        joint.remove(mimic)


def _structure(robot: ET.Element, links: list[str], report: _Report) -> None:
    """Report what keeps links and joints from being one tree, and mimics from ending at a joint that leads."""
    above: dict[str, str] = {}
    for joint in robot.findall("joint"):
        parent, child = ((e.get("link", "") if (e := joint.find(t)) is not None else "") for t in ("parent", "child"))
        if child in above:
            report.error("two-parents", f"link {child!r} has two parent joints; a robot is a tree", joint)
        elif child:
            above[child] = parent
    roots = [link for link in dict.fromkeys(links) if link not in above]
    if len(roots) > 1:
        report.error(
            "two-roots", f"these links have no parent: {listing(roots)}; connect them with fixed joints", robot
        )
    for link in links:
        depth, at = 0, link
        while at in above and depth <= DEEPEST:
            at, depth = above[at], depth + 1
        if depth > DEEPEST:
            deep = f"link {link!r} hangs more than {DEEPEST} joints deep"
            report.error("cycle", _loop_above(at, above, links) or deep, robot)
            return
    _mimic_loops(robot, report)


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


def _mimic_loops(robot: ET.Element, report: _Report) -> None:
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
            report.error("cycle", f"joint {name!r} mimics itself through a chain", joint)
        elif at != name and kinds.get(at) in ("fixed", *HELD):
            report.warning("fixed-leader", f"joint {name!r} mimics {at!r}, which never moves; it is held still", joint)
            joint.remove(next(joint.iterfind("mimic")))
            joint.set("type", "fixed")
