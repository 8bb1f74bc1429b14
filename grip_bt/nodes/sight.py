"""What the robot hides of a camera's view: its hulls, known from joints and description, as pixels.

A pixel shows the robot when it lies within the outline of one of its hulls and what was measured there is as far away
as that hull is: behind a hull that is larger than the robot the camera still sees the table. Nothing but the robot's
description, its joints and the camera's pose is needed, so it is the same in simulation and on a real robot.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from grip_bt.base.values import CameraInfo, DepthImage

Hulls = Sequence[NDArray[np.float64]]
Mask = NDArray[np.bool_]
MARGIN = 0.02
"""A point may be measured so far in front of a hull, or behind it, and is the robot's all the same [m]."""
NEAREST = 0.02
"""What is nearer to the camera's plane than this has no outline in the image [m]."""


def outline(info: CameraInfo, hulls: Hulls) -> Mask:
    """Return the pixels that hulls may cover, shape (height, width); all of them where one reaches the camera.

    Args:
        info: the camera.
        hulls: points, each of shape (k, 3) in the frame of the camera's pose [m].
    """
    mask = np.zeros((info.height, info.width), np.uint8)
    for hull in hulls:
        _draw(mask, info, hull)
    return mask > 0


def robot_pixels(depth: DepthImage, hulls: Hulls, margin: float = MARGIN) -> Mask:
    """Return the pixels of a depth image that show the robot, shape (height, width).

    Where nothing was measured within a hull's outline, the pixel counts as the robot's.
    """
    info, seen = depth.info, depth.depth
    robot = np.zeros(seen.shape, dtype=bool)
    for hull in hulls:
        mask = np.zeros(seen.shape, np.uint8)
        away = _draw(mask, info, hull)
        robot |= (mask > 0) & ((seen <= 0) | ((seen > away.min() - margin) & (seen < away.max() + margin)))
    return robot


def within(info: CameraInfo, region: Sequence[float], height: float) -> Mask:
    """Return the pixels that look at a rectangle at a height in world; all of them for an empty region.

    Args:
        info: the camera.
        region: x from, x to, y from, y to in world [m], or nothing.
        height: of the rectangle [m].
    """
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
    if away.max() <= NEAREST:
        return away  # behind the camera
    if away.min() <= NEAREST:
        mask[:] = 1  # around the camera: its projection has no bounds
        return away
    corners = cv2.convexHull(info.project(hull).astype(np.float32)).reshape(-1, 2)
    corners = np.clip(corners, -1e5, 1e5)
    cv2.fillConvexPoly(mask, np.round(corners - 0.5).astype(np.int32), 1)
    return away
