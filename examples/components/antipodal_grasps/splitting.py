"""Take apart clusters of points that touch each other but are several things. Plain numpy and OpenCV.

Four clues, in this order: what rises high has a top of its own, so low points beside it belong to something else; what
stands and has two flat tops, side by side, is two things; a top with a waist is that of two equally high things; and an
outline that, seen from above, goes in somewhere is that of two things that touch there. Things of one height that touch
along a whole face stay together. Lengths in m.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PIXEL = 0.004
"""Edge of a pixel of the outline."""
BESIDE = 0.014
"""Low points further than this outside the tops of what stands aren't its sides."""
LEVEL = 0.012
"""Points of one flat top are at most so far below its highest."""
FLAT = 0.5
"""This part of what is seen of a thing beside a higher one, from above, is its top."""
EDGE = 0.006
"""Sides are seen at most so far outside the top, since they are upright."""
NOTCH = 0.008
"""An outline goes in between two things by more than this."""
SOLID = 0.93
"""What fills this part of its convex hull is one thing."""
GAIN = 0.05
"""A cut is made where the parts fill their hulls better than the whole does, by this much."""
CUTS = 24
"""So many directions of a cut are tried."""
FINE = 0.002
"""Edge of a pixel of a top's outline, about as far apart as the points of a camera above."""
CLOSED = 5
"""Gaps of so many fine pixels are closed."""
WAIST = 0.0065
"""A top goes in by more than this on both sides of a waist; noise of 1.5 mm makes notches of 5 mm."""
AROUND = 0.15
"""The other side of a waist is at least this part of the outline away, along it."""
HALF = 0.2
"""Each side of a waist has at least this part of the top; what has less is a handle or a spout."""


def parts(points: Array, high: float, fewest: int) -> list[Array]:
    """Return the points of each thing in a cluster; the cluster itself where it is one thing.

    Args:
        points: of the cluster, shape (n, 3).
        high: what stands rises above this height.
        fewest: a part of fewer points is noise, and then nothing is taken apart.
    """
    found: list[Array] = []
    for group in by_height(points, high, fewest):
        for piece in by_waist(group, high, fewest):
            found += by_outline(piece, fewest)
    return found


