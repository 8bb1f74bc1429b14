"""Two views of one camera compared, and what the robot hides of a view; geometry only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grip_bt.base.values import CameraInfo, DepthImage, RgbdFrame

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Thresholds:
    """What counts as a change.

    Attributes:
        color: smallest difference of a colour channel, 0..255.
        height: smallest height above the table, and smallest change of it [m].
        table: height of the table's top in world [m].
        max_height: what is higher above the table is ignored [m].
        radius: what stood within this horizontal distance of the place belongs to the object [m].
    """

    color: int = 25
    height: float = 0.015
    table: float = 0.0
    max_height: float = 0.4
    radius: float = 0.08


@dataclass(frozen=True, slots=True)
class Change:
    """What became of an object's place.

    Attributes:
        object_pixels: pixels that showed the object before.
        vacated: fraction of them that show the table now.
        appeared: pixels that showed the table before and something above it now, as a fraction of `object_pixels`.
    """

    object_pixels: int
    vacated: float
    appeared: float


def compare(before: RgbdFrame, after: RgbdFrame, place: ArrayLike | None, limits: Thresholds) -> Change:
    """Classify what changed between two frames of one camera around a place in world [m]; around everything for None.

    A pixel has changed when a colour channel differs by more than the threshold or its height does;
    the mask is opened with a 3 x 3 square, so that noise and the fringes of edges drop out. By depth, a changed pixel
    is *vacated* when it showed something above the table and shows the table now, and *appeared* when it is the other
    way round.
    """
    points = before.depth.points()
    z_before = points[..., 2] - limits.table
    z_after = after.depth.points()[..., 2] - limits.table
    changed = _changed(before, after, z_before, z_after, limits)
    tall_before, flat_before = _classify(z_before, limits)
    tall_after, flat_after = _classify(z_after, limits)
    subject = tall_before
    if place is not None:
        away = np.linalg.norm(points[..., :2] - np.asarray(place, dtype=float)[:2], axis=-1)
        subject = tall_before & (away <= limits.radius)
    count = int(subject.sum())
    vacated = int((subject & changed & flat_after).sum())
    appeared = int(_opened(changed & flat_before & tall_after).sum())
    return Change(count, vacated / max(count, 1), appeared / max(count, 1))


def _changed(
    before: RgbdFrame, after: RgbdFrame, z_before: NDArray[np.float64], z_after: NDArray[np.float64], limits: Thresholds
) -> Mask:
    one, other = before.image.pixels, after.image.pixels
    color = (np.maximum(one, other) - np.minimum(one, other)).max(axis=2) > limits.color
    with np.errstate(invalid="ignore"):  # NaN where a pixel has no depth: no evidence of a change
        height = np.abs(z_after - z_before) > limits.height
    return _opened(color | height)


def _classify(z: NDArray[np.float64], limits: Thresholds) -> tuple[Mask, Mask]:
    """Return which pixels show something above the table, and which the table."""
    with np.errstate(invalid="ignore"):
        tall = (z > limits.height) & (z < limits.max_height)
        flat = np.abs(z) <= limits.height
    return tall, flat


def _opened(mask: Mask) -> Mask:
    for combine, beyond in ((np.logical_and, True), (np.logical_or, False)):
        for _ in "xy":
            rows = np.pad(mask, ((1, 1), (0, 0)), constant_values=beyond)
            mask = combine(combine(rows[:-2], rows[1:-1]), rows[2:]).T
    return mask


Hulls = Sequence[NDArray[np.float64]]
MARGIN = 0.02
"""A point measured this far in front of a hull, or behind it, still counts as the robot's [m]."""
_NEAREST = 0.02
"""What is nearer to the camera's plane than this has no outline in the image [m]."""


def outline(info: CameraInfo, hulls: Hulls) -> Mask:
    """Return the pixels that hulls may cover; all of them where one reaches the camera.

    Their points are given in the frame of the camera's pose [m].
    """
    mask = np.zeros((info.height, info.width), np.uint8)
    for hull in hulls:
        _draw(mask, info, hull)
    return mask > 0


def robot_pixels(depth: DepthImage, hulls: Hulls, margin: float = MARGIN) -> Mask:
    """Return the pixels of a depth image that show the robot, or, unmeasured, lie within its outline."""
    info, seen = depth.info, depth.depth
    robot = np.zeros(seen.shape, dtype=bool)
    for hull in hulls:
        mask = np.zeros(seen.shape, np.uint8)
        away = _draw(mask, info, hull)
        robot |= (mask > 0) & ((seen <= 0) | ((seen > away.min() - margin) & (seen < away.max() + margin)))
    return robot


def within(info: CameraInfo, region: Sequence[float], height: float) -> Mask:
    """Return the pixels that look at x from, x to, y from, y to at a height in world [m]; all for an empty region."""
    if not region:
        return np.ones((info.height, info.width), dtype=bool)
    x0, x1, y0, y1 = region
    return outline(info, [np.array([[x, y, height] for x in (x0, x1) for y in (y0, y1)])])


def share(mask: Mask, of: Mask) -> float:
    """Return which part of the pixels `of` are in a mask, 0..1; 0 where there are none."""
    return float((mask & of).sum() / max(int(of.sum()), 1))


def _draw(mask: NDArray[np.uint8], info: CameraInfo, hull: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fill a hull's outline; return how far its points are along the optical axis [m]."""
    local = (hull - info.pose.position) @ info.pose.rotation()
    away: NDArray[np.float64] = local[:, 2]
    if away.max() <= _NEAREST:
        return away  # behind the camera
    if away.min() <= _NEAREST:
        mask[:] = 1  # around the camera: its projection has no bounds
        return away
    import cv2  # of the extra `vision`, which who masks nothing does without

    corners = cv2.convexHull(info.project(hull).astype(np.float32)).reshape(-1, 2)
    corners = np.clip(corners, -1e5, 1e5)
    cv2.fillConvexPoly(mask, np.round(corners - 0.5).astype(np.int32), 1)
    return away
