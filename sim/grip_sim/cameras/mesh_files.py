"""Reading meshes with the colours and pictures that they carry: Wavefront OBJ and COLLADA here, others by coal."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grip_bt.base.arrays import Array
from grip_bt.commanders.kinematics.shapes import load_mesh
from grip_sim.specs import Colour


@dataclass(frozen=True, eq=False)
class Look:
    """Triangles of one colour or one picture.

    Attributes:
        points: shape (n, 3) [m].
        triangles: of these, shape (m, 3), counter-clockwise seen from outside.
        colour: red green blue, 0-255; None for that of the body.
        uv: where each corner is in the picture, shape (m, 3, 2), v upwards; None without one.
        texture: the picture, shape (h, w, 3) uint8, red green blue.
    """

    points: Array
    triangles: NDArray[np.int32]
    colour: Colour | None = None
    uv: Array | None = None
    texture: NDArray[np.uint8] | None = None

    def moved(self, matrix: Array, scale: Array | float = 1.0) -> Look:
        """Return it scaled along its axes and then moved; a mirrored one is turned right side out."""
        points = self.points * scale @ matrix[:3, :3].T + matrix[:3, 3]
        if np.prod(np.broadcast_to(scale, 3)) * np.linalg.det(matrix[:3, :3]) > 0:
            return replace(self, points=points)
        uv = None if self.uv is None else self.uv[:, ::-1]
        return replace(self, points=points, triangles=self.triangles[:, ::-1], uv=uv)


def read_texture(file: Path) -> NDArray[np.uint8] | None:
    """Return a picture, shape (h, w, 3), red green blue; None where there is none."""
    found = cv2.imread(str(file), cv2.IMREAD_COLOR) if file.is_file() else None
    return None if found is None else np.ascontiguousarray(found[:, :, ::-1], np.uint8)


@lru_cache(maxsize=256)
def read_mesh(file: Path) -> tuple[Look, ...]:
    """Return the parts of a mesh file, one for each material.

    Raises:
        DocumentError, OSError, ValueError, ParseError: it isn't there, or no mesh.
    """
    match file.suffix.lower():
        case ".obj":
            return tuple(_obj(file))
        case ".dae":
            return tuple(_dae(file))
    mesh = load_mesh(file, hollow=True)
    return (Look(np.array(mesh.points), np.array(mesh.triangles, np.int32)),)


@dataclass(frozen=True)
class _Material:
    colour: Colour | None = None
    picture: Path | None = None


def _part(points: Array, corners: Array, material: _Material, uvs: Array, uv_corners: Array | None) -> Look:
    triangles = corners.astype(np.int32)
    texture = read_texture(material.picture) if material.picture is not None and uv_corners is not None else None
    uv = None if texture is None or uv_corners is None else uvs[uv_corners]
    return Look(points, triangles, material.colour, uv, texture)


def _colour(words: list[str]) -> Colour:
    r, g, b = (min(255, max(0, round(255 * float(word)))) for word in words[:3])
    return r, g, b


# --- Wavefront OBJ ---


def _obj(file: Path) -> Iterator[Look]:
    points: list[list[float]] = []
    uvs: list[list[float]] = []
    materials: dict[str, _Material] = {}
    faces: dict[str, list[tuple[tuple[int, int], ...]]] = {"": []}
    current = faces[""]
    for line in file.read_text(errors="replace").splitlines():
        key, *words = line.split() or [""]
        if key == "v":
            points.append([float(word) for word in words[:3]])
        elif key == "vt":
            uvs.append([float(word) for word in words[:2]])
        elif key == "f":
            ring = [_corner(word, len(points), len(uvs)) for word in words]
            current += [(ring[0], one, two) for one, two in zip(ring[1:], ring[2:], strict=False)]
        elif key == "usemtl":
            current = faces.setdefault(" ".join(words), [])
        elif key == "mtllib":
            materials |= _mtl(file.parent / " ".join(words))
    corners = np.array(points).reshape(-1, 3)
    for name, triangles in faces.items():
        if triangles:
            rows = np.array(triangles)
            mapped = rows[:, :, 1] if uvs and (rows[:, :, 1] >= 0).all() else None
            yield _part(corners, rows[:, :, 0], materials.get(name, _Material()), np.array(uvs), mapped)


def _corner(word: str, points: int, uvs: int) -> tuple[int, int]:
    """Return the rows of a corner's point and of its place in the picture, -1 for none."""
    point, uv = (word.split("/") + [""])[:2]
    return _row(point, points), _row(uv, uvs)


def _row(word: str, count: int) -> int:
    """Return the row of which a file speaks: rows count from 1, or backwards from the end."""
    number = int(word or 0)
    return number - 1 if number >= 0 else count + number


def _mtl(file: Path) -> dict[str, _Material]:
    found: dict[str, _Material] = {}
    name = ""
    for line in file.read_text(errors="replace").splitlines() if file.is_file() else ():
        key, *words = line.split() or [""]
        if key == "newmtl":
            name = " ".join(words)
            found[name] = _Material()
        elif key == "Kd":
            found[name] = replace(found.get(name, _Material()), colour=_colour(words))
        elif key == "map_Kd":
            found[name] = replace(found.get(name, _Material()), picture=file.parent / words[-1])
    return found


# --- COLLADA 1.4 ---