def by_height(points: Array, high: float, fewest: int) -> list[Array]:
    """Take apart what stands and what lies beside it.

    The points of each top, seen from above, are one standing thing with all that is seen within `BESIDE` of it; what is
    left over lies.
    """
    tops = [group for group in connected(points[points[:, 2] > high]) if len(group) >= fewest // 2]
    if not tops:
        return [points]
    away = np.stack([_outside(points[:, :2], top[:, :2]) for top in tops])
    nearest, owned = away.argmin(axis=0), away.min(axis=0) <= BESIDE
    standing = [part for k in range(len(tops)) for part in by_top(points[owned & (nearest == k)], high, fewest)]
    lying = [group for group in connected(points[~owned]) if len(group) >= fewest]
    return [*standing, *lying]


def by_top(points: Array, high: float, fewest: int) -> list[Array]:
    """Take apart what stands side by side and isn't equally high: each flat top is a thing, with all below it.

    What is seen beside the highest top is another thing where most of it is flat and stands too; else the points stay
    together, such as those of a ball.
    """
    level = np.percentile(points[:, 2], 99) - LEVEL
    highest = points[points[:, 2] > level]
    if len(highest) < fewest // 2:
        return [points]
    beside = _outside(points[:, :2], highest[:, :2]) > EDGE
    others = [g for g in connected(points[beside]) if len(g) >= fewest and np.percentile(g[:, 2], 99) > high]
    flat = [g for g in others if np.mean(g[:, 2] > np.percentile(g[:, 2], 99) - LEVEL) > FLAT]
    if not flat or len(flat) != len(others):
        return [points]
    nearest = np.stack([_outside(points[:, :2], g[:, :2]) for g in flat]).argmin(axis=0)
    rest = [points[beside & (nearest == k)] for k in range(len(flat))]
    return [points[~beside], *(part for group in rest for part in by_top(group, high, fewest))]


def by_waist(points: Array, high: float, fewest: int, most: int = 3) -> list[Array]:
    """Take apart what stands where its top has a waist, by the straight cut from its deepest notch to the other side.

    Only the top is looked at: what the camera sees of the sides fills notches that are behind them.

    Args:
        points: of the cluster, shape (n, 3).
        high: what stands rises above this height.
        fewest: no part has fewer points.
        most: so many cuts, one after the other, at most.
    """
    level = np.percentile(points[:, 2], 99)
    top = points[points[:, 2] > level - LEVEL]
    waist = _waist(top[:, :2]) if most and level > high and len(top) >= fewest else None
    if waist is None:
        return [points]
    one, other = waist
    across = np.array([one[1] - other[1], other[0] - one[0]])
    share = float(np.mean((top[:, :2] - one) @ across > 0))
    side = (points[:, :2] - one) @ across > 0
    if min(share, 1 - share) < HALF or min(side.sum(), (~side).sum()) < fewest:
        return [points]
    return [part for half in (side, ~side) for part in by_waist(points[half], high, fewest, most - 1)]


def _waist(flat: Array) -> tuple[Array, Array] | None:
    """Return the deepest of two notches of points seen from above, and what is nearest opposite; shape (2,) each."""
    corner = flat.min(axis=0) - CLOSED * FINE
    pixels = np.floor((flat - corner) / FINE).astype(np.int64)
    mask = np.zeros(pixels.max(axis=0) + CLOSED + 1, np.uint8)
    mask[pixels[:, 0], pixels[:, 1]] = 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (CLOSED, CLOSED))
    contours, _ = cv2.findContours(
        cv2.morphologyEx(mask, cv2.MORPH_CLOSE, disc), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    contour = max(contours, key=cv2.contourArea)
    try:
        defects = cv2.convexityDefects(contour, cv2.convexHull(contour, returnPoints=False))
    except cv2.error:
        return None  # an outline that touches itself, of a few scattered points
    if defects is None:
        return None
    deep = sorted((d for d in defects.reshape(-1, 4) if d[3] / 256 * FINE > WAIST), key=lambda d: -d[3])
    if len(deep) < 2:
        return None
    line = corner + (contour.reshape(-1, 2)[:, ::-1] + 0.5) * FINE
    along = np.abs(np.arange(len(line)) - deep[0][2])
    opposite = np.minimum(along, len(line) - along) > AROUND * len(line)
    away = np.where(opposite, np.linalg.norm(line - line[deep[0][2]], axis=1), np.inf)
    return line[deep[0][2]], line[away.argmin()]


def by_outline(points: Array, fewest: int, most: int = 3) -> list[Array]:
    """Take apart an outline with notches by the straight cut through a notch that makes both parts most convex.

    Args:
        points: of the cluster, shape (n, 3).
        fewest: no part has fewer points.
        most: so many cuts, one after the other, at most.
    """
    mask, pixels = _mask(points[:, :2])
    whole, best, chosen = _solidity(pixels, mask), 0.0, None
    if most == 0 or whole >= SOLID:
        return [points]
    for notch in _notches(mask):
        for turn in np.linspace(0.0, np.pi, CUTS, endpoint=False):
            side = (pixels - notch) @ np.array([np.cos(turn), np.sin(turn)]) > 0
            if min(side.sum(), (~side).sum()) < fewest:
                continue
            parts = (pixels[side], pixels[~side])
            solid = float(np.average([_solidity(part) for part in parts], weights=[len(part) for part in parts]))
            if solid > best:
                best, chosen = solid, side
    if chosen is None or best < whole + GAIN:
        return [points]
    return [part for side in (chosen, ~chosen) for part in by_outline(points[side], fewest, most - 1)]


def _solidity(pixels: NDArray[np.int64], mask: NDArray[np.uint8] | None = None) -> float:
    """Return how much of the convex hull of pixels is filled."""
    if mask is None:
        mask, pixels = _image(pixels)
    hull = cv2.convexHull(np.argwhere(mask).astype(np.int32))
    return float(mask.sum()) / float(cv2.fillConvexPoly(np.zeros_like(mask), hull.reshape(-1, 2)[:, ::-1], 1).sum())


def _notches(mask: NDArray[np.uint8]) -> list[Array]:
    """Return where an outline goes in deepest, as rows and columns, the deepest first."""
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    contour = max(contours, key=len)
    defects = cv2.convexityDefects(contour, cv2.convexHull(contour, returnPoints=False))
    if defects is None:
        return []
    deep = sorted((d for d in defects.reshape(-1, 4) if d[3] / 256 * PIXEL > NOTCH), key=lambda d: -d[3])
    return [contour.reshape(-1, 2)[d[2], ::-1].astype(float) for d in deep[:4]]


def connected(points: Array) -> list[Array]:
    """Return groups of points that touch, seen from above."""
    if not len(points):
        return []
    mask, pixels = _mask(points[:, :2])
    count, labels = cv2.connectedComponents(mask, connectivity=8)
    label = labels[pixels[:, 0], pixels[:, 1]]
    return [points[label == k] for k in range(1, count)]


def _mask(flat: Array) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Return an image of points seen from above, gaps between them closed, and each one's pixel in it."""
    return _image(np.floor(flat / PIXEL).astype(np.int64))


def _image(pixels: NDArray[np.int64]) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    pixels = pixels - pixels.min(axis=0) + 2
    mask = np.zeros(pixels.max(axis=0) + 3, np.uint8)
    mask[pixels[:, 0], pixels[:, 1]] = 1
    return cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)), pixels


def _outside(flat: Array, top: Array) -> Array:
    """Return how far points, shape (n, 2), are outside the convex hull of others; shape (n,)."""
    hull = cv2.convexHull(top.astype(np.float32))
    return np.array([max(0.0, -cv2.pointPolygonTest(hull, (float(x), float(y)), True)) for x, y in flat])
