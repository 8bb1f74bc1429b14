"""Things on a table as groups of points, and an upright box around each."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from grip_bt.base.values import Pose

from .objects import TABLE_GAP
from .spots import turned

Points = NDArray[np.floating]


def clusters_above(points: Points, low: float, high: float, cell: float, min_points: int) -> list[Points]:
    """Group points by what touches what, seen from above.

    The points between the heights `low` and `high` [m] are entered into a grid of `cell` [m]; occupied cells that
    touch, also at a corner, are one group (`cv2.connectedComponents`). Groups of fewer than `min_points` are noise.

    Args:
        points: shape (n, 3), z up [m]; points that aren't finite are left out.
        low: lowest height that counts.
        high: highest height that counts.
        cell: edge of a cell.
        min_points: smallest group.

    Returns:
        One array of shape (k, 3) per group, the largest first.
    """
    points = points[np.isfinite(points).all(axis=1)]
    points = points[(points[:, 2] > low) & (points[:, 2] < high)]
    if not len(points):
        return []
    cells = np.floor(points[:, :2] / cell).astype(np.int64)
    cells -= cells.min(axis=0)
    grid = np.zeros(cells.max(axis=0) + 1, np.uint8)
    grid[cells[:, 0], cells[:, 1]] = 1
    count, labels = cv2.connectedComponents(grid, connectivity=8)
    label = labels[cells[:, 0], cells[:, 1]]
    groups = [points[label == k] for k in range(1, count)]
    return sorted((g for g in groups if len(g) >= min_points), key=len, reverse=True)


def upright_box(points: Points, floor: float) -> tuple[NDArray[np.float64], Pose]:
    """Return the smallest upright box around points that reaches down to `floor` [m].

    A camera above sees the top of a thing and little of its sides, so the box goes from the highest points down to
    what the thing stands on. Its foot is the rectangle of least area around the points seen from above
    (`cv2.minAreaRect`, rotating calipers).

    Returns:
        Edge lengths, shape (3,) [m], and the box's pose in the frame of the points.
    """
    (x, y), (width, depth), angle = cv2.minAreaRect(points[:, :2].astype(np.float32))
    top, bottom = float(points[:, 2].max()), floor + TABLE_GAP
    size = np.array([max(width, 0.005), max(depth, 0.005), max(top - bottom, 0.005)])
    return size, Pose([x, y, bottom + size[2] / 2], turned(np.radians(angle)))
