"""An object's file -> its convex parts, looks and mass properties, in the frame that worlds place it by."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError
from grip_sim.cameras.mesh_files import Look, joined, read_mesh
from grip_sim.specs import Colour

from .model import ObjectFile
from .solids import parts_of

EYE = np.eye(4)
THIN = 1e-5
"""A part thinner than this is none to physics [m]."""


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """An object whose frame has its origin in the middle of its bounding box, z up when it stands.

    Attributes:
        name: of its file.
        doc: what it is.
        parts: corners of its convex parts, each of shape (n, 3) [m].
        looks: what cameras see.
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
        return float(max(np.linalg.norm(points[:, :2], axis=1).max() for points in self.parts))


def build(file: ObjectFile, path: Path) -> ObjectModel:
    """Return what a file describes; what it lacks of inertia comes of an even density.

    Raises:
        DocumentError: a mesh is missing or wrong, or has no volume.
    """
    if file.solids:
        shaded = [(points, solid.colour or file.colour) for solid in file.solids for points in parts_of(solid)]
        parts = [points * file.scale for points, _ in shaded]
        hulls = [_hull(points, path) for points in parts]
        looks = [_look(hull, colour) for hull, (_, colour) in zip(hulls, shaded, strict=True)]
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
    return _in_the_middle(file, path.stem, [np.array(hull.vertices) for hull in hulls], looks, surface)


def _in_the_middle(
    file: ObjectFile,
    name: str,
    parts: list[Array],
    looks: list[Look],
    surface: list[trimesh.Trimesh],
) -> ObjectModel:
    low = np.min([points.min(axis=0) for points in parts], axis=0)
    high = np.max([points.max(axis=0) for points in parts], axis=0)
    back = EYE.copy()
    back[:3, 3] = -(low + high) / 2
    volume = sum(float(each.volume) for each in surface)
    centre, inertia = _mass_properties(surface, file.mass / volume)
    if file.centre_of_mass is not None:
        centre = np.array(file.centre_of_mass)
    x, y, z = (float(edge) for edge in high - low)
    return ObjectModel(
        name=name,
        doc=file.doc,
        parts=tuple(points + back[:3, 3] for points in parts),
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
    if len(points) < 4 or np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2] < THIN:
        raise DocumentError(f"a part of it is flat: it is less than {THIN * 1e3:g} mm thick", str(path))
    return trimesh.convex.convex_hull(points)


def _look(hull: trimesh.Trimesh, colour: Colour | None) -> Look:
    return Look(np.array(hull.vertices, float), np.array(hull.faces, np.int32), colour)
