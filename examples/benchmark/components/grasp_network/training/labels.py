"""What the network learns: for each pixel of a clean view from above, the best way for two fingers to close there.

The labels know what a camera doesn't: depth without noise, and where the thing's centre of mass is. At a pixel and an
angle, the tips go `DEEP` below the surface; a grasp counts where what rises above the tips is narrower than the hand
opens, its outline faces the fingers on both sides, and nothing stands where they come down. Its quality falls off with
the distance from the centre of mass, by which heavy things turn in the hand.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

ANGLES = 12
DEEP, ABOVE_TABLE = 0.030, 0.008  # tips below the surface, at most, and above the table, at least [m]
LEVEL = 0.006  # heights of tips are told apart so finely [m]
WIDEST, BREADTH, FINGER = 0.074, 0.008, 0.016  # of things; of a finger to each side; room for it and its motion [m]
EVEN = 0.8  # of the width in a finger's middle, that at its edges at least: fingers slide off corners
CONE = 0.9  # cosine between the outline's normal and the closing line
NEAR = 0.04  # distance from the centre of mass by which quality has fallen to 1/e [m]
OFF = 0.005  # of the pixel from the middle between the fingers, at most [m]


def labels(height: NDArray[np.float32], pixel: float, centre: tuple[float, float]) -> NDArray[np.float32]:
    """Return the maps quality, cosine and sine of the double angle, width [m]; shape (side, side, 4).

    Args:
        height: above the table, shape (side, side) [m].
        pixel: its edge at the height of the table [m].
        centre: row and column of the centre of mass [px].
    """
    side = len(height)
    middle, best = ((side - 1) / 2, (side - 1) / 2), np.zeros((side, side, 4), np.float32)
    for k in range(ANGLES):
        angle = np.pi * k / ANGLES
        turn = cv2.getRotationMatrix2D(middle, np.degrees(angle), 1.0)  # the line at `angle` becomes level
        level = cv2.warpAffine(height, turn, (side, side), flags=cv2.INTER_LINEAR)
        column, row = turn @ [centre[1], centre[0], 1.0]
        quality, width = _level(level, pixel, (row, column))
        back = cv2.invertAffineTransform(turn)
        quality, width = (cv2.warpAffine(m, back, (side, side), flags=cv2.INTER_NEAREST) for m in (quality, width))
        better = quality > best[..., 0]
        best[better] = np.stack([quality, *(np.full_like(quality, v) for v in _double(angle)), width], -1)[better]
    return best


def _double(angle: float) -> tuple[float, float]:
    return float(np.cos(2 * angle)), float(np.sin(2 * angle))


def _level(height: NDArray[np.float32], pixel: float, centre: tuple[float, float]) -> tuple[NDArray[np.float32], ...]:
    """Return quality and width [m] of fingers that close along the image's rows."""
    side = len(height)
    quality, width = np.zeros_like(height), np.zeros_like(height)
    tips = np.maximum(height - DEEP, ABOVE_TABLE)
    wanted = np.where(height > 0.010, np.ceil(tips / LEVEL).astype(int), -1)
    rows = np.arange(side)
    breadth = np.ones((2 * round(BREADTH / pixel) + 1, 1), np.uint8)
    for level in np.unique(wanted[wanted >= 0]):
        mask = (height > level * LEVEL).astype(np.uint8)
        met = cv2.dilate(mask, breadth).astype(bool)
        free = ~met
        columns = np.broadcast_to(rows, met.shape)
        left = np.maximum.accumulate(np.where(free, columns, -1), axis=1)
        right = np.minimum.accumulate(np.where(free, columns, side)[:, ::-1], axis=1)[:, ::-1]
        at = np.argwhere((wanted == level) & met)
        i, j = at[:, 0], at[:, 1]
        begin, end = left[i, j], right[i, j]
        inside = (begin >= 0) & (end < side)
        i, j, begin, end = i[inside], j[inside], begin[inside], end[inside]
        wide = (end - begin - 1) * pixel
        soft = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 2.0)
        across, along = cv2.Sobel(soft, cv2.CV_32F, 1, 0), cv2.Sobel(soft, cv2.CV_32F, 0, 1)
        facing = across / np.maximum(np.hypot(across, along), 1e-6)
        room = np.cumsum(np.pad(met, ((0, 0), (1, 0))), axis=1)
        need = round(FINGER / pixel)
        lower, upper = np.maximum(begin - need, 0), np.minimum(end + need, side - 1)
        blocked = (room[i, begin + 1] - room[i, lower]) + (room[i, upper + 1] - room[i, end])
        beside = [np.clip(i + k * (len(breadth) // 2), 0, side - 1) for k in (-1, 0, 1)]
        ends = np.cumsum(np.pad(mask, ((0, 0), (1, 0))), axis=1, dtype=np.int32)
        spans = np.stack([ends[row, end] - ends[row, begin + 1] for row in beside])
        sound = (wide < WIDEST) & (wide > 2 * pixel) & (blocked == 0) & (spans.min(axis=0) > EVEN * spans.max(axis=0))
        sound &= (facing[i, begin + 1] > CONE) & (facing[i, end - 1] < -CONE)
        sound &= np.abs((begin + end) / 2 - j) * pixel < OFF
        far = np.hypot(i - centre[0], (begin + end) / 2 - centre[1]) * pixel
        quality[i[sound], j[sound]] = np.exp(-((far[sound] / NEAR) ** 2))
        width[i[sound], j[sound]] = wide[sound]
    return quality, width
