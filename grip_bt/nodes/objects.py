"""Objects of the scene near a hand, regions, and free spots in an open box: geometry only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grip_bt.base.ports import Scene
from grip_bt.base.values import Grasp, Pose

SEEN = "seen_"
"""Objects that perception found; the next look replaces them."""
PLACED = "placed_"
"""Objects that were put down in a target; they stay."""
TABLE_GAP = 0.003
"""Boxes of objects end this far above what they stand on [m], so that lifting one doesn't begin with a contact."""
HELD = "held_"
"""Objects that move with a hand; the rest of the name is the hand's."""


def distances_to_box(points: ArrayLike, size: ArrayLike, pose: Pose) -> NDArray[np.float64]:
    """Return the distances of points, shape (n, 3), from a box; 0 inside; shape (n,) [m]."""
    local = (np.asarray(points, dtype=float) - pose.position) @ pose.rotation()
    outside = np.maximum(np.abs(local) - np.asarray(size, dtype=float) / 2, 0)
    away: NDArray[np.float64] = np.linalg.norm(outside, axis=1)
    return away


def object_at(scene: Scene, grasp: Grasp, within: float = 0.03) -> str | None:
    """Return the seen object that a grasp takes, or None when there is none `within` [m] of where it closes."""
    seen = [(n, *scene.box(n)) for n in scene.names() if n.startswith(SEEN)]
    for point in grasp.closing_points():
        away = ((float(distances_to_box([point], size, pose)[0]), n) for n, size, pose in seen)
        distance, name = min(away, default=(np.inf, None))
        if distance <= within:
            return name
    return None


def objects_near(scene: Scene, hand: Pose, within: float = 0.09) -> tuple[str, ...]:
    """Return the seen and placed objects `within` [m] of the middle of an open hand whose grasp frame is at `hand`."""
    middle = hand.apply([[0.04, 0.0, 0.04]])
    names = (n for n in scene.names() if n.startswith((SEEN, PLACED)))
    return tuple(n for n in names if distances_to_box(middle, *scene.box(n))[0] <= within)


@dataclass(frozen=True, slots=True)
class Region:
    """The inside of an open box with upright walls along x and y.

    Attributes:
        low: smallest x and y, shape (2,) [m].
        high: largest x and y, shape (2,) [m].
        floor: height of the floor [m].
        rim: height of the walls' upper edge [m].
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    floor: float
    rim: float

    def contains(self, points: ArrayLike, margin: float = 0.0) -> NDArray[np.bool_]:
        """Tell which points, shape (n, 2 or 3), lie within the walls widened by `margin` [m]; shape (n,)."""
        xy = np.asarray(points, dtype=float)[:, :2]
        inside: NDArray[np.bool_] = np.all((xy >= self.low - margin) & (xy <= self.high + margin), axis=1)
        return inside


def region_of(scene: Scene, target: str) -> Region | None:
    """Return the region bounded by the scene's boxes `<target>_*`, else the scene's region of that name, else None.

    A box whose middle lies on one side of the others bounds that side with its inner face. The floor is the lowest
    edge of the walls, and the rim the highest.
    """
    boxes = [scene.box(n) for n in scene.names() if target and n.startswith(f"{target}_")]
    if not boxes:
        regions = scene.regions()
        if target not in regions:
            return None
        inner_low, inner_high = _bounds(*regions[target])
        return Region(inner_low[:2], inner_high[:2], float(inner_low[2]), float(inner_low[2]))
    lows, highs = (np.array(c) for c in zip(*(_bounds(size, pose) for size, pose in boxes), strict=True))
    outer_low, outer_high = lows.min(axis=0), highs.max(axis=0)
    low, high = outer_low[:2].copy(), outer_high[:2].copy()
    middle = (low + high) / 2
    for wall_low, wall_high in zip(lows[:, :2], highs[:, :2], strict=True):
        axis = int(np.argmin(wall_high - wall_low))
        if wall_high[axis] <= middle[axis]:
            low[axis] = max(low[axis], wall_high[axis])
        elif wall_low[axis] >= middle[axis]:
            high[axis] = min(high[axis], wall_low[axis])
    return Region(low, high, float(outer_low[2]), float(outer_high[2]))


def _bounds(size: ArrayLike, pose: Pose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    half = np.abs(pose.rotation()) @ (np.asarray(size, dtype=float) / 2)
    return pose.position - half, pose.position + half


def rename(scene: Scene, name: str, new_name: str) -> None:
    """Put the object `name` under another name, where it is now, free of any hand."""
    solid, pose = scene.solid(name)
    scene.detach(name)
    scene.remove(name)
    scene.put(new_name, solid, pose)


def free_name(scene: Scene, prefix: str) -> str:
    """Return the first of `prefix0`, `prefix1` ... that the scene doesn't have."""
    taken = set(scene.names())
    return next(name for i in range(len(taken) + 1) if (name := f"{prefix}{i}") not in taken)


