"""Collision shapes from solids and mesh files."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError, MissingPartError
from grip_bt.base.values.solids import Mesh

from ..description.packages import Packages


def simplified(objects: Iterable[pin.GeometryObject]) -> list[pin.GeometryObject]:
    """Return collision objects that are quicker to check: meshes become their convex hulls, which contain them."""
    shapes = list(objects)
    for shape in shapes:
        if isinstance(shape.geometry, coal.BVHModelBase):
            shape.geometry.buildConvexHull(True, "Qt")
            shape.geometry = shape.geometry.convex
    return shapes


FORMATS = ("dae", "obj", "ply", "stl")


def load_mesh(
    file: str | Path,
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0),
    *,
    hollow: bool = False,
    packages: Mapping[str, Path] | None = None,
    folder: Path | None = None,
) -> Mesh:
    """Read a mesh file.

    Args:
        file: a path, relative to `folder`, or `package://NAME/PATH`.
        scale: factors along x, y and z; 0.001 each for a file in mm.
        hollow: keep its surface; without it, its convex hull is taken, which is solid and quicker to check.
        packages: package name -> folder; what it lacks is looked for where the packages of robots are.
        folder: that relative paths begin in; the current one when None.

    Raises:
        DocumentError: there is no such file or package, or it isn't a mesh.
    """
    try:
        path = Packages(packages).resolve(os.path.expanduser(file), folder or Path())
    except MissingPartError as error:
        raise DocumentError(str(error), str(file)) from None
    if path.suffix.lower().lstrip(".") not in FORMATS:
        raise DocumentError(f"a mesh is a file of one of the formats {', '.join(FORMATS)}", str(path))
    if not path.is_file():
        raise DocumentError("there is no such mesh file", str(path))
    try:
        surface = coal.MeshLoader().load(str(path), np.asarray(scale, dtype=float))
        points = np.array(surface.vertices())
    except ValueError as error:
        reason = str(error).rpartition("message: ")[2].splitlines()
        raise DocumentError(f"it can't be read as a mesh: {' '.join(reason[1:]) or reason[0]}", str(path)) from None
    try:
        if hollow:
            corners = (surface.tri_indices(k) for k in range(surface.num_tris))
            return Mesh(points, np.array([[each[0], each[1], each[2]] for each in corners], np.int32).reshape(-1, 3))
        return hull_of(Mesh(points))
    except ValueError as error:
        raise DocumentError(str(error), str(path)) from None


def surface_of(mesh: Mesh) -> tuple[Array, NDArray[np.int32]]:
    """Return points and triangles of a mesh; those of its hull, thickened by its margin, where it is solid."""
    if mesh.hollow:
        return mesh.points, mesh.triangles
    hull = ConvexHull(mesh.points)
    if mesh.margin == 0:
        return mesh.points, hull.simplices.astype(np.int32)
    # Each point moved out along every axis and both ways: a hull that holds the true thickened one.
    steps = mesh.margin * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    points = (mesh.points[hull.vertices][:, None, :] + steps).reshape(-1, 3)
    return points, ConvexHull(points).simplices.astype(np.int32)


def hull_of(mesh: Mesh) -> Mesh:
    """Return the hull of a mesh with no more points than its corners; what is checked depends on these only."""
    return Mesh(np.array(convex_hull(mesh.points).points()), margin=mesh.margin)


def coal_mesh(mesh: Mesh) -> coal.CollisionGeometry:
    """Return the mesh as coal's convex body, or as its surface of triangles."""
    if not mesh.hollow:
        body = convex_hull(mesh.points)
        body.setSweptSphereRadius(mesh.margin)
        return body
    surface = coal.BVHModelOBBRSS()
    surface.beginModel(len(mesh.triangles), len(mesh.points))
    surface.addVertices(np.array(mesh.points))
    surface.addTriangles(np.array(mesh.triangles, dtype=np.int32))
    surface.endModel()
    return surface


def convex_hull(points: Array) -> coal.ConvexBase:
    """Return the convex hull of points."""
    rows = coal.StdVec_Vec3s()
    rows.extend(list(np.array(points)))
    return coal.Convex.convexHull(rows, True, "Qt")
