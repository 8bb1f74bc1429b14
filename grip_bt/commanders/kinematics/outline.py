"""A robot's outline: the same shapes, but each hand is one convex hull around all that moves with its palm.

An Allegro hand has 27 shapes, and each is checked against the arm and the whole scene. Nearly every free
configuration is seen to be free by the hull alone, at a third of the time; only the others are looked at in full.
The hull contains the shapes, so what is free with it is free without it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array

from .shapes import convex_hull


@dataclass(frozen=True)
class Outline:
    """A coarser geometry.

    Attributes:
        geometry: the shapes and the pairs to check: those of which one shape behind each member has one.
        place: index of a shape -> index of what stands for it.
    """

    geometry: pin.GeometryModel
    place: Mapping[int, int]


def outlined(geometry: pin.GeometryModel, grouped: Iterable[int]) -> Outline:
    """Return the geometry with those of the `grouped` shapes that move as one body replaced by their hull."""
    groups = [group for group in _by_body(geometry, grouped) if len(group) > 1]
    shapes, outline, place = geometry.geometryObjects, pin.GeometryModel(), {}
    hulled = {k for group in groups for k in group}
    for k, shape in enumerate(shapes):
        if k not in hulled:
            place[k] = outline.addGeometryObject(pin.GeometryObject(shape))
    for group in groups:
        points = np.vstack([corners(shapes[k]) for k in group])
        body = pin.GeometryObject(
            f"hull/{shapes[group[0]].name}", shapes[group[0]].parentJoint, pin.SE3.Identity(), convex_hull(points)
        )
        place |= dict.fromkeys(group, outline.addGeometryObject(body))
    pairs = {tuple(sorted((place[p.first], place[p.second]))) for p in geometry.collisionPairs}
    for one, other in sorted(pairs):
        if one != other:
            outline.addCollisionPair(pin.CollisionPair(one, other))
    return Outline(outline, place)


def shape_reaches(model: pin.Model, shapes: Iterable[pin.GeometryObject]) -> Array:
    """Return how far from each joint's axis each shape can come [m, or m per m for a sliding joint], shape (nv, k).

    It is 0 where the joint doesn't move the shape. The displacement of any point of a shape is at most the sum over the
    joints of this times the joint's motion.
    """
    columns = []
    for shape in shapes:
        column, joint = np.zeros(model.nv), shape.parentJoint
        radius = float(np.linalg.norm(corners(shape), axis=1).max()) if joint else 0.0
        while joint:
            kind, stroke = model.joints[joint], 0.0
            if kind.shortname() in _SLIDING:
                stroke = max(abs(model.lowerPositionLimit[kind.idx_q]), abs(model.upperPositionLimit[kind.idx_q]))
                column[kind.idx_v] = 1.0
            else:
                column[kind.idx_v] = radius
            radius += float(np.linalg.norm(model.jointPlacements[joint].translation)) + stroke
            joint = model.parents[joint]
        columns.append(column)
    return np.array(columns).reshape(-1, model.nv).T


def between(moved: Array) -> Array:
    """Return how far each joint can move two shapes against one another [m/rad], shape (nv, k, k).

    A joint that moves both moves them alike; so it counts only where it moves one of them.

    Args:
        moved: see `shape_reaches`, shape (nv, k).
    """
    one, other = moved[:, :, None], moved[:, None, :]
    return np.where((one > 0) != (other > 0), one + other, 0.0)


_SLIDING = ("JointModelPX", "JointModelPY", "JointModelPZ", "JointModelPrismaticUnaligned")


def _by_body(geometry: pin.GeometryModel, grouped: Iterable[int]) -> list[list[int]]:
    bodies: dict[int, list[int]] = {}
    for k in sorted(grouped):
        bodies.setdefault(geometry.geometryObjects[k].parentJoint, []).append(k)
    return [group for body, group in bodies.items() if body > 0]


def corners(shape: pin.GeometryObject) -> Array:
    """Return points in the body's frame, shape (k, 3), whose convex hull contains the shape."""
    solid = shape.geometry
    if isinstance(solid, coal.ConvexBase):
        points = np.array(solid.points())
    else:
        solid.computeLocalAABB()
        low, high = solid.aabb_local.min_, solid.aabb_local.max_
        points = np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    return points @ shape.placement.rotation.T + shape.placement.translation
