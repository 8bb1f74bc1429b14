"""What a body looks like, as triangles: the visuals of a robot's description, or the shapes that physics knows."""

from __future__ import annotations

import logging
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError
from grip_sim.cameras.mesh_files import Look, read_mesh, read_texture
from grip_sim.physics import physx
from grip_sim.specs import Colour

_log = logging.getLogger(__name__)
ROUND = 48
"""Corners of a circle: the surface of a cylinder of 5 cm radius is 0.1 mm off at most."""
TURN = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)


@dataclass(frozen=True)
class Visual:
    """One `<visual>` of a link.

    Attributes:
        kind: `mesh`, `box`, `cylinder` or `sphere`.
        pose: its matrix in the link, rows of 4.
        size: scale of a mesh; edges; radius and length; radius [m].
        file: of a mesh.
        colour: that the description gives it; None where the mesh's own, or the body's, is to be taken.
        texture: file of its picture; empty for the mesh's own.
    """

    kind: str
    pose: tuple[tuple[float, ...], ...]
    size: tuple[float, ...]
    file: str = ""
    colour: Colour | None = None
    texture: str = ""


@dataclass(frozen=True)
class Target:
    """A body that a camera may see.

    Attributes:
        body: its physical component.
        name: for the referee's segmentation.
        colour: red green blue, 0-255, of what has no colour of its own.
        visuals: what it looks like; nothing for its collision shapes.
        drawn: the same, as triangles.
    """

    body: physx.PhysxRigidBaseComponent
    name: str
    colour: Colour
    visuals: tuple[Visual, ...] = ()
    drawn: tuple[Look, ...] = ()

    def looks(self, visual: bool = True) -> tuple[Look, ...]:
        """Return its triangles in its own frame; `visual` prefers visuals to collision shapes."""
        try:
            found = tuple(look for v in self.visuals for look in look_of(v)) if visual else ()
        except (GripError, OSError, ValueError, ET.ParseError) as error:
            _log.warning("%s is drawn by its collision shapes: %s", self.name, error)
            found = ()
        return (
            found or (self.drawn if visual else ()) or tuple(shape_look(shape) for shape in self.body.collision_shapes)
        )


def visuals_of(urdf: str) -> Mapping[str, tuple[Visual, ...]]:
    """Return the visuals of each link that has some; mesh paths are absolute."""
    robot = ET.fromstring(urdf)
    known = {str(m.get("name")): m for m in robot.findall("material")}
    return {
        str(link.get("name")): tuple(v for each in link.findall("visual") if (v := _visual(each, known)) is not None)
        for link in robot.findall("link")
        if link.find("visual") is not None
    }


def _visual(element: ET.Element, known: Mapping[str, ET.Element]) -> Visual | None:
    body, origin = next(iter(element.findall("geometry/*")), None), element.find("origin")
    sizes = {"mesh": ("scale",), "box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}
    if body is None or body.tag not in sizes:
        return None
    size = [n for key in sizes[body.tag] for n in _numbers(body.get(key), "1 1 1")]
    place = {} if origin is None else origin.attrib
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", _numbers(place.get("rpy"), "0 0 0")).as_matrix()
    matrix[:3, 3] = _numbers(place.get("xyz"), "0 0 0")
    said = element.find("material")
    material = said if said is None or len(said) else known.get(str(said.get("name")))
    colour, texture = (None, None) if material is None else (material.find("color"), material.find("texture"))
    shade = None if colour is None else tuple(round(255 * n) for n in _numbers(colour.get("rgba"), "1 1 1 1")[:3])
    picture = "" if texture is None else str(texture.get("filename")).removeprefix("file://")
    file = str(body.get("filename", "")).removeprefix("file://")
    rows = tuple(tuple(row) for row in matrix.tolist())
    return Visual(body.tag, rows, tuple(size), file, shade, picture)  # type: ignore[arg-type]


def _numbers(text: str | None, default: str) -> list[float]:
    return [float(word) for word in (text or default).split()]


@lru_cache(maxsize=512)
def look_of(visual: Visual) -> tuple[Look, ...]:
    """Return the triangles of a visual in its link's frame.

    Raises:
        GripError, OSError, ValueError, ParseError: its mesh can't be read.
    """
    parts = read_mesh(Path(visual.file)) if visual.kind == "mesh" else (_solid_look(visual.kind, visual.size),)
    scale = np.array(visual.size if visual.kind == "mesh" else (1.0,))
    picture = read_texture(Path(visual.texture)) if visual.texture else None
    found = (part.moved(np.array(visual.pose), scale) for part in parts)
    # A colour of the description is for meshes that have none, as RViz has it.
    return tuple(
        replace(part, colour=part.colour or visual.colour, texture=part.texture if picture is None else picture)
        for part in found
    )


def _solid_look(kind: str, size: tuple[float, ...]) -> Look:
    if kind == "box":
        return hull_look(box_corners(-np.array(size) / 2, np.array(size) / 2))
    if kind == "sphere":
        return hull_look(_ball(size[0]))
    rim = np.stack([np.cos(TURN), np.sin(TURN), 0 * TURN], axis=1) * size[0]
    end = np.array([0, 0, size[1] / 2])
    return hull_look(np.concatenate([rim + end, rim - end]))


def shape_look(shape: physx.PhysxCollisionShape) -> Look:
    """Return the triangles of a collision shape in its body's frame.

    Raises:
        TypeError: it has no end, as a plane has none.
    """
    return _shape_look(shape).moved(shape.local_pose.to_transformation_matrix().astype(float))


def _shape_look(shape: Any) -> Look:
    end = np.array([[getattr(shape, "half_length", 0.0), 0, 0]])
    match shape:
        case physx.PhysxCollisionShapeConvexMesh():
            return hull_look(np.asarray(shape.vertices, float) * shape.scale)
        case physx.PhysxCollisionShapeTriangleMesh():
            return Look(np.asarray(shape.vertices, float) * shape.scale, np.asarray(shape.triangles, np.int32))
        case physx.PhysxCollisionShapeBox():
            return hull_look(box_corners(-shape.half_size, shape.half_size))
        case physx.PhysxCollisionShapeSphere() | physx.PhysxCollisionShapeCapsule():
            ball = _ball(shape.radius)
            return hull_look(np.unique(np.concatenate([ball + end, ball - end]), axis=0))
        case physx.PhysxCollisionShapeCylinder():  # along x
            rim = np.stack([0 * TURN, np.cos(TURN), np.sin(TURN)], axis=1) * shape.radius
            return hull_look(np.concatenate([rim + end, rim - end]))
    raise TypeError(f"a camera can't draw a {type(shape).__name__}")


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
