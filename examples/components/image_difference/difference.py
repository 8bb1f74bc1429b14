"""Tell apart what has left its place and what has appeared, from two frames of one camera. Plain numpy and OpenCV."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

DEPTH = 0.012  # a surface that is nearer or farther by more than this is another one [m]
COLOUR = 40  # of 255, in the channel that changed most
SMALLEST = 12  # patches of fewer pixels than this are noise
_OPEN = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class Difference:
    """How many pixels were vacated, and on how many something has appeared."""

    vacated: int
    appeared: int


def compare(
    colour_before: NDArray[np.uint8],
    depth_before: NDArray[np.float32],
    colour_after: NDArray[np.uint8],
    depth_after: NDArray[np.float32],
) -> Difference:
    """Compare two frames of shape (h, w, 3) and (h, w) [m]; depth that isn't finite and positive is unknown.

    A pixel counts when both pictures changed there, colour and depth: a shadow changes colour alone, and noise of the
    depth at an edge changes depth alone. What is farther than before was vacated, what is nearer has appeared.
    """
    known = (depth_before > 0) & (depth_after > 0) & np.isfinite(depth_before) & np.isfinite(depth_after)
    farther = np.where(known, depth_after - depth_before, 0.0)
    changed = cv2.absdiff(colour_before, colour_after).max(axis=2) > COLOUR
    return Difference(_pixels(changed & (farther > DEPTH)), _pixels(changed & (farther < -DEPTH)))


def _pixels(mask: NDArray[np.bool_]) -> int:
    """Return how many pixels lie in patches that are no noise."""
    cleaned = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, _OPEN)
    _, _, stats, _ = cv2.connectedComponentsWithStats(cleaned, connectivity=8)
    areas = stats[1:, cv2.CC_STAT_AREA]
    return int(areas[areas >= SMALLEST].sum())
