"""Everything that is wrong with a URDF, at once: its joints, the masses and the shapes of its links.

What vendors ship and simulators shrug at is put right by a rule, in the tree itself, and told as a warning.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError, MissingPartError, listing, nearest
from grip_bt.base.issue import Issue

from .files import robot_issue
from .packages import Packages
from .tree import HELD, JOINT_TYPES, MOVABLE, link_at, loop_in
from .xml import line_of, numbers

SHAPES = {
    "box": [("size", 3)],
    "cylinder": [("length", 1), ("radius", 1)],
    "sphere": [("radius", 1)],
    "mesh": [("scale", 3)],
}
"""Shape -> its sizes, and how many numbers each takes."""
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

_POINTER = b"version https://git-lfs"
DEEPEST = 500
"""Joints from the base to a tip."""


def check_urdf(robot: ET.Element, source: str, packages: Packages) -> list[Issue]:
    """Return what is wrong with a URDF.

    Args:
        source: the file; relative mesh paths start in its folder.
        packages: where `package://` meshes are looked for.
    """
    check = _Check(source, packages)
    if not robot.get("name"):
        check.warning("no-name", "<robot> has no name; it is called 'robot'", robot)
    links, joints = check.names(robot, "link"), check.names(robot, "joint")
    if not links:
        check.error("no-links", "the robot has no links", robot)
        return check.found
    for link in robot.findall("link"):
        for inertial in link.findall("inertial")[:1]:
            check.inertial(link, inertial, link.get("name", ""))
        for body in (*link.findall("collision"), *link.findall("visual")):
            check.body(link, body, link.get("name", ""))
    for joint in robot.findall("joint"):
        check.joint(joint, set(links), joints)
    check.structure(robot, links)
    return check.found


def principal_moments(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> Array:
    """Return the principal moments of an inertia [kg m^2], the least first."""
    return np.asarray(np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), dtype=float)


class _Check:
    """What is found about one file."""

    def __init__(self, source: str, packages: Packages):
        self.source, self.packages = source, packages
        self.found: list[Issue] = []

    def error(self, code: str, message: str, element: ET.Element) -> None:
        self.found.append(robot_issue("error", code, message, self.source, line_of(element)))

    def warning(self, code: str, message: str, element: ET.Element) -> None:
        self.found.append(robot_issue("warning", code, message, self.source, line_of(element)))

    def names(self, robot: ET.Element, tag: str) -> list[str]:
        names: list[str] = []
        for element in robot.findall(tag):
            name = element.get("name", "").strip()
            if not name:
                self.error("no-name", f"a <{tag}> has no name", element)
            elif name in names:
                self.error("double-name", f"two {tag}s are called {name!r}; rename one", element)
            names.append(name)
        return names

    def numbers(self, element: ET.Element, attribute: str, count: int, default: str) -> tuple[float, ...]:
        """Return an attribute as `count` finite numbers; none, and it is said, where it doesn't hold them."""
        try:
            return numbers(element, attribute, count, default, self.source)
        except DocumentError as error:
            self.error("bad-number", error.message, element)
            return ()

    def origin(self, element: ET.Element) -> None:
        for origin in element.findall("origin")[:1]:
            self.numbers(origin, "xyz", 3, "0 0 0")
            self.numbers(origin, "rpy", 3, "0 0 0")

    def inertial(self, link: ET.Element, inertial: ET.Element, name: str) -> None:
        self.origin(inertial)
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if mass is None or inertia is None:
            tag = "mass" if mass is None else "inertia"
            self.warning("no-mass", f"the <inertial> of link {name!r} has no <{tag}>; it is left out", inertial)
            link.remove(inertial)
            return
        value = self.numbers(mass, "value", 1, "")
        numbers = [q for attribute in INERTIA for q in self.numbers(inertia, attribute, 1, "")]
        if not value or len(numbers) < len(INERTIA):
            return
        if value[0] < 0:
            self.warning("no-mass", f"link {name!r} has a mass of {value[0]:g} kg; its <inertial> is left out", mass)
            link.remove(inertial)
            return
        if value[0] == 0:
            self.warning("no-mass", f"link {name!r} has no mass; leave <inertial> out where that is meant", mass)
            return
        moments = principal_moments(*numbers)
        if moments[0] <= 0:
            said = f"has a principal moment of inertia of {moments[0]:.3g} kg m^2, which no body has; those of a ball"
            taken = f"{said} of its mass with a radius of {BALL:g} m are taken"
            self.warning("no-inertia", f"link {name!r} {taken}", inertia)
        elif moments[2] > 1.01 * (moments[0] + moments[1]):
            said = f"the largest, {moments[2]:.3g}, exceeds the sum of the others"
            self.warning("odd-inertia", f"no body has the moments of inertia of link {name!r}: {said}", inertia)

    def body(self, link: ET.Element, body: ET.Element, name: str) -> None:
        self.origin(body)
        geometry = body.find("geometry")
        inner = [] if geometry is None else list(geometry)
        shape = next((each for each in inner if each.tag in SHAPES), None)
        if shape is None:
            odd = f"<{inner[0].tag}>" if inner else "no <geometry>" if geometry is None else "an empty <geometry>"
            message = f"a <{body.tag}> of link {name!r} has {odd}, none of: {listing(SHAPES)}; it is left out"
            self.warning("bad-shape", message, body)
            link.remove(body)
            return
        for size, count in SHAPES[shape.tag]:
            values = self.numbers(shape, size, count, "1 1 1" if shape.tag == "mesh" else "")
            if values and not all(v > 0 or (shape.tag == "mesh" and v) for v in values):
                message = f"the {size} of a {shape.tag} of link {name!r} is {shape.get(size)!r}; it is left out"
                self.warning("bad-shape", message, shape)
                link.remove(body)
                return
        if shape.tag == "mesh" and (fault := self.fault_of(shape)):
            self.warning(fault[0], f"link {name!r}: {fault[1]}; {self.without(link, body)}", shape)

    def without(self, link: ET.Element, body: ET.Element) -> str:
        """Take out what has no mesh, or put the shape that is seen in its place if it is for collisions; say which."""
        at = list(link).index(body)
        link.remove(body)
        for seen in link.findall("visual") if body.tag == "collision" else ():
            mesh = seen.find("geometry/mesh")
            if mesh is not None and self.fault_of(mesh) is None:
                taken = copy.deepcopy(seen)
                taken.tag = "collision"
                link.insert(at, taken)
                return "the mesh that is seen is taken"
        return "it is left out" if body.tag == "visual" else "it is left out, and nothing keeps clear of it"

    def fault_of(self, mesh: ET.Element) -> tuple[str, str] | None:
        """Return what keeps a mesh from being read, as a code and a message."""
        name = mesh.get("filename", "")
        try:
            path = self.packages.resolve(name, Path(self.source).parent)
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

    def joint(self, joint: ET.Element, links: set[str], joints: list[str]) -> None:
        name, kind = joint.get("name", ""), joint.get("type", "")
        if kind not in JOINT_TYPES:
            known = f"{nearest(kind, JOINT_TYPES)} (available: {listing(JOINT_TYPES)})"
            self.error("joint-type", f"joint {name!r} is of the unknown type {kind!r}{known}", joint)
        if kind in HELD:
            self.warning("held-joint", f"joint {name!r} is {kind}; GRIP holds it still", joint)
        for tag in ("parent", "child"):
            if (link := link_at(joint, tag)) not in links:
                known = f"link {link!r}, which isn't there{nearest(link, links)}" if link else "no link"
                self.error("unknown-link", f"the {tag} of joint {name!r} is {known}", joint)
        self.origin(joint)
        if kind in MOVABLE:
            for axis in joint.findall("axis")[:1]:
                values = self.numbers(axis, "xyz", 3, "1 0 0")
                if values and not any(values):
                    self.warning("zero-axis", f"the axis of joint {name!r} is 0 0 0; it is held still", axis)
                    joint.set("type", "fixed")
            self.limit(joint, name, kind)
        for mimic in joint.findall("mimic")[:1]:
            self.numbers(mimic, "multiplier", 1, "1")
            self.numbers(mimic, "offset", 1, "0")
            if (leader := mimic.get("joint", "")) not in joints:
                known = f"{leader!r}, which isn't there{nearest(leader, joints)}; it leads itself"
                self.warning("unknown-joint", f"joint {name!r} mimics {known}", mimic)
                joint.remove(mimic)

    def limit(self, joint: ET.Element, name: str, kind: str) -> None:
        limit, unit = joint.find("limit"), "m" if kind == "prismatic" else "rad"
        if limit is None:
            reach = NO_LIMIT[unit]
            taken = "" if kind == "continuous" else f" -{reach:.4g} ... {reach:.4g} {unit} are taken;"
            add = f'add <limit lower="..." upper="..." velocity="..." effort="..."/> [{unit}]'
            self.warning("missing-limit", f"joint {name!r} has no <limit>;{taken} {add}", joint)
            if kind != "continuous":
                ET.SubElement(joint, "limit", lower=repr(-reach), upper=repr(reach))
            return
        values = [self.numbers(limit, a, 1, "0") for a in ("lower", "upper", "velocity", "effort")]
        if not all(values):
            return
        lower, upper, velocity, effort = (each[0] for each in values)
        if kind != "continuous" and not lower < upper:
            missing = [a for a in ("lower", "upper") if a not in limit.attrib]
            why = f"it lacks {' and '.join(missing)}" if missing else f"lower {lower:g} isn't below upper {upper:g}"
            done = "they are swapped" if lower > upper else "it is held still"
            self.warning("missing-limit", f"joint {name!r} can't move: {why} [{unit}]; {done}", limit)
            if lower == upper:
                joint.set("type", "fixed")
                return
            limit.attrib.update(lower=repr(upper), upper=repr(lower))
        if velocity <= 0:
            taken = f"{NO_SPEED[unit]:g} {unit}/s is taken, unless joint_limits.yaml has one"
            self.warning("no-speed", f"joint {name!r} has no velocity limit above zero; {taken}", limit)
        if effort <= 0:
            taken = f"simulation takes {NO_EFFORT[unit]:g}"
            self.warning("no-effort", f"joint {name!r} has no effort limit above zero; {taken}", limit)

    def structure(self, robot: ET.Element, links: list[str]) -> None:
        """Tell what keeps links and joints from being one tree, and mimics from ending at a joint that leads."""
        above: dict[str, str] = {}
        for joint in robot.findall("joint"):
            child = link_at(joint, "child")
            if child in above:
                self.error("two-parents", f"link {child!r} has two parent joints; a robot is a tree", joint)
            elif child:
                above[child] = link_at(joint, "parent")
        roots = [link for link in dict.fromkeys(links) if link not in above]
        if len(roots) > 1:
            message = f"these links have no parent: {listing(roots)}; connect them with fixed joints"
            self.error("two-roots", message, robot)
        if loop := loop_in({child: [parent] for child, parent in above.items()}):
            first = min(range(len(loop) - 1), key=lambda k: links.index(loop[k]) if loop[k] in links else len(links))
            loop = [*loop[first:-1], *loop[: first + 1]]
            shown = " -> ".join(loop if len(loop) <= 8 else [*loop[:4], "...", *loop[-3:]])
            message = f"these links carry one another in a loop: {shown}; a robot is a tree, take out one joint"
            self.error("cycle", message, robot)
            return
        depth = dict.fromkeys(roots, 0)
        for link in TopologicalSorter({child: [parent] for child, parent in above.items()}).static_order():
            if depth.setdefault(link, depth.get(above.get(link, ""), 0) + 1) > DEEPEST:
                self.error("cycle", f"link {link!r} hangs more than {DEEPEST} joints deep", robot)
                return
        self.leaders(robot)

    def leaders(self, robot: ET.Element) -> None:
        joints = {j.get("name", ""): j for j in robot.findall("joint")}
        leads = {name: m.get("joint", "") for name, j in joints.items() if (m := j.find("mimic")) is not None}
        if loop := loop_in({name: [leader] for name, leader in leads.items()}):
            self.error("cycle", f"joint {loop[0]!r} mimics itself through a chain", joints[loop[0]])
            return
        for name, joint in joints.items():
            at = name
            while at in leads:
                at = leads[at]
            if at != name and joints[at].get("type") in ("fixed", *HELD):
                self.warning(
                    "fixed-leader", f"joint {name!r} mimics {at!r}, which never moves; it is held still", joint
                )
                joint.remove(next(joint.iterfind("mimic")))
                joint.set("type", "fixed")