FINGER = 0.13
"""How far open fingers reach from the grasp frame [m]."""
_WALL = 0.02
"""Distance to keep from the walls [m]: the fingers open in it."""


@dataclass(frozen=True, slots=True)
class Disc:
    """The upright circle around an object's foot: centre x, y and radius [m]."""

    x: float
    y: float
    radius: float

    @classmethod
    def around(cls, size: ArrayLike, pose: Pose) -> Disc:
        """Return the circle within the foot of an upright box; corners stick out of it by up to 0.41 radii."""
        return cls(float(pose.position[0]), float(pose.position[1]), float(max(np.asarray(size)[:2])) / 2)

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distance of points, shape (n, 2), from the circle; negative inside; shape (n,) [m]."""
        away: NDArray[np.float64] = np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius
        return away


def free_spots(region: Region, radius: float, taken: Sequence[Disc], count: int = 8) -> NDArray[np.float64]:
    """Return places for an object's centre, the best first, shape (k, 2) with k <= count [m].

    Good is far from what stands there and, while there is room, far from the middle, so that the next object finds room
    too. Spots keep 4 cm from each other, so that they are really different.
    """
    low, high = region.low + radius + _WALL, region.high - radius - _WALL
    if np.any(high < low):
        return np.zeros((0, 2))
    axes = [np.linspace(a, b, max(2, round((b - a) / 0.02) + 1)) for a, b in zip(low, high, strict=True)]
    spots = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    room = _room_at(spots, taken) - radius
    spots, room = spots[room > 0.01], room[room > 0.01]
    from_middle = np.linalg.norm((spots - (region.low + region.high) / 2) / (region.high - region.low), axis=1)
    order = np.argsort(-(np.minimum(room, 0.12) + 0.1 * from_middle), kind="stable")
    chosen: list[NDArray[np.float64]] = []
    for spot in spots[order]:
        if all(np.linalg.norm(spot - other) > 0.04 for other in chosen):
            chosen.append(spot)
        if len(chosen) == count:
            break
    return np.array(chosen).reshape(-1, 2)


def _room_at(points: NDArray[np.float64], taken: Sequence[Disc]) -> NDArray[np.float64]:
    """Return each point's distance from the nearest object, shape (n,) [m]; 1 where there is none."""
    return np.asarray(np.min([np.ones(len(points)), *(disc.distance(points) for disc in taken)], axis=0))


def opening_room(hand: Pose, taken: Sequence[Disc]) -> float:
    """Return how far the fingers stay from other objects while the hand opens, seen from above [m].

    The fingers swing a quarter of a disc, in the plane of x and z of the grasp frame at the release.
    """
    angle, reach = np.meshgrid(np.linspace(0, np.pi / 2, 7), np.linspace(0.03, FINGER, 5))
    swing = np.stack([reach * np.cos(angle), 0 * angle, reach * np.sin(angle)], axis=-1).reshape(-1, 3)
    return float(_room_at(hand.apply(swing)[:, :2], taken).min())
