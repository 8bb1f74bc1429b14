"""What is wrong with the masses and the shapes of a URDF's links."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from grip_bt.base.errors import MissingPartError, listing

from .findings import Finding, Severity
from .xml import numbers

if TYPE_CHECKING:
    from .check_urdf import Reporter

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
    if (origin := inertial.find("origin")) is not None:
        yield from reporter.check_numbers(origin, "xyz", 3, "0 0 0")
        yield from reporter.check_numbers(origin, "rpy", 3, "0 0 0")
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
    if (origin := body.find("origin")) is not None:
        yield from reporter.check_numbers(origin, "xyz", 3, "0 0 0")
        yield from reporter.check_numbers(origin, "rpy", 3, "0 0 0")
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
