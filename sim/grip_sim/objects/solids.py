"""Pieces of an object -> the corners of their convex parts, by numpy alone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError
from grip_bt.base.values.pose import Pose, quaternion_of

from .model import ObjectFile, SolidConfig

THIN = 1e-5
"""The physics can't use parts thinner than this [m]."""


def extent_of(file: ObjectFile, path: Path) -> tuple[float, float]:
    """Return radius, seen from above, and height of an object of pieces [m]. Raises DocumentError: one is flat."""
    parts = [points * file.scale for solid in file.solids for points in parts_of(solid)]
    for points in parts:
        check_thick(points, path)
    low = np.min([points.min(axis=0) for points in parts], axis=0)
    high = np.max([points.max(axis=0) for points in parts], axis=0)
    return radius_of(points - (low + high) / 2 for points in parts), float(high[2] - low[2])


def radius_of(parts: Iterable[Array]) -> float:
    """Return the radius of the circle about the origin, seen from above, that parts don't leave [m]."""
    return float(max(np.linalg.norm(points[:, :2], axis=1).max() for points in parts))


def check_thick(points: Array, path: Path) -> None:
    """Raise DocumentError where corners, shape (n, 3) [m], are those of nothing that has a volume."""
    if len(points) < 4 or np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2] < THIN:
        raise DocumentError(f"a part of it is flat: it is less than {THIN * 1e3:g} mm thick", str(path))


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
