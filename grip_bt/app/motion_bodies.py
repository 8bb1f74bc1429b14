"""Bodies without a formula, as the record of a motion has them: few triangles, or few cells, each body written once."""

from __future__ import annotations

import hashlib
from base64 import b64encode
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.values.solids import CellMap, Mesh

FINE = 1500
"""Meshes with more triangles than this are made coarser."""
CUTS = 36
"""Into how many cells the longest side of such a mesh is cut: what lies in one cell becomes one point."""
MOST_CELLS = 4000
"""Maps with more cells get cells of twice the size, until they are few enough."""


def coarse(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return points and triangles of a mesh; of a fine one, the points of each cell as one (vertex clustering).

    Source: Rossignac and Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993.
    """
    points, triangles = np.asarray(mesh.points), np.asarray(mesh.triangles, dtype=np.int64)
    if len(triangles) <= FINE:
        return points, triangles
    cell = max(float(np.ptp(points, axis=0).max()) / CUTS, 1e-6)
    keys = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    _, which = np.unique(keys, axis=0, return_inverse=True)
    which = which.reshape(-1)
    count = np.bincount(which)
    merged = np.stack([np.bincount(which, points[:, axis]) / count for axis in range(3)], axis=1)
    moved = which[triangles]
    kept = moved[(moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 0] != moved[:, 2])]
    return merged, np.unique(kept, axis=0)


def few_cells(cells: CellMap) -> CellMap:
    """Return a map of at most `MOST_CELLS` cells that covers what the other one covers."""
    while len(cells.cells) > MOST_CELLS:
        cells = CellMap(np.floor_divide(cells.cells, 2), 2 * cells.resolution)
    return cells


class Bodies:
    """Gives each body a name by what it looks like, and tells those that are new."""

    def __init__(self) -> None:
        self._told: set[str] = set()
        self._new: dict[str, dict[str, str]] = {}

    def shape(self, shape: Mesh | CellMap) -> dict[str, Any]:
        """Return what an object of this shape is in the record: `kind`, `size`, `body`."""
        if isinstance(shape, CellMap):
            few = few_cells(shape)
            return {"kind": "cells", "size": [few.resolution], "body": self._name(few.middles(), None)}
        points, triangles = _surface(shape)
        size = [round(side, 5) for side in shape.extents()]
        return {"kind": "mesh", "size": size, "body": self._name(points, triangles)}

    def new(self) -> dict[str, dict[str, str]]:
        """Return the bodies that weren't told before: name -> `points` and `triangles`, each in base64.

        Points are float32 x y z [m] in the object's own frame; triangles uint32, three points each, none for cells.
        """
        new, self._new = self._new, {}
        return new

    def _name(self, points: NDArray[Any], triangles: NDArray[Any] | None) -> str:
        rows = np.ascontiguousarray(points, dtype="<f4").tobytes()
        corners = b"" if triangles is None else np.ascontiguousarray(triangles, dtype="<u4").tobytes()
        name = hashlib.sha256(rows + b"|" + corners).hexdigest()[:16]
        if name not in self._told:
            self._told.add(name)
            self._new[name] = {"points": b64encode(rows).decode(), "triangles": b64encode(corners).decode()}
        return name


def _surface(mesh: Mesh) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return points and triangles of a mesh; of a hull, those of its surface, grown by its margin from the middle."""
    if mesh.hollow:
        return coarse(mesh)
    from scipy.spatial import ConvexHull  # half a second that only a scene with a mesh needs

    hull = ConvexHull(mesh.points)
    kept = hull.vertices
    number = np.zeros(len(mesh.points), dtype=np.int64)
    number[kept] = np.arange(len(kept))
    points = mesh.points[kept]
    if mesh.margin:
        middle, sides = np.asarray(mesh.centre()), np.asarray(mesh.extents())
        points = middle + (points - middle) * sides / np.maximum(sides - 2 * mesh.margin, 1e-9)
    return coarse(Mesh(points, number[hull.simplices].astype(np.int32)))
