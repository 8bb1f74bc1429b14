"""Collision checks of a chain against itself and a scene: batched on all cores, and with the names of what touches."""

from __future__ import annotations

import os

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from .model import Chain, link_of
from .scene import Box, Cylinder, SceneObject, SceneSnapshot

HELD_SLACK = 0.01
"""What is held is checked with this much [m] taken off every side.

It stands on its support when it is taken and when it is put down, its box comes from a camera, and it may
shift a little in the fingers: a check of its full size would refuse every lift. A checker with a margin
takes nothing off: there the held object keeps the margin too, else it would brush past its neighbours.
"""
_ENOUGH_FOR_THREADS = 64


class CollisionChecker:
    """Checks configurations of a chain in one scene. It belongs to one thread.

    Args:
        chain: what moves.
        scene: what is avoided.
        hand: the hand at the chain's end; what it holds moves along and may touch it.
        margin: distance [m] to keep from the objects of the scene; the robot itself needs none.
    """

    def __init__(self, chain: Chain, scene: SceneSnapshot, hand: str = "", margin: float = 0.0):
        self.chain, self.scene = chain, scene
        self._geometry = chain.geometry.copy()
        self._names = [link_of(chain.model, s) for s in self._geometry.geometryObjects]
        robot = range(self._geometry.ngeoms)
        slack = HELD_SLACK if margin == 0 else 0.0
        held = [self._add(o, chain.model.frames[chain.frame], -slack) for o in scene.attached(hand)]
        others = [o for o in scene.objects.values() if not o.hand]
        world = [self._add(o, None, margin) for o in others]
        moving = [k for k in robot if self._geometry.geometryObjects[k].parentJoint > 0]
        self._pair([k for k in robot if k not in chain.hand], held)
        self._pair([*moving, *held], world)
        threads = min(os.cpu_count() or 1, 8)
        self._threads = threads
        self._pool = pin.TreeBroadPhaseManagerPool_DynamicAABBTreeCollisionManager(chain.model, self._geometry, threads)
        self._data = self._geometry.createData()

    def free(self, q: NDArray[np.float64]) -> bool:
        """Tell whether a configuration, shape (n,), touches nothing."""
        return bool(self.all_free(q[None, :]))

    def all_free(self, configurations: NDArray[np.float64]) -> bool:
        """Tell whether none of the configurations, shape (k, n), touches anything; stops at the first that does."""
        return not self._collide(configurations, stop_at_first=True).any()

    def free_each(self, configurations: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell for each of the configurations, shape (k, n), whether it touches nothing; shape (k,)."""
        result: NDArray[np.bool_] = ~self._collide(configurations, stop_at_first=False)
        return result

    def pairs(self, q: NDArray[np.float64]) -> tuple[tuple[str, str], ...]:
        """Return the names of the links and objects that touch one another in a configuration, without repetition."""
        pin.computeCollisions(self.chain.model, self.chain.data, self._geometry, self._data, q, False)
        touching = zip(self._geometry.collisionPairs, self._data.collisionResults, strict=True)
        names = ((self._names[p.first], self._names[p.second]) for p, result in touching if result.isCollision())
        return tuple(dict.fromkeys(names))

    def _collide(self, configurations: NDArray[np.float64], stop_at_first: bool) -> NDArray[np.bool_]:
        columns = np.asfortranarray(configurations.T)
        threads = self._threads if columns.shape[1] >= _ENOUGH_FOR_THREADS else 1
        result = pin.computeCollisionsInParallel(threads, self._pool, columns, True, stop_at_first)
        return np.asarray(result, dtype=bool)

    def _add(self, item: SceneObject, frame: pin.Frame | None, margin: float) -> int:
        placement = pin.SE3(item.pose.matrix())
        joint = 0
        if frame is not None:
            joint, placement = frame.parentJoint, frame.placement * placement
        shape = _shape(item.shape.grown(margin))
        self._names.append(item.name)
        return int(self._geometry.addGeometryObject(pin.GeometryObject(f"scene/{item.name}", joint, placement, shape)))

    def _pair(self, ones: list[int], others: list[int]) -> None:
        for one in ones:
            for other in others:
                if not self.scene.may_touch(self._names[one], self._names[other]):
                    self._geometry.addCollisionPair(pin.CollisionPair(one, other))


def _shape(shape: Box | Cylinder) -> coal.ShapeBase:
    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    return coal.Cylinder(shape.radius, shape.height)


__all__ = ["HELD_SLACK", "CollisionChecker"]
