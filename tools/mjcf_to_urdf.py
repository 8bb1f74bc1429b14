"""MJCF hands and arms as URDF: bodies, hinges and slides, boxes, spheres, capsules, cylinders and meshes.

The rest (tendons, equalities, sites, actuators) has no place in a URDF. A capsule becomes a cylinder and two spheres.
Orientations are quaternions, angles radians; a file that says otherwise is refused.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.base.values.pose import Pose, angles_of
from grip_bt.commanders.description.xml import line_of, numbers, read_xml

VELOCITY, EFFORT = 2.0, 2.0
"""Limits of every joint [rad/s, N m]; MJCF has none."""
_KINDS = {"hinge": "revolute", "slide": "prismatic"}
_REFUSED = ("euler", "axisangle", "xyaxes", "zaxis", "fromto")


def urdf_of_mjcf(path: Path) -> tuple[ET.Element, frozenset[tuple[str, str]]]:
    """Return a MJCF model as a URDF with absolute mesh paths, and the pairs of bodies that it lets touch, each sorted.

    Raises:
        DocumentError: it can't be read, or holds what this doesn't convert.
    """
    made = _Conversion(path)
    pairs = ((e.get("body1", ""), e.get("body2", "")) for e in made.root.iterfind("contact/exclude"))
    return made.robot(), frozenset((min(pair), max(pair)) for pair in pairs)


class _Conversion:
    def __init__(self, path: Path):
        self.path, self.root = path, read_xml(path, "mujoco")
        compiler = self.root.find("compiler")
        self.compiler = {} if compiler is None else dict(compiler.attrib)
        self.defaults: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        if (top := self.root.find("default")) is not None:
            self._read_defaults(top, {})
        folder = path.parent / self.compiler.get("meshdir", "")
        self.meshes: dict[str, tuple[Path, str]] = {}
        for mesh in self.root.iterfind("asset/mesh"):
            values = self._values(mesh, "main")
            file = Path(values.get("file", ""))
            self.meshes[values.get("name", file.stem)] = (folder / file).resolve(), values.get("scale", "1 1 1")
        self.urdf = ET.Element("robot", name=self.root.get("model", path.stem))

    def robot(self) -> ET.Element:
        if self.compiler.get("angle", "degree") != "radian":
            raise DocumentError('only models with <compiler angle="radian"/> are converted', str(self.path))
        bodies = [b for world in self.root.findall("worldbody") for b in world.findall("body")]
        if len(bodies) != 1:
            raise DocumentError(f"the world has to hold one body, not {len(bodies)}", str(self.path))
        self._body(bodies[0], None, "main")
        return self.urdf

    def _read_defaults(self, element: ET.Element, inherited: Mapping[str, Mapping[str, str]]) -> None:
        mine = {tag: dict(attributes) for tag, attributes in inherited.items()}
        for child in element:
            if child.tag != "default":
                mine.setdefault(child.tag, {}).update(child.attrib)
        self.defaults[element.get("class", "main")] = mine
        for child in element.findall("default"):
            self._read_defaults(child, mine)

    def _values(self, element: ET.Element, childclass: str) -> dict[str, str]:
        """Return an element's attributes over those of its class."""
        name = element.get("class", childclass)
        if name not in self.defaults:
            self._refuse(f"there is no default class {name!r}", element)
        values = {**self.defaults[name].get(element.tag, {}), **element.attrib}
        if found := [attribute for attribute in _REFUSED if attribute in values]:
            self._refuse(f"<{element.tag} {found[0]}=...> isn't converted; use pos, size and quat", element)
        return values

    def _body(self, body: ET.Element, parent: str | None, childclass: str) -> None:
        if found := [attribute for attribute in _REFUSED if attribute in body.attrib]:
            self._refuse(f"<body {found[0]}=...> isn't converted; use quat", body)
        childclass = body.get("childclass", childclass)
        name = body.get("name") or f"body_{len(self.urdf)}"
        link = ET.SubElement(self.urdf, "link", name=name)
        self._inertial(body, link)
        for geom in body.findall("geom"):
            self._geom(geom, link, childclass)
        if parent is not None:
            self._joint(body, name, parent, childclass)
        for child in body.findall("body"):
            self._body(child, name, childclass)

    def _joint(self, body: ET.Element, name: str, parent: str, childclass: str) -> None:
        joints = body.findall("joint")
        if len(joints) > 1:
            self._refuse(f"body {name!r} has {len(joints)} joints; one at most is converted", body)
        values = self._values(joints[0], childclass) if joints else {}
        kind = _KINDS.get(values.get("type", "hinge")) if joints else "fixed"
        if kind is None:
            self._refuse(f"a {values['type']} joint isn't converted (available: hinge, slide)", joints[0])
        if any(numbers(joint, "pos", 3, "0 0 0", str(self.path)) != (0, 0, 0) for joint in joints):
            self._refuse("a joint whose pos isn't 0 0 0 isn't converted", joints[0])
        joint = ET.SubElement(self.urdf, "joint", name=values.get("name", f"{name}_fixed"), type=str(kind))
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=name)
        _origin(joint, self._place(body))
        if joints:
            ET.SubElement(joint, "axis", xyz=values.get("axis", "0 0 1"))
            if "range" not in values:
                self._refuse(f"joint {joint.get('name')!r} has no range", joints[0])
            lower, upper = values["range"].split()
            ET.SubElement(joint, "limit", lower=lower, upper=upper, velocity=str(VELOCITY), effort=str(EFFORT))

    def _inertial(self, body: ET.Element, link: ET.Element) -> None:
        if (inertial := body.find("inertial")) is None:
            return
        element = ET.SubElement(link, "inertial")
        _origin(element, self._place(inertial))
        ET.SubElement(element, "mass", value=inertial.get("mass", ""))
        moments = self._numbers(inertial, "diaginertia", 3, "")
        zero = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
        ET.SubElement(element, "inertia", zero | dict(zip(("ixx", "iyy", "izz"), map(repr, moments), strict=True)))

    def _geom(self, geom: ET.Element, link: ET.Element, childclass: str) -> None:
        values = self._values(geom, childclass)
        element = ET.Element(geom.tag, values)
        collides = values.get("contype", "1") != "0" or values.get("conaffinity", "1") != "0"
        kind = values.get("type", "sphere")
        place = self._place(element)
        size = [float(word) for word in values.get("size", "").split()]
        shapes: list[tuple[str, dict[str, str], Pose]] = []
        if kind == "box" and len(size) == 3:
            shapes = [("box", {"size": " ".join(repr(2 * s) for s in size)}, place)]
        elif kind == "sphere" and size:
            shapes = [("sphere", {"radius": repr(size[0])}, place)]
        elif kind in ("cylinder", "capsule") and len(size) >= 2:
            shapes = [("cylinder", {"radius": repr(size[0]), "length": repr(2 * size[1])}, place)]
            half = size[1] * place.rotation()[:, 2]
            ends = (place.moved(half), place.moved(-half)) if kind == "capsule" else ()
            shapes += [("sphere", {"radius": repr(size[0])}, end) for end in ends]
        elif kind == "mesh" and values.get("mesh") in self.meshes:
            file, scale = self.meshes[values["mesh"]]
            shapes = [("mesh", {"filename": str(file), "scale": scale}, place)]
        else:
            self._refuse(f"a geom of type {kind!r} and this size isn't converted", geom)
        for tag, attributes, where in shapes:
            body = ET.SubElement(link, "collision" if collides else "visual")
            _origin(body, where)
            ET.SubElement(ET.SubElement(body, "geometry"), tag, attributes)

    def _place(self, element: ET.Element) -> Pose:
        position, turn = self._numbers(element, "pos", 3, "0 0 0"), self._numbers(element, "quat", 4, "1 0 0 0")
        if not any(turn):
            self._refuse(f"quat of <{element.tag}> is no rotation: its four numbers are zero", element)
        return Pose(position, turn)

    def _numbers(self, element: ET.Element, attribute: str, count: int, default: str) -> tuple[float, ...]:
        return numbers(element, attribute, count, default, str(self.path))

    def _refuse(self, message: str, element: ET.Element) -> None:
        raise DocumentError(message, str(self.path), line_of(element))


def _origin(element: ET.Element, place: Pose) -> None:
    xyz, rpy = (" ".join(map(repr, values)) for values in (place.position.tolist(), angles_of(place.rotation())))
    ET.SubElement(element, "origin", xyz=xyz, rpy=rpy)
