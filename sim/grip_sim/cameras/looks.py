"""What a body looks like, as triangles: the visuals of a robot's description, or the shapes that physics knows."""

from __future__ import annotations

import logging
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError
from grip_bt.commanders.description.xml import origin_of
from grip_sim.cameras.mesh_files import Look, read_mesh, read_texture
from grip_sim.physics import physx
from grip_sim.specs import Colour

_log = logging.getLogger(__name__)
ROUND = 48
"""Corners of a circle: the surface of a cylinder of 5 cm radius is 0.1 mm off at most."""
TURN = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)


Looks = Callable[[], Sequence[Look]]


@dataclass(frozen=True)
class Target:
    """A body that a camera may see.

    Attributes:
        name: for the referee's segmentation.
        colour: red green blue, 0-255, of what has no colour of its own.
        visuals: reads what it looks like, in its own frame; None for its collision shapes.
    """

    body: physx.PhysxRigidBaseComponent
    name: str
    colour: Colour
    visuals: Looks | None = None

    def looks(self, visual: bool = True) -> Sequence[Look]:
        """Return its triangles in its own frame; `visual` prefers visuals to collision shapes."""
        found: Sequence[Look] = ()
        try:
            found = self.visuals() if visual and self.visuals is not None else ()
        except (GripError, OSError, ValueError, ET.ParseError) as error:
            _log.warning("%s is drawn by its collision shapes: %s", self.name, error)
        return found or [shape_look(shape) for shape in self.body.collision_shapes]


@lru_cache(maxsize=8)
def visuals_of(urdf: str) -> Mapping[str, Looks]:
    """Return what reads the visuals of each link that has some; mesh paths are absolute."""
    robot = ET.fromstring(urdf)
    known = {str(m.get("name")): m for m in robot.findall("material")}
    links = {str(link.get("name")): link.findall("visual") for link in robot.findall("link")}
    return {name: cache(partial(_looks_of, visuals, known)) for name, visuals in links.items() if visuals}


def _looks_of(visuals: Sequence[ET.Element], known: Mapping[str, ET.Element]) -> list[Look]:
    return [look for visual in visuals for look in _look_of(visual, known)]


def _look_of(visual: ET.Element, known: Mapping[str, ET.Element]) -> Iterator[Look]:
    body, matrix, scale, parts = visual.find("geometry/*"), origin_of(visual).matrix(), np.ones(1), list[Look]()
    match "" if body is None else body.tag, {} if body is None else body.attrib:
        case "mesh", {"filename": file, **more}:
            parts, scale = list(read_mesh(Path(_local(file)))), np.array(_numbers(more.get("scale"), "1 1 1"))
        case "box", {"size": size}:
            parts = [_box(*(length / 2 for length in _numbers(size)))]
        case "cylinder", {"radius": radius, "length": length}:
            parts = [hull_look(_cylinder(float(radius), float(length) / 2))]
        case "sphere", {"radius": radius}:
            parts = [hull_look(_ball(float(radius)))]
    said = visual.find("material")
    material = said if said is None or len(said) else known.get(str(said.get("name")))
    colour, texture = (None, None) if material is None else (material.find("color"), material.find("texture"))
    shade = None
    if colour is not None:
        red, green, blue = (round(255 * n) for n in _numbers(colour.get("rgba"), "1 1 1 1")[:3])
        shade = (red, green, blue)
    picture = None if texture is None else read_texture(Path(_local(str(texture.get("filename")))))
    for part in parts:
        own = part.texture if picture is None else picture
        # A colour of the description is for meshes that have none, as RViz has it.
        yield replace(part.moved(matrix, scale), colour=part.colour or shade, texture=own)


def _local(name: str) -> str:
    return name.removeprefix("file://")


def _numbers(text: str | None, default: str = "") -> list[float]:
    return [float(word) for word in (text or default).split()]


def shape_look(shape: physx.PhysxCollisionShape) -> Look:
    """Return the triangles of a collision shape in its body's frame. Raises TypeError where it has no end."""
    match shape:
        case physx.PhysxCollisionShapeConvexMesh():
            look = hull_look(np.asarray(shape.vertices, float) * shape.scale)
        case physx.PhysxCollisionShapeTriangleMesh():
            look = Look(np.asarray(shape.vertices, float) * shape.scale, np.asarray(shape.triangles, np.int32))
        case physx.PhysxCollisionShapeBox():
            look = _box(*shape.half_size.tolist())
        case physx.PhysxCollisionShapeSphere():
            look = hull_look(_ball(shape.radius))
        case physx.PhysxCollisionShapeCapsule():  # along x, as cylinders
            ball, end = _ball(shape.radius), np.array([shape.half_length, 0, 0])
            look = hull_look(np.unique(np.concatenate([ball + end, ball - end]), axis=0))
        case physx.PhysxCollisionShapeCylinder():
            look = hull_look(np.roll(_cylinder(shape.radius, shape.half_length), 1, axis=1))
        case _:
            raise TypeError(f"a camera can't draw a {type(shape).__name__}")
    return look.moved(shape.local_pose.to_transformation_matrix().astype(float))


@lru_cache(maxsize=64)
def _box(x: float, y: float, z: float) -> Look:
    half = np.array([x, y, z])
    return hull_look(box_corners(-half, half))


def _cylinder(radius: float, half: float) -> Array:
    rim, end = np.stack([np.cos(TURN), np.sin(TURN), 0 * TURN], axis=1) * radius, np.array([0, 0, half])
    return np.concatenate([rim + end, rim - end])


def _ball(radius: float) -> Array:
    v, u = np.meshgrid(np.linspace(0, np.pi, ROUND // 2 + 1), TURN)
    ball = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    return radius * np.unique(ball.round(12), axis=0)


def hull_look(points: Array) -> Look:
    """Return the convex hull of points, its triangles counter-clockwise seen from outside."""
    hull = ConvexHull(points)
    triangles: NDArray[np.int32] = hull.simplices.astype(np.int32)
    one, two, three = points[triangles].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(two - one, three - one), hull.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return Look(np.asarray(points, float), triangles)


def box_corners(low: Array, high: Array) -> Array:
    """Return the corners of a box along the axes, shape (8, 3)."""
    return np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T
