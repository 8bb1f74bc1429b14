"""Collision checks of a chain against itself and a scene: batched on all cores, and with the names of what touches."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

import coal
import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array, Mask
from grip_bt.base.values.solids import Box, Cylinder, Mesh, Solid, Sphere

from ..scene_state import SceneObject, SceneSnapshot
from .model import GRASP_FRAME, Chain
from .outline import between, shape_reaches
from .shapes import coal_mesh

HELD_SLACK = 0.01
"""What is held is checked with this much [m] taken off every side.

It stands on its support when it is taken and when it is put down, its box comes from a camera, and it may
shift a little in the fingers: a check of its full size would refuse every lift. A checker with a margin
takes nothing off: there the held object keeps the margin too, else it would brush past its neighbours.
"""
_ENOUGH_FOR_THREADS = 64
_ONE_BY_ONE = 24
"""Of configurations that all have to be free, this many are checked first: mostly one of these collides."""
_Pool: TypeAlias = pin.TreeBroadPhaseManagerPool_DynamicAABBTreeCollisionManager


class CollisionChecker:
    """Checks configurations of a chain in one scene. It belongs to one thread.

    Attributes:
        reaches: how far each joint moves what is furthest from it [m/rad], shape (n,).

    Args:
        hand: the hand at the chain's end; what it holds moves along and may touch it.
        margin: distance [m] to keep from the objects of the scene; the robot itself needs none.
    """

    def __init__(self, chain: Chain, scene: SceneSnapshot, hand: str = "", margin: float = 0.0):
        self.chain, self.scene, self.made_of = chain, scene, (chain, scene, [*scene.objects], hand, margin)
        self._geometry, self._outline = chain.geometry.copy(), chain.outline.geometry.copy()
        self._place = dict(chain.outline.place)
        self._names = list(chain.links)
        robot = range(self._geometry.ngeoms)
        slack = HELD_SLACK if margin == 0 else 0.0
        held = [self._add(o, chain.model.frames[chain.frame], -slack) for o in scene.attached(hand)]
        world = [self._add(o, None, margin) for o in scene.objects.values() if not o.hand]
        carried = {self._add(o, frame, -slack): o.hand for o, frame in self._held_by_others(hand)}
        moving = [k for k in robot if self._geometry.geometryObjects[k].parentJoint > 0]
        own = self._links_of(hand)
        self._against = np.zeros((self._geometry.ngeoms, self._geometry.ngeoms), dtype=bool)
        self._pair([k for k in robot if k not in own], held)
        self._pair([*moving, *held], world)
        for one, other_hand in carried.items():
            still = self._geometry.geometryObjects[one].parentJoint == 0
            theirs = self._links_of(other_hand)
            self._pair([k for k in (moving if still else robot) if k not in theirs], [one])
            self._pair(held if still else [*held, *world], [one])
        joint = [shape.parentJoint for shape in self._geometry.geometryObjects]
        for one, other in combinations(carried, 2):  # what different hands hold, where they can move apart
            if carried[one] != carried[other] and joint[one] != joint[other]:
                self._pair([one], [other])
        self._set_pairs()
        self._lent = shape_reaches(
            chain.model, [self._geometry.geometryObjects[k] for k in self._place if k not in robot]
        )
        self.reaches = np.hstack([chain.reaches, self._lent]).max(axis=1, initial=0.0)
        self._threads = min(os.cpu_count() or 1, 8)
        self._rough = _Pool(chain.model, self._outline, self._threads)

    @cached_property
    def _pool(self) -> _Pool:
        """All shapes; made when an outline touches something for the first time, since it takes a millisecond."""
        return _Pool(self.chain.model, self._geometry, self._threads)

    @cached_property
    def _data(self) -> pin.GeometryData:
        return self._geometry.createData()

    def _held_by_others(self, hand: str) -> Iterator[tuple[SceneObject, pin.Frame]]:
        """Yield what other hands hold, with the frame of this chain's model that it moves with."""
        model, scene = self.chain.model, self.scene
        for item in scene.objects.values():
            if item.hand and item.hand != hand and item.hand in scene.carriers:
                frame = f"{GRASP_FRAME}/{scene.carriers[item.hand].group}"
                frame = frame if model.existFrame(frame) else GRASP_FRAME
                yield item, model.frames[model.getFrameId(frame)]

    def _links_of(self, hand: str) -> frozenset[int]:
        """Return the indices of a hand's shapes; those of all hands, where it isn't known which are whose."""
        if hand not in self.scene.carriers:
            return self.chain.hand
        links = self.scene.carriers[hand].links
        return frozenset(k for k, link in enumerate(self.chain.links) if link in links)

    def free(self, q: Array) -> bool:
        """Tell whether a configuration, shape (n,), touches nothing."""
        return bool(self.all_free(q[None, :]))

    def all_free(self, configurations: Array) -> bool:
        """Tell whether none of the configurations, shape (k, n), touches anything; stops at the first that does.

        Put first what is likely to touch.
        """
        first = configurations[:_ONE_BY_ONE]
        while len(first):  # one thread stops at the first that touches, having seen all before it
            touching = self._ask(self._rough, first, stop_at_first=True)
            if not touching.any():
                break
            row = int(np.argmax(touching))
            if self._ask(self._pool, first[row : row + 1], stop_at_first=True).any():
                return False
            first = first[row + 1 :]
        rest = configurations[_ONE_BY_ONE:]
        return not len(rest) or not self._collide(rest, stop_at_first=True).any()

    def free_each(self, configurations: Array) -> Mask:
        """Tell for each of the configurations, shape (k, n), whether it touches nothing; shape (k,)."""
        return ~self._collide(configurations, stop_at_first=False)

    def pairs(self, q: Array) -> tuple[tuple[str, str], ...]:
        """Return the names of the links and objects that touch one another in a configuration, without repetition."""
        if self.free(q):
            return ()
        pin.computeCollisions(self.chain.model, self.chain.data, self._geometry, self._data, q, False)
        touching = zip(self._geometry.collisionPairs, self._data.collisionResults, strict=True)
        names = ((self._names[p.first], self._names[p.second]) for p, result in touching if result.isCollision())
        return tuple(dict.fromkeys(names))

    def clear_each(self, configurations: Array, margin: float) -> Mask:
        """Tell of which configurations, shape (k, n), it is certain that whatever could touch is `margin` [m] apart.

        A hand counts as its hull here: False doesn't mean that it isn't so.
        """
        count = self._outline.ngeoms
        return self._clear_each(configurations, np.full((count, count), margin))

    def clear_while_moving(self, configurations: Array, motion: Array, hulls: bool = True) -> Mask:
        """Tell from which configurations, shape (k, n), the joints can certainly move so far and touch nothing.

        Two things come closer only by the joints between them, so what is always near, such as links of a wrist,
        isn't doubtful because a shoulder moves. A hand counts as its hull: False doesn't mean that it isn't so.

        Args:
            configurations: where the joints are.
            motion: at most so far each joint moves, either way [rad or m], shape (n,).
            hulls: False: as its shapes, which takes longer.
        """
        between = self._between if hulls else self._between_shapes
        return self._clear_each(configurations, np.tensordot(motion, between, axes=1), hulls)

    def _clear_each(self, configurations: Array, margins: Array, hulls: bool = True) -> Mask:
        pool, geometry = (self._rough, self._outline) if hulls else (self._pool, self._geometry)
        _keep_apart(pool, geometry, margins)
        result: Mask = ~self._ask(pool, configurations, stop_at_first=False)
        _keep_apart(pool, geometry, np.zeros_like(margins))
        return result

    @cached_property
    def _between(self) -> Array:
        """How far each joint can move two shapes of the outline against one another, shape (n, k, k)."""
        return between(np.hstack([self.chain.outline_reaches, self._lent]))

    @cached_property
    def _between_shapes(self) -> Array:
        """How far each joint can move two shapes against one another, shape (n, k, k)."""
        return between(np.hstack([self.chain.reaches, self._lent]))

    def _collide(self, configurations: Array, stop_at_first: bool) -> Mask:
        """Ask the outline first: nearly all that is free is seen to be free by it."""
        result = self._ask(self._rough, configurations, stop_at_first=False)
        suspects = np.flatnonzero(result)
        if len(suspects):
            result[suspects] = self._ask(self._pool, configurations[suspects], stop_at_first)
        return result

    def _ask(self, pool: _Pool, configurations: Array, stop_at_first: bool) -> Mask:
        columns = np.asfortranarray(configurations.T)
        threads = self._threads if columns.shape[1] >= _ENOUGH_FOR_THREADS else 1
        return np.array(pin.computeCollisionsInParallel(threads, pool, columns, True, stop_at_first), dtype=bool)

    def _add(self, item: SceneObject, frame: pin.Frame | None, margin: float) -> int:
        placement = pin.SE3(item.pose.matrix())
        joint = 0
        if frame is not None:
            joint, placement = frame.parentJoint, frame.placement * placement
        shape, name = _shape(item.shape.grown(margin)), f"scene/{item.name}"
        self._names.append(item.name)
        index = int(self._geometry.addGeometryObject(pin.GeometryObject(name, joint, placement, shape)))
        self._place[index] = int(self._outline.addGeometryObject(pin.GeometryObject(name, joint, placement, shape)))
        return index

    def _pair(self, ones: Sequence[int], others: Sequence[int]) -> None:
        """Look at shapes against others, where a contact isn't allowed."""
        if not self.scene.allowed:
            self._against[np.ix_(ones, others)] = True
            return
        for one in ones:
            name = self._names[one]
            self._against[one, [k for k in others if not self.scene.may_touch(name, self._names[k])]] = True

    def _set_pairs(self) -> None:
        """Give the pairs to both geometries, each in one go: one by one they take longer than all the rest."""
        one, other = np.nonzero(self._against)
        place = np.array([self._place[k] for k in range(self._geometry.ngeoms)], dtype=int)
        for geometry, a, b in ((self._geometry, one, other), (self._outline, place[one], place[other])):
            pairs = geometry.collisionPairMapping >= 0
            pairs[np.minimum(a, b), np.maximum(a, b)] = True
            geometry.setCollisionPairs(pairs)


_KEPT = 16
_newest: list[CollisionChecker] = []


def checker_of(chain: Chain, scene: SceneSnapshot, hand: str = "", margin: float = 0.0) -> CollisionChecker:
    """Return a checker, one of the newest where it was made of the same: most plans are made in the scene before."""
    made_of = chain, scene, [*scene.objects], hand, margin
    same = [each for each in _newest if each.made_of == made_of] or [CollisionChecker(chain, scene, hand, margin)]
    _newest[:] = [*same, *(each for each in _newest if each not in same)][:_KEPT]
    return same[0]


def _keep_apart(pool: _Pool, geometry: pin.GeometryModel, margins: Array) -> None:
    for manager in pool.getBroadPhaseManagers():
        manager.getGeometryData().setSecurityMargins(geometry, margins)


def _shape(shape: Solid) -> coal.CollisionGeometry:
    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.height)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    return coal_mesh(shape) if isinstance(shape, Mesh) else coal.makeOctree(shape.middles(), shape.resolution)