def _dae(file: Path) -> Iterator[Look]:
    document = ET.fromstring(file.read_bytes())
    for element in document.iter():
        element.tag = element.tag.rpartition("}")[2]
    by_id = {f"#{e.get('id')}": e for e in document.iter() if e.get("id")}
    unit = document.find("asset/unit")
    frame = np.diag([float(unit.get("meter", 1)) if unit is not None else 1.0] * 3 + [1.0])
    shown = document.find("scene/instance_visual_scene")
    if shown is None:
        raise ValueError(f"{file}: it has no scene")
    scene = by_id[str(shown.get("url"))]
    yield from _nodes(scene, frame, by_id, file.parent)  # `up_axis` counts for nothing, as in RViz and for planners


def _nodes(parent: ET.Element, frame: Array, by_id: Mapping[str, ET.Element], folder: Path) -> Iterator[Look]:
    for node in [*parent.findall("node"), *(by_id[str(i.get("url"))] for i in parent.findall("instance_node"))]:
        place = frame @ _placed(node)
        for use in node.findall("instance_geometry"):
            bound = {m.get("symbol"): str(m.get("target")) for m in use.iter("instance_material")}
            for look in _geometry(by_id[str(use.get("url"))], bound, by_id, folder):
                yield look.moved(place)
        yield from _nodes(node, place, by_id, folder)


def _placed(node: ET.Element) -> Array:
    matrix = np.eye(4)
    for element in node:
        step = np.eye(4)
        if element.tag == "matrix":
            step = _floats(element).reshape(4, 4)
        elif element.tag == "translate":
            step[:3, 3] = _floats(element)
        elif element.tag == "scale":
            step[:3, :3] = np.diag(_floats(element))
        elif element.tag == "rotate":
            *axis, angle = _floats(element)
            step[:3, :3] = cv2.Rodrigues(np.array(axis) / np.linalg.norm(axis) * np.radians(angle))[0]
        matrix = matrix @ step
    return matrix


def _geometry(
    geometry: ET.Element, bound: Mapping[str | None, str], by_id: Mapping[str, ET.Element], folder: Path
) -> Iterator[Look]:
    for group in [e for kind in ("triangles", "polylist", "polygons") for e in geometry.iter(kind)]:
        inputs = {str(i.get("semantic")): i for i in reversed(group.findall("input"))}
        width = 1 + max(int(i.get("offset", 0)) for i in group.findall("input"))
        rows = np.concatenate([np.empty(0, np.int64), *(_floats(p, np.int64) for p in group.findall("p"))])
        if not rows.size:
            continue
        rows = rows.reshape(-1, width)
        rows = rows[_fans(group, len(rows), width)]
        corners = by_id[str(inputs["VERTEX"].get("source"))]
        where = next(i for i in corners.findall("input") if i.get("semantic") == "POSITION")
        points = _source(by_id[str(where.get("source"))])[:, :3]
        uvs, mapped = np.empty((0, 2)), None
        if "TEXCOORD" in inputs:
            uvs = _source(by_id[str(inputs["TEXCOORD"].get("source"))])[:, :2]
            mapped = rows[:, :, int(inputs["TEXCOORD"].get("offset", 0))]
        material = _dae_material(bound.get(group.get("material"), ""), by_id, folder)
        yield _part(points, rows[:, :, int(inputs["VERTEX"].get("offset", 0))], material, uvs, mapped)


def _fans(group: ET.Element, corners: int, width: int) -> NDArray[np.int64]:
    """Return the corners of triangles, shape (n, 3), into which polygons fall."""
    if group.tag == "triangles":
        return np.arange(corners).reshape(-1, 3)
    counts = [len((p.text or "").split()) // width for p in group.findall("p")]
    if (told := group.find("vcount")) is not None:
        counts = _floats(told, np.int64).tolist()
    if set(counts) == {3}:
        return np.arange(corners).reshape(-1, 3)
    starts = np.cumsum([0, *counts])
    return np.array([[s, s + k, s + k + 1] for s, n in zip(starts, counts, strict=False) for k in range(1, n - 1)])


def _source(source: ET.Element) -> Array:
    accessor, numbers = source.find(".//accessor"), source.find("float_array")
    if accessor is None or numbers is None:
        raise ValueError("it has a source without numbers")
    return _floats(numbers).reshape(-1, int(accessor.get("stride", 1)))


def _dae_material(target: str, by_id: Mapping[str, ET.Element], folder: Path) -> _Material:
    material = by_id.get(target)
    use = None if material is None else material.find("instance_effect")
    effect = None if use is None else by_id.get(str(use.get("url")))
    diffuse = None if effect is None else effect.find(".//diffuse")
    if effect is None or diffuse is None:
        return _Material()
    if (colour := diffuse.find("color")) is not None:
        return _Material(_colour((colour.text or "").split()))
    parameters = {p.get("sid"): p for p in effect.iter("newparam")}
    name: str | None = (texture.get("texture") if (texture := diffuse.find("texture")) is not None else "") or ""
    for tag in ("sampler2D/source", "surface/init_from"):  # a picture is named by way of a sampler and a surface
        parameter = parameters.get(name)
        name = parameter.findtext(tag) if parameter is not None else name
    image = by_id.get(f"#{name}")
    told = (image.findtext("init_from") or "") if image is not None else ""
    return _Material(picture=folder / told.removeprefix("file://")) if told else _Material()


def _floats(element: ET.Element, kind: type = np.float64) -> NDArray[Any]:
    return np.array((element.text or "").split(), kind)
