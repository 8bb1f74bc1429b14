"""Grasp rectangles between opposite edges of a depth image seen from above. Plain numpy and OpenCV.

Edges are where a thing ends: where the depth falls off to the table. Two edge pixels whose outward normals point away
from each other are a pair that two fingers can press on (antipodal, Nguyen 1988; on depth images as in Dex-Net 2.0).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LOWEST = 0.010  # what is lower is the table [m]
DEEP = 0.030  # tips below the surface between the edges, at most [m]
ABOVE_TABLE = 0.008
NARROWEST, WIDEST = 4.0, 48.0  # [px]
CONE = np.cos(np.radians(25))  # between a normal and the line to the other edge
FINGER = 9  # how far beyond an edge a finger stands [px]
FREE = 0.006  # a finger's tip is at least so far above what it stands over [m]
EDGES = 500  # edge pixels that are looked at, at most
FEWEST = 40  # pixels of a thing
BEST, APART = 20, 3.0  # how many are returned, and how far their middles are apart at least [px]


@dataclass(frozen=True)
class Rectangle:
    """A grasp in the image.

    Attributes:
        middle: row and column [px].
        angle: of the line between the edges, counterclockwise as one sees the image [rad].
        width: along it [px].
        depth: of the finger tips [m].
    """

    middle: tuple[float, float]
    angle: float
    width: float
    depth: float
    quality: float


def find(depth: NDArray[np.float32]) -> list[Rectangle]:
    """Return rectangles in a depth image, shape (h, w) [m], best first; 0 or what isn't finite is unknown."""
    seen = np.isfinite(depth) & (depth > 0)
    if not seen.any():
        return []
    table = float(np.median(depth[seen]))
    height = cv2.medianBlur(np.where(seen, table - depth, 0.0).astype(np.float32), 5)
    mask = cv2.morphologyEx((height > LOWEST).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, labels, stats, centres = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        return []
    thing = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    if stats[thing, cv2.CC_STAT_AREA] < FEWEST:
        return []
    mask = (labels == thing).astype(np.uint8)
    edges, normals = _edges(mask)
    return _best(_pairs(edges, normals, height, table, centres[thing]))


def _edges(mask: NDArray[np.uint8]) -> tuple[Array, Array]:
    """Return edge pixels as x, y, and their outward normals, both of shape (n, 2)."""
    contours, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    edges = np.concatenate([contour.reshape(-1, 2) for contour in contours]).astype(float)
    edges = edges[:: max(1, len(edges) // EDGES)]
    soft = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 2.0)
    slope = np.stack([cv2.Sobel(soft, cv2.CV_32F, 1, 0), cv2.Sobel(soft, cv2.CV_32F, 0, 1)], axis=-1)
    at = edges.astype(int)
    normals = -slope[at[:, 1], at[:, 0]].astype(float)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    sure = length[:, 0] > 1e-3
    return edges[sure], normals[sure] / length[sure]


def _pairs(edges: Array, normals: Array, height: NDArray[np.float32], table: float, centre: Array) -> list[Rectangle]:
    way = edges[None] - edges[:, None]
    length = np.linalg.norm(way, axis=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        way /= length[..., None]
    facing = np.minimum(-np.einsum("ijk,ik->ij", way, normals), np.einsum("ijk,jk->ij", way, normals))
    ones, others = np.nonzero((facing > CONE) & (length > NARROWEST) & (length < WIDEST))
    first = ones < others
    ones, others = ones[first], others[first]
    middles = (edges[ones] + edges[others]) / 2
    reach = 40.0
    far = np.linalg.norm(middles - centre, axis=1) / reach
    quality = facing[ones, others] - far - 0.3 * length[ones, others] / WIDEST
    found = []
    for k in np.argsort(-quality)[:400]:
        one, other = edges[ones[k]], edges[others[k]]
        along = (other - one) / np.linalg.norm(other - one)
        inside = [one + part * (other - one) for part in (0.3, 0.5, 0.7)]
        surface = float(np.median([_at(height, spot) for spot in inside]))
        tips = max(surface - DEEP, ABOVE_TABLE)
        outside = max(_at(height, spot) for spot in (one - FINGER * along, other + FINGER * along))
        if surface < LOWEST or outside > tips - FREE:
            continue
        angle = float(np.arctan2(-along[1], along[0]))
        spot = (float(middles[k, 1]), float(middles[k, 0]))
        found.append(Rectangle(spot, angle, float(length[ones[k], others[k]]), table - tips, float(quality[k])))
    return found


def _at(height: NDArray[np.float32], spot: Array) -> float:
    column, row = np.clip(np.rint(spot).astype(int), 0, np.array(height.shape[::-1]) - 1)
    return float(height[row, column])


def _best(found: list[Rectangle]) -> list[Rectangle]:
    """Leave out those beside a better one that is turned alike."""
    kept: list[Rectangle] = []
    for one in found:
        alike = any(
            np.hypot(one.middle[0] - other.middle[0], one.middle[1] - other.middle[1]) < APART
            and abs(np.sin(one.angle - other.angle)) < 0.25
            for other in kept
        )
        if not alike:
            kept.append(one)
        if len(kept) == BEST:
            break
    return kept
