"""Places for a two-fingered hand in a point cloud, after Grasp Pose Detection (ten Pas et al. 2017). Numpy and OpenCV.

Points are drawn from what rises above the table; about each, the hand is turned and tilted, moved sideways until what
lies between its fingers is in their middle, and pushed in as deep as nothing is in its way. In place of GPD's network,
a geometric score: how many of the points that the fingers would meet have normals along which the fingers close, how
deep the thing lies between them, and how near its middle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRID = 0.004  # one point a cube of this edge [m]
ABOVE = 0.006  # what is lower above the table is the table [m]
FEWEST = 15
AROUND = 0.009  # radius in which a normal is estimated [m]
OPENING, FINGER, BREADTH = 0.078, 0.012, 0.010  # of the hand; breadth to each side [m]
LENGTH = 0.050  # of the fingers, from palm to tips [m]
DEPTHS = (0.012, 0.022, 0.032)  # of the tips below the point [m]
TURNS = 12
TILTS = (0.0, 0.3, -0.3)  # of the approach from the vertical, about the closing line's normal [rad]
CLEAR = 0.004  # of the tips above the table [m]
SIDE = 0.006  # what lies so near to a finger is met by it [m]
BEST = 20


def _axes(turn: float, tilt: float) -> Array:
    """Return the closing line, the direction across it and the approach of a turned and tilted hand, as columns."""
    closing, level = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([-np.sin(turn), np.cos(turn), 0.0])
    approach = np.sin(tilt) * level - np.cos(tilt) * np.array([0.0, 0.0, 1.0])
    return np.stack([closing, np.cross(approach, closing), approach], axis=1)


AXES = np.stack([_axes(turn, tilt) for turn in np.arange(TURNS) * np.pi / TURNS for tilt in TILTS])


@dataclass(frozen=True)
class Hand:
    """A place of the hand.

    Attributes:
        bottom: middle of the palm, between the fingers' roots, shape (3,) [m].
        approach: unit vector out of the palm, shape (3,).
        binormal: unit vector along which the fingers close, shape (3,).
    """

    bottom: Array
    approach: Array
    binormal: Array
    width: float
    score: float


def search(points: Array, samples: int = 30, seed: int = 0) -> list[Hand]:
    """Return places of the hand, best first.

    Args:
        points: shape (n, 3) [m], z up.
        samples: how many points are tried.
    """
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < FEWEST:
        return []
    levels = np.rint((points[:, 2] - points[:, 2].min()) / 0.002).astype(np.int64)
    table = float(points[:, 2].min() + 0.002 * np.bincount(levels).argmax())
    thing = _thinned(_largest(points[points[:, 2] > table + ABOVE]))
    if len(thing) < FEWEST:
        return []
    normals = _normals(thing)
    tried = np.random.default_rng(seed).choice(len(thing), min(samples, len(thing)), replace=False)
    hands = [hand for k in tried for hand in _about(thing[k], thing, normals, table)]
    return sorted(hands, key=lambda hand: -hand.score)[:BEST]


def _thinned(points: Array) -> Array:
    cells = np.floor((points - points.min(axis=0)) / GRID).astype(np.int64) if len(points) else np.zeros((0, 3), int)
    _, first = np.unique(cells @ [1, 1_000, 1_000_000], return_index=True)
    return np.asarray(points[np.sort(first)])


def _largest(points: Array) -> Array:
    """Return the largest group of points that touch, seen from above."""
    if not len(points):
        return points
    cells = np.floor((points[:, :2] - points[:, :2].min(axis=0)) / (2 * GRID)).astype(np.int64)
    image = np.zeros(cells.max(axis=0) + 1, np.uint8)
    image[cells[:, 0], cells[:, 1]] = 1
    _, labels = cv2.connectedComponents(image, connectivity=8)
    label = labels[cells[:, 0], cells[:, 1]]
    return np.asarray(points[label == np.bincount(label)[1:].argmax() + 1])


def _normals(points: Array) -> Array:
    """Return the direction of least spread about each point, shape (n, 3), upwards."""
    points = points - points.mean(axis=0)
    square = np.einsum("ij,ij->i", points, points)
    near = square[:, None] + square - 2 * points @ points.T < AROUND**2
    weight = near / near.sum(axis=1, keepdims=True)
    mean = weight @ points
    products = np.einsum("ij,ik->ijk", points, points).reshape(-1, 9)
    spread = (weight @ products).reshape(-1, 3, 3) - np.einsum("ij,ik->ijk", mean, mean)
    normals = np.linalg.eigh(spread)[1][:, :, 0]
    return normals * np.where(normals[:, 2:] < 0, -1.0, 1.0)


def _about(sample: Array, thing: Array, normals: Array, table: float) -> Iterator[Hand]:
    reach = float(np.ptp(thing[:, :2], axis=0).max()) / 2
    centre, away = thing.mean(axis=0), thing - sample
    slabs = np.abs(away @ AXES[:, :, 1].T) < BREADTH
    for axes, tilt, slab in zip(AXES, TILTS * TURNS, slabs.T, strict=True):
        rows = np.flatnonzero(slab)
        local = away[rows] @ axes
        placed = _placed(local, sample, axes, table)
        if placed is None:
            continue
        shift, width, depth = placed
        closing, approach = axes[:, 0], axes[:, 2]
        side = np.abs(np.abs(local[:, 0] - shift) - width / 2) < SIDE
        met = np.abs(normals[rows[side & (local[:, 2] < depth)]] @ closing)
        antipodal = float(np.mean(met > 0.6)) if len(met) else 0.0
        tips = sample + axes @ [shift, 0.0, depth]
        off = float(np.linalg.norm((tips - centre)[:2])) / max(reach, 0.02)
        score = 0.4 * antipodal + 0.3 * depth / DEPTHS[-1] - 0.6 * off - 0.2 * abs(tilt) - 0.3 * width / OPENING
        yield Hand(tips - LENGTH * approach, approach, closing, width, score)


def _placed(local: Array, sample: Array, axes: Array, table: float) -> tuple[float, float, float] | None:
    """Return how far the hand moves sideways, how wide the thing is between the fingers, and how deep they go [m]."""
    across, deep = local[:, 0], local[:, 2]
    for depth in reversed(DEPTHS):
        if sample[2] + axes[2, 2] * depth < table + CLEAR:
            continue
        reached = deep < depth
        near = across[reached & (np.abs(across) < OPENING)]
        if len(near) < 5:
            continue
        low, high = float(near.min()), float(near.max())
        shift, width = (low + high) / 2, high - low + GRID
        if width > OPENING - 2 * GRID or deep.min() < depth - LENGTH:
            continue
        beyond = np.abs(across[reached] - shift)
        if not ((beyond > OPENING / 2) & (beyond < OPENING / 2 + FINGER)).any():
            return shift, width, depth
    return None
