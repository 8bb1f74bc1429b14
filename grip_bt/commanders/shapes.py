"""Collision shapes made cheap without making them wrong: convex hulls of meshes, capsules of rounded cylinders."""

from __future__ import annotations

from collections.abc import Iterable

import coal
import numpy as np
import pinocchio as pin

_TOUCH = 1e-4
"""Two lengths nearer than this [m] are equal in a model file."""


def simplified(objects: Iterable[pin.GeometryObject]) -> list[pin.GeometryObject]:
    """Return collision objects that are quicker to check.

    Meshes become their convex hulls, which contain them. A cylinder with two spheres of its radius at its ends,
    all of one link, becomes the capsule that is their union.
    """
    convex = [_convex(o) for o in objects]
    by_frame: dict[int, list[pin.GeometryObject]] = {}
    for shape in convex:
        by_frame.setdefault(shape.parentFrame, []).append(shape)
    return [shape for shapes in by_frame.values() for shape in _with_capsules(shapes)]


def _convex(shape: pin.GeometryObject) -> pin.GeometryObject:
    if isinstance(shape.geometry, coal.BVHModelBase):
        shape.geometry.buildConvexHull(True, "Qt")
        shape.geometry = shape.geometry.convex
    return shape


def _with_capsules(shapes: list[pin.GeometryObject]) -> list[pin.GeometryObject]:
    spheres = [s for s in shapes if isinstance(s.geometry, coal.Sphere)]
    merged: set[str] = set()
    for cylinder in (s for s in shapes if isinstance(s.geometry, coal.Cylinder)):
        ends = [_sphere_at(spheres, cylinder, side) for side in (-1, 1)]
        if all(ends):
            cylinder.geometry = coal.Capsule(cylinder.geometry.radius, 2 * cylinder.geometry.halfLength)
            merged.update(ends)  # type: ignore[arg-type]
    return [s for s in shapes if s.name not in merged]


def _sphere_at(spheres: list[pin.GeometryObject], cylinder: pin.GeometryObject, side: int) -> str | None:
    """Return the name of the sphere that rounds one end of a cylinder, or None."""
    end = cylinder.placement.act(np.array([0.0, 0.0, side * cylinder.geometry.halfLength]))
    for sphere in spheres:
        same_radius = abs(sphere.geometry.radius - cylinder.geometry.radius) < _TOUCH
        if same_radius and np.linalg.norm(sphere.placement.translation - end) < _TOUCH:
            return str(sphere.name)
    return None
