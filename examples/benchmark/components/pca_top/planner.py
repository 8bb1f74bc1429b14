"""Grasps from above by the principal axes of what stands out of a table. Plain numpy.

The hand goes straight down over the middle of the points and closes along the axis along which they spread least, or,
less gladly, along the other one. All of a thing counts as one solid box: a method as simple as can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LOWEST = 0.008  # what is lower is the table [m]
FEWEST = 20  # points that make a thing
DEEP = 0.035  # tips below the top, at most [m]
WIDEST = 0.080
NEAR = 0.15  # what lies farther from the middle is another thing [m]


@dataclass(frozen=True)
class TopGrasp:
    """A grasp from above.

    Attributes:
        position: between the finger tips, shape (3,) [m].
        closing: horizontal unit vector, shape (3,).
        width: of the thing along it [m].
    """

    position: Array
    closing: Array
    width: float
    score: float


def plan(points: Array) -> list[TopGrasp]:
    """Return grasps of what stands out of the table, best first.

    Args:
        points: shape (n, 3) [m], z up, the table at 0.
    """
    points = points[np.isfinite(points).all(axis=1)]
    above = points[points[:, 2] > LOWEST]
    if len(above) < FEWEST:
        return []
    above = above[np.linalg.norm(above[:, :2] - np.median(above[:, :2], axis=0), axis=1) < NEAR]
    if len(above) < FEWEST:
        return []
    flat = above[:, :2] - above[:, :2].mean(axis=0)
    _, axes = np.linalg.eigh(flat.T @ flat)
    top = float(np.percentile(above[:, 2], 98))
    height = max(top / 2, top - DEEP)
    found = []
    for rank, axis in enumerate(axes.T):  # eigenvalues ascend: the shorter axis comes first
        low, high = np.percentile(flat @ axis, [1, 99])
        other_low, other_high = np.percentile(flat @ axes.T[1 - rank], [1, 99])
        if high - low > WIDEST:
            continue
        spot = above[:, :2].mean(axis=0) + (low + high) / 2 * axis + (other_low + other_high) / 2 * axes.T[1 - rank]
        closing, score = np.array([*axis, 0.0]), 1.0 - (high - low) / WIDEST / 2 - rank / 2
        found.append(TopGrasp(np.array([*spot, height]), closing, float(high - low), float(score)))
    return found


def quaternion(closing: Array) -> Array:
    """Return x y z w of a hand whose x looks down and whose z is a horizontal unit vector."""
    half = np.arctan2(closing[1], closing[0]) / 2
    turn = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])  # about the vertical, w x y z
    own = np.array([np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0])  # x goes down, z along the world's x
    w, x, y, z = _product(turn, own)
    return np.array([x, y, z, w])


def _product(a: Array, b: Array) -> Array:
    v = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *v])
