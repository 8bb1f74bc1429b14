"""Shapes of things that a robot avoids, takes along, or may touch. Lengths in m; each shape has axes of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grip_bt.base.arrays import Array, ComparesArrays, frozen_array

_SLIVER = 1e-3
"""What is shrunk keeps this size [m]."""


class _Centred:
    __slots__ = ()

    def centre(self) -> tuple[float, float, float]:
        """Return the middle of the bounding box along the shape's own axes [m]."""
        return (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Box(_Centred):
    """A box, centred at its pose; `size` holds its edge lengths [m]."""

    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", _lengths("box", self.size, 3))

    def extents(self) -> tuple[float, float, float]:
        """Return the edge lengths of the bounding box along the shape's own axes [m]."""
        return self.size

    def grown(self, margin: float) -> Box:
        """Return the box with `margin` [m] more on every side; a negative one shrinks it, down to a sliver."""
        x, y, z = (max(length + 2 * margin, _SLIVER) for length in self.size)
        return Box((x, y, z))


@dataclass(frozen=True, slots=True)
class Cylinder(_Centred):
    """A cylinder about its z axis, centred at its pose; lengths in m."""

    radius: float
    height: float

    def __post_init__(self) -> None:
        _lengths("cylinder", (self.radius, self.height), 2)

    def extents(self) -> tuple[float, float, float]:
        """Return the edge lengths of the bounding box along the shape's own axes [m]."""
        return (2 * self.radius, 2 * self.radius, self.height)

    def grown(self, margin: float) -> Cylinder:
        """Return the cylinder with `margin` [m] more on every side; a negative one shrinks it, down to a sliver."""
        return Cylinder(max(self.radius + margin, _SLIVER / 2), max(self.height + 2 * margin, _SLIVER))


@dataclass(frozen=True, slots=True)
class Sphere(_Centred):
    """A sphere, centred at its pose; its radius in m."""

    radius: float

    def __post_init__(self) -> None:
        _lengths("sphere", (self.radius,), 1)

    def extents(self) -> tuple[float, float, float]:
        """Return the edge lengths of the bounding box [m]."""
        return (2 * self.radius, 2 * self.radius, 2 * self.radius)

    def grown(self, margin: float) -> Sphere:
        """Return the sphere with `margin` [m] more all around; a negative one shrinks it, down to a sliver."""
        return Sphere(max(self.radius + margin, _SLIVER / 2))


@dataclass(frozen=True, slots=True, eq=False)
class Mesh(ComparesArrays):
    """A convex hull of points, or, with triangles, the surface that they make.

    A hull is a solid body and quick to check. A surface is exact for what is hollow, such as a shelf, but has no inside
    and keeps no margin: `grown` leaves it as it is.

    Attributes:
        points: shape (n, 3) [m].
        triangles: shape (m, 3), indices of points; empty for the hull.
        margin: how much thicker the hull is on every side [m], never negative.
    """

    points: Array
    triangles: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    margin: float = 0.0

    def __post_init__(self) -> None:
        self._freeze((None, 3), "points")
        self._freeze((None, 3), "triangles", dtype=np.int32)
        if len(self.points) < 4 or not np.isfinite(self.points).all():
            raise ValueError(f"a mesh has at least 4 points, all of finite numbers, not {len(self.points)} points")
        if np.linalg.matrix_rank(self.points - self.points[0], tol=1e-9) < 3 and not len(self.triangles):
            raise ValueError("the points of a hull lie in one plane; give it thickness, or give triangles")
        if len(self.triangles) and not (0 <= self.triangles.min() and self.triangles.max() < len(self.points)):
            raise ValueError(f"a triangle of the mesh names a point that isn't among its {len(self.points)}")

    @property
    def hollow(self) -> bool:
        """Whether it is a surface of triangles."""
        return bool(len(self.triangles))

    def extents(self) -> tuple[float, float, float]:
        """Return the edge lengths of the bounding box along the shape's own axes [m]."""
        x, y, z = np.ptp(self.points, axis=0) + 2 * self.margin
        return (float(x), float(y), float(z))

    def centre(self) -> tuple[float, float, float]:
        """Return the middle of the bounding box along the shape's own axes [m]."""
        x, y, z = (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        return (float(x), float(y), float(z))

    def grown(self, margin: float) -> Mesh:
        """Return the hull with `margin` [m] more on every side.

        A negative one draws the points towards the middle of the bounding box, such that its sides lose that much.
        """
        if self.hollow or margin == 0:
            return self
        if margin > 0:
            return Mesh(self.points, self.triangles, self.margin + margin)
        middle, sides = np.array(self.centre()), np.array(self.extents())
        factor = np.maximum(sides + 2 * margin, _SLIVER) / sides
        return Mesh(middle + (self.points - middle) * factor, self.triangles, self.margin)


@dataclass(frozen=True, slots=True, eq=False)
class CellMap(ComparesArrays):
    """Occupied cells of a grid: what a point cloud shows, as an octree is made of it.

    Attributes:
        cells: shape (n, 3) int32, sorted and different from one another; cell (i, j, k) reaches from
            (i, j, k) * resolution to (i + 1, j + 1, k + 1) * resolution.
        resolution: edge length of a cell [m].
    """

    cells: NDArray[np.int32]
    resolution: float

    def __post_init__(self) -> None:
        _lengths("cell", (self.resolution,), 1)
        cells = np.unique(frozen_array(self.cells, (None, 3), "cells", np.int32), axis=0)
        if not len(cells):
            raise ValueError("a map of cells has at least one occupied cell")
        object.__setattr__(self, "cells", frozen_array(cells, (None, 3), "cells", np.int32))

    @classmethod
    def of_points(cls, points: ArrayLike, resolution: float, min_points: int = 1) -> CellMap:
        """Make the map of the cells that hold at least `min_points` of the points.

        Args:
            points: shape (n, 3) [m]; what isn't finite is left out.
            resolution: edge length of a cell [m].

        Raises:
            ValueError: no cell holds so many.
        """
        _lengths("cell", (resolution,), 1)
        rows = np.asarray(points, dtype=float).reshape(-1, 3)
        rows = rows[np.isfinite(rows).all(axis=1)]
        cells, counts = np.unique(np.floor(rows / resolution).astype(np.int32), axis=0, return_counts=True)
        return cls(cells[counts >= min_points], resolution)

    def middles(self) -> Array:
        """Return the middles of the cells, shape (n, 3) [m]."""
        return (self.cells.astype(np.float64) + 0.5) * self.resolution

    def extents(self) -> tuple[float, float, float]:
        """Return the edge lengths of the bounding box along the shape's own axes [m]."""
        x, y, z = (np.ptp(self.cells, axis=0) + 1) * self.resolution
        return (float(x), float(y), float(z))

    def centre(self) -> tuple[float, float, float]:
        """Return the middle of the bounding box along the shape's own axes [m]."""
        x, y, z = (self.cells.min(axis=0) + self.cells.max(axis=0) + 1) * self.resolution / 2
        return (float(x), float(y), float(z))

    def grown(self, margin: float) -> CellMap:
        """Return the map with every neighbour within `margin` [m], rounded up to whole cells; it is never shrunk."""
        steps = int(np.ceil(margin / self.resolution - 1e-9))
        if steps <= 0:
            return self
        cells = self.cells
        for axis in range(3):  # axis by axis: a cube's neighbours are those of its edges' neighbours
            shift = np.zeros(3, np.int32)
            shift[axis] = 1
            cells = np.unique(np.concatenate([cells + k * shift for k in range(-steps, steps + 1)]), axis=0)
        return CellMap(cells, self.resolution)

    def __repr__(self) -> str:
        return f"CellMap({len(self.cells)} cells of {self.resolution:g} m)"


Solid = Box | Cylinder | Sphere | Mesh | CellMap
"""Any of the shapes."""


def _lengths(what: str, values: Sequence[float], count: int) -> tuple[float, ...]:
    lengths = tuple(float(v) for v in values)
    if len(lengths) != count or not all(np.isfinite(v) and v > 0 for v in lengths):
        raise ValueError(f"a {what} has {count} positive length{'s' if count > 1 else ''}, not {lengths}")
    return lengths
