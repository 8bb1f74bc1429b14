"""Tell what has left its place, what has appeared, and whether it is in the hand. Plain numpy and OpenCV."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

DEPTH = 0.012  # a surface that is nearer or farther by more than this is another one [m]
COLOUR = 40  # of 255, in the channel that changed most
HUE = 0.08  # two colours are alike when their shares of red, green and blue differ by less than this
SMALLEST = 12  # patches of fewer pixels than this are noise
_OPEN = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class Difference:
    """On how many pixels something is gone, on how many something has come, and of which colour the first was."""

    vacated: int
    appeared: int
    colour: NDArray[np.float64] | None = None
    """Shares of red, green and blue, shape (3,); None where nothing was vacated."""


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
    changed = _changed(colour_before, colour_after)
    vacated, gone = _patches(changed & (farther > DEPTH))
    colour = np.median(_shares(colour_before[gone]), axis=0) if vacated else None
    return Difference(vacated, _patches(changed & (farther < -DEPTH))[0], colour)


def shown(colour: NDArray[np.float64] | None, before: NDArray[np.uint8], after: NDArray[np.uint8]) -> int:
    """Return on how many pixels of a picture of the hand something of a colour has appeared since the one before.

    Fingers that have closed change the picture too, in colours of their own. A thing as grey as they are isn't told
    from them.
    """
    if colour is None:
        return 0
    alike = np.abs(_shares(after) - colour).max(axis=2) < HUE
    return _patches(_changed(before, after) & alike)[0]


def _changed(before: NDArray[np.uint8], after: NDArray[np.uint8]) -> NDArray[np.bool_]:
    different: NDArray[np.bool_] = cv2.absdiff(before, after).max(axis=2) > COLOUR
    return different


def _shares(pixels: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return each colour's shares of its brightness, which a shadow doesn't change."""
    bright = pixels.astype(np.float64) + 1.0
    shares: NDArray[np.float64] = bright / bright.sum(axis=-1, keepdims=True)
    return shares


def _patches(mask: NDArray[np.bool_]) -> tuple[int, NDArray[np.bool_]]:
    """Return how many pixels lie in patches that are no noise, and which."""
    cleaned = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, _OPEN)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(cleaned, connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] >= SMALLEST
    large[0] = False
    return int(stats[large, cv2.CC_STAT_AREA].sum()), large[labels]
