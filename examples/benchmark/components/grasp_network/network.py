"""A generative grasp network in the manner of GG-CNN (Morrison et al. 2018), run by plain numpy.

A small fully convolutional network sees how high things rise above the table, in a square of the depth image, and says
for each second pixel how well a grasp there would do, the angle of the line along which the fingers close (by the sine
and cosine of its double), and how wide they open. `training/` has made its weights.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

Maps = NDArray[np.float32]

WEIGHTS = Path(__file__).with_name("weights.npz")
SIDE = 128  # of the square that is looked at [px]
LOWEST = 0.008  # what is lower is the table [m]
HEIGHTS = 10.0  # the network's unit of height is 1 / HEIGHTS [m]
WIDTHS = 0.1  # its unit of width [m]
LAYERS = (("first", 2, 1), ("second", 1, 1), ("third", 2, 1), ("fourth", 1, 2), ("fifth", 1, 4))
"""Name, stride, dilation; `sixth` and `head` follow after the maps of `second` were joined again."""
DEEP, ABOVE_TABLE = 0.030, 0.008  # tips below the surface, at most, and above the table, at least [m]
LEAST, APART = 0.15, 4  # quality of a peak, and how far peaks are apart [cells]


@dataclass(frozen=True)
class Peak:
    """A grasp at a peak of the quality.

    Attributes:
        middle: row and column in the image [px].
        angle: of the line along which the fingers close, from the image's right towards its lower edge [rad].
        width: [m].
        depth: of the finger tips [m].
    """

    middle: tuple[float, float]
    angle: float
    width: float
    depth: float
    quality: float


def heights(depth: NDArray[np.float32]) -> tuple[Maps, float]:
    """Return how high things rise above the table, the shape of the depth image [m], and the table's depth [m]."""
    seen = np.isfinite(depth) & (depth > 0)
    table = float(np.median(depth[seen])) if seen.any() else 0.0
    return cv2.medianBlur(np.where(seen, table - depth, 0.0).astype(np.float32), 5), table


def square(height: Maps) -> tuple[int, int] | None:
    """Return the upper left corner, row and column, of the square around the largest thing; None where nothing is."""
    mask = cv2.morphologyEx((height > LOWEST).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    count, _, stats, centres = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        return None
    column, row = centres[1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())]
    corner = np.clip(np.rint([row - SIDE / 2, column - SIDE / 2]), 0, np.array(height.shape) - SIDE)
    return int(corner[0]), int(corner[1])


def convolved(maps: Maps, kernel: Maps, bias: Maps, stride: int = 1, dilation: int = 1) -> Maps:
    """Convolve maps, shape (h, w, in), with a kernel, shape (k, k, in, out), and zeros around the maps."""
    size = kernel.shape[0]
    pad = dilation * (size // 2)
    padded = np.pad(maps, ((pad, pad), (pad, pad), (0, 0)))
    rows, columns = (-(-n // stride) for n in maps.shape[:2])
    out = np.zeros((rows * columns, kernel.shape[3]), np.float32)
    for i in range(size):
        for j in range(size):
            y, x = i * dilation, j * dilation
            part = padded[y : y + stride * (rows - 1) + 1 : stride, x : x + stride * (columns - 1) + 1 : stride]
            out += part.reshape(rows * columns, -1) @ kernel[i, j]
    return (out + bias).reshape(rows, columns, -1)


def forward(weights: Mapping[str, Maps], maps: Maps) -> Maps:
    """Return the maps quality, cosine and sine of the double angle, and width; shape (SIDE / 2, SIDE / 2, 4).

    Args:
        maps: heights in the network's unit, shape (SIDE, SIDE).
    """
    value, kept = maps[..., None], None
    for name, stride, dilation in LAYERS:
        value = np.maximum(convolved(value, weights[name], weights[name + "_bias"], stride, dilation), 0)
        kept = value if name == "second" else kept
    joined = np.concatenate([value.repeat(2, axis=0).repeat(2, axis=1), kept], axis=2)
    value = np.maximum(convolved(joined, weights["sixth"], weights["sixth_bias"]), 0)
    out = convolved(value, weights["head"], weights["head_bias"])
    out[..., 0] = 1 / (1 + np.exp(-out[..., 0]))
    return out


def predict(weights: Mapping[str, Maps], depth: NDArray[np.float32], most: int = 10) -> list[Peak]:
    """Return the peaks in a depth image, shape (h, w) [m], best first."""
    height, table = heights(depth)
    corner = square(height)
    if corner is None:
        return []
    row, column = corner
    seen = height[row : row + SIDE, column : column + SIDE]
    out = forward(weights, HEIGHTS * np.clip(seen, 0, 0.3))
    out[..., 0] = cv2.GaussianBlur(np.ascontiguousarray(out[..., 0]), (0, 0), 1.0)
    quality = np.where(seen[::2, ::2] > LOWEST, out[..., 0], 0.0)
    found = []
    for _ in range(most):
        i, j = np.unravel_index(int(quality.argmax()), quality.shape)
        best = float(quality[i, j])
        if best < LEAST:
            break
        _, cosine, sine, width = (float(v) for v in out[i, j])
        tips = max(float(seen[2 * i, 2 * j]) - DEEP, ABOVE_TABLE)
        spot = (float(row + 2 * i), float(column + 2 * j))
        found.append(Peak(spot, float(np.arctan2(sine, cosine) / 2), max(0.0, width) * WIDTHS, table - tips, best))
        quality[max(0, i - APART) : i + APART + 1, max(0, j - APART) : j + APART + 1] = 0.0
    return found


def load(file: Path = WEIGHTS) -> dict[str, Maps]:
    """Return the weights by name."""
    with np.load(file, allow_pickle=False) as stored:
        return {name: stored[name].astype(np.float32) for name in stored.files}
