"""Where in an open box an object can be put down, and how the hand may stand while it lets go: geometry only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grip_bt.base.values import Pose

from .objects import Region

FINGER = 0.13
"""How far open fingers reach from the grasp frame [m]."""
WALL = 0.02
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
    low, high = region.low + radius + WALL, region.high - radius - WALL
    if np.any(high < low):
        return np.zeros((0, 2))
    axes = [np.linspace(a, b, max(2, round((b - a) / 0.02) + 1)) for a, b in zip(low, high, strict=True)]
    spots = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    room = room_at(spots, taken) - radius
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


def room_at(points: NDArray[np.float64], taken: Sequence[Disc]) -> NDArray[np.float64]:
    """Return each point's distance from the nearest object, shape (n,) [m]; 1 where there is none."""
    nearest = np.full(len(points), 1.0)
    for disc in taken:
        nearest = np.minimum(nearest, disc.distance(points))
    return nearest


def opening_room(hand: Pose, taken: Sequence[Disc]) -> float:
    """Return how far the fingers stay from other objects while the hand opens, seen from above [m].

    The fingers swing, in the plane of the palm's normal (z) and their own direction (x), from around the object to
    straight: a quarter of a disc. `hand` is the grasp frame at the release.
    """
    angle, reach = np.meshgrid(np.linspace(0, np.pi / 2, 7), np.linspace(0.03, FINGER, 5))
    swing = np.stack([reach * np.cos(angle), 0 * angle, reach * np.sin(angle)], axis=-1).reshape(-1, 3)
    return float(room_at(hand.apply(swing)[:, :2], taken).min())


def turned(yaw: float) -> NDArray[np.float64]:
    """Return the quaternion, w x y z, of a turn about the vertical [rad]."""
    return np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])
