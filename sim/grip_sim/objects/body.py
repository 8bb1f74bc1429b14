"""An object's file -> its convex parts, looks and mass properties, in the frame that worlds place it by."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from grip_bt.base.arrays import Array
from grip_sim.cameras.mesh_files import Look, joined, read_mesh

from .model import ObjectFile
from .solids import check_thick, parts_of, radius_of

EYE = np.eye(4)


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """An object whose frame has its origin in the middle of its bounding box, z up when it stands.

    Attributes:
        parts: corners of its convex parts, each of shape (n, 3) [m].
        size: of its bounding box [m].
        mass: [kg].
        centre: its centre of mass [m].
        inertia: about its centre of mass, shape (3, 3) [kg m^2].
        friction: coefficient against hands and fixtures.
    """

    name: str
    doc: str
    parts: tuple[Array, ...]
    looks: tuple[Look, ...]
    size: tuple[float, float, float]
    mass: float
    centre: Array
    inertia: Array
    friction: float

    @property
    def radius(self) -> float:
        """Of the circle about its middle, seen from above, that it doesn't leave [m]."""
        return radius_of(self.parts)


def build(file: ObjectFile, path: Path) -> ObjectModel:
    """Return what a file describes, by an even density. Raises DocumentError where a mesh is missing, wrong or flat."""
    if file.solids:
        shaded = [(points, solid.colour or file.colour) for solid in file.solids for points in parts_of(solid)]
        parts = [points * file.scale for points, _ in shaded]
        hulls = [_hull(points, path) for points in parts]
        looks = [
            Look(np.array(hull.vertices, float), np.array(hull.faces, np.int32), colour)
            for hull, (_, colour) in zip(hulls, shaded, strict=True)
        ]
        surface = hulls
    else:
        looks = [look.moved(EYE, file.scale) for look in read_mesh(path.parent / str(file.mesh))]
        whole = joined(looks)
        if file.parts:
            pieces = read_mesh(path.parent / file.parts)
            parts = [look.points[np.unique(look.triangles)] * file.scale for look in pieces]
        else:
            parts = [np.array(whole.vertices)]
        hulls = [_hull(points, path) for points in parts]
        surface = [whole] if whole.is_volume else hulls
    corners = [np.array(hull.vertices) for hull in hulls]
    low = np.min([points.min(axis=0) for points in corners], axis=0)
    high = np.max([points.max(axis=0) for points in corners], axis=0)
    back = EYE.copy()
    back[:3, 3] = -(low + high) / 2  # so that the origin is in the middle
    centre, inertia = _mass_properties(surface, file.mass / sum(float(each.volume) for each in surface))
    if file.centre_of_mass is not None:
        centre = np.array(file.centre_of_mass)
    x, y, z = (float(edge) for edge in high - low)
    return ObjectModel(
        name=path.stem,
        doc=file.doc,
        parts=tuple(points + back[:3, 3] for points in corners),
        looks=tuple(look.moved(back) for look in looks),
        size=(x, y, z),
        mass=file.mass,
        centre=centre + back[:3, 3],
        inertia=inertia,
        friction=file.friction,
    )


def _mass_properties(bodies: list[trimesh.Trimesh], density: float) -> tuple[Array, Array]:
    """Return the centre of mass [m] and the inertia about it [kg m^2] of bodies of even density [kg/m^3]."""
    masses = np.array([density * body.volume for body in bodies])
    centres = np.array([body.center_mass for body in bodies])
    centre = masses @ centres / masses.sum()
    inertia = np.zeros((3, 3))
    for body, mass, at in zip(bodies, masses, centres - centre, strict=True):
        inertia += density * body.moment_inertia + mass * (at @ at * np.eye(3) - np.outer(at, at))
    return centre, inertia


def _hull(points: Array, path: Path) -> trimesh.Trimesh:
    check_thick(points, path)
    return trimesh.convex.convex_hull(points)
