"""An object's file -> its convex parts, looks and mass properties, in the frame that worlds place it by."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError
from grip_bt.base.values.pose import Pose, quaternion_of
from grip_sim.cameras.mesh_files import Look, joined, read_mesh

from .model import ObjectFile, SolidConfig

EYE = np.eye(4)
THIN = 1e-5
"""A part thinner than this is none to physics [m]."""


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
        return float(max(np.linalg.norm(points[:, :2], axis=1).max() for points in self.parts))


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
    if len(points) < 4 or np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2] < THIN:
        raise DocumentError(f"a part of it is flat: it is less than {THIN * 1e3:g} mm thick", str(path))
    return trimesh.convex.convex_hull(points)


ROUND = 24
"""Corners of a circle: the surface of a mug of 4 cm radius is 0.35 mm off at most."""
WEDGES = 16
"""Convex parts in a ring of a hollow piece's wall."""


def parts_of(solid: SolidConfig) -> Iterator[Array]:
    """Return the corners of a piece's convex parts, each of shape (n, 3) [m], where the piece is put."""
    return map(Pose(solid.at, quaternion_of(*solid.turn)).apply, _parts(solid))


def _parts(solid: SolidConfig) -> Iterator[Array]:
    if solid.box is not None:
        yield np.array(np.meshgrid(*((-edge / 2, edge / 2) for edge in solid.box))).reshape(3, -1).T
    elif solid.ball is not None:
        heights = np.linspace(-np.pi / 2, np.pi / 2, ROUND // 2 + 1)
        yield np.vstack([_ring(solid.ball * np.cos(a), solid.ball * np.sin(a)) for a in heights])
    elif solid.turned is not None and solid.wall is not None:
        yield from _hollow(solid.turned, solid.wall)
    elif solid.turned is not None:
        yield from (np.vstack([_ring(r, z) for r, z in piece]) for piece in _convex_pieces(solid.turned))
    elif solid.bent is not None:
        yield from _rod(np.array(solid.bent), np.broadcast_to(np.array(solid.radius), len(solid.bent)))
    elif solid.prism is not None:
        foot = np.array(solid.prism)
        yield np.vstack([np.column_stack([foot, np.full(len(foot), z)]) for z in (0.0, solid.height)])


def _ring(radius: float, height: float, start: float = 0.0, end: float = 2 * np.pi, corners: int = ROUND) -> Array:
    if radius < 1e-9:
        return np.array([[0.0, 0.0, height]])
    angles = np.linspace(start, end, corners, endpoint=end < 2 * np.pi)
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(len(angles), height)])


def _convex_pieces(profile: Sequence[tuple[float, float]]) -> Iterator[Sequence[tuple[float, float]]]:
    """Yield the longest stretches of an outline that bulge outwards: each is turned into a convex body."""
    first = 0
    for last in range(2, len(profile)):
        (r0, z0), (r1, z1), (r2, z2) = profile[last - 2 : last + 1]
        if (r1 - r0) * (z2 - z1) < (r2 - r1) * (z1 - z0) - 1e-12:  # it bends inwards at the one before
            yield profile[first:last]
            first = last - 1
    yield profile[first:]


def _hollow(outer: Sequence[tuple[float, float]], wall: float) -> Iterator[Array]:
    """Yield the bottom and the wedges of the wall of a solid of revolution that is open at the top."""
    bottom = outer[0][1] + wall
    inside = [(max(r - wall, 0.0), max(z, bottom)) for r, z in outer]
    yield np.vstack([_ring(max(outer[0][0] - wall / 2, wall), z) for z in (outer[0][1], bottom)])
    edges = np.linspace(0, 2 * np.pi, WEDGES + 1)
    for (low, high), (low_in, high_in) in zip(pairwise(outer), pairwise(inside), strict=True):
        if low[0] > 1e-9 or high[0] > 1e-9:
            for start, end in pairwise(edges):
                corners = [_ring(r, z, start, end * (1 - 1e-12), 2) for r, z in (low, high, low_in, high_in)]
                yield np.vstack(corners)


def _rod(line: Array, radii: Array) -> Iterator[Array]:
    """Yield a part between each two points of a rod's middle line, shape (n, 3); what bends is mitred."""
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along[0], np.eye(3)[np.argmin(np.abs(along[0]))])
    rings = []
    for point, direction, radius in zip(line, along, radii, strict=True):
        side -= direction * (side @ direction)  # carried along, so that rings don't twist
        side /= np.linalg.norm(side)
        angles = np.linspace(0, 2 * np.pi, ROUND // 2, endpoint=False)[:, None]
        rings.append(point + radius * (np.cos(angles) * side + np.sin(angles) * np.cross(direction, side)))
    yield from (np.vstack(pair) for pair in pairwise(rings))
