"""Rounded corners: paths that pass a way point without a stop, within a radius of it.

Where the grasp frame comes into the ball about a way point the arm leaves the segment that leads there, and where the
next segment leaves the ball it is on that one. In between it goes smoothly from one to the other, as both go on:
(1 - a(s)) in(s) + a(s) out(s), with a quintic `a`, so that velocity and acceleration are continuous (as MoveIt's Pilz
planner blends; there in time, here in joint space and along the path, which is timed afterwards).
"""

from __future__ import annotations

import numpy as np

from grip_bt.base.arrays import Array, Path

from ..kinematics.model import Chain

RESOLUTION = 0.02
"""Joint step [rad] with which a segment is looked at for where it crosses the ball."""
SMALLEST = 1e-3
"""A smaller blend isn't worth it: the arm comes to rest at the point [m]."""
OUTSIDE = 1e-4
"""A rounded corner may be so far outside the ball [m]."""
_SPACING = 0.06
_SAME = 1e-4
_CLOSE = 0.01
"""Rows of a segment so near to a blend [rad] are left out: the spline through both would bend."""


class Leg:
    """One of the two segments that meet at a way point, looked at from there.

    Args:
        path: the segment's configurations, shape (k, n), the first one at the way point.
    """

    def __init__(self, chain: Chain, path: Path):
        self._path = path
        half = arc(path)[-1] / 2
        self._at = np.linspace(0.0, half, int(np.ceil(half / RESOLUTION)) + 2)
        origins = np.stack([chain.grasp_pose(q).translation for q in at_arc(path, self._at)])
        self._distances = np.linalg.norm(origins - origins[0], axis=1)

    @property
    def reach(self) -> float:
        """The radius of the largest ball that the first half of the segment leaves [m]."""
        return float(self._distances.max())

    def crossing(self, radius: float) -> float:
        """Return how far along the segment [rad] it leaves a ball, which is no larger than its reach."""
        last = max(1, int(np.argmax(self._distances >= radius - 1e-9)))
        before, after = self._distances[last - 1], self._distances[last]
        return float(np.interp(radius, [before, after], self._at[last - 1 : last + 1]))

    def until(self, length: float, parts: Array) -> Path:
        """Return the configurations at `parts`, shape (m,), of its first `length` [rad], shape (m, n)."""
        return at_arc(self._path, parts * length)


def largest_radius(incoming: Leg, outgoing: Leg) -> float:
    """Return the largest blend radius at a way point [m]: no blend takes more than half of a segment."""
    return min(incoming.reach, outgoing.reach)


def corner(incoming: Leg, outgoing: Leg, radius: float) -> Path:
    """Return the rounded corner: configurations from where it leaves one segment to where it joins the next."""
    before, after = incoming.crossing(radius), outgoing.crossing(radius)
    count = int(np.clip(np.ceil((before + after) / _SPACING), 8, 40))
    s = np.linspace(0.0, 1.0, count + 1)
    weight = (s**3 * (10 - 15 * s + 6 * s**2))[:, None]
    return (1 - weight) * incoming.until(before, 1 - s) + weight * outgoing.until(after, s)


def within(chain: Chain, way_point: Array, rows: Path, radius: float) -> bool:
    """Tell whether a corner's rows, shape (k, n), keep the grasp frame in the ball about a way point, shape (n,)."""
    centre = chain.grasp_pose(way_point).translation
    away = [np.linalg.norm(chain.grasp_pose(q).translation - centre) for q in rows]
    return bool(max(away) <= radius + OUTSIDE)


def without_ends(path: Path, begin: float, end: float) -> Path:
    """Return a segment without `begin` [rad] of its beginning and `end` [rad] of its end, which corners replace."""
    at = arc(path)
    first, last = begin, at[-1] - end
    kept = path[(at > first + _CLOSE) & (at < last - _CLOSE)]
    head, tail = at_arc(path, np.array([first, last]))
    return np.concatenate([head[None, :], kept, tail[None, :]])


def distinct(path: Path) -> Path:
    """Return a path without rows that are hardly away from the one before; both its ends stay."""
    rows = [path[0]]
    for row in path[1:-1]:
        if np.linalg.norm(row - rows[-1]) > _SAME and np.linalg.norm(row - path[-1]) > _SAME:
            rows.append(row)
    return np.stack([*rows, path[-1]])


def at_arc(path: Path, where: Array) -> Path:
    """Return the configurations so far along a path [rad], shape (m,) -> (m, n)."""
    at = arc(path)
    return np.stack([np.interp(where, at, column) for column in path.T], axis=1)


def arc(path: Path) -> Array:
    """Return how far along the path [rad] its rows are, joints weighted alike, shape (k,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
