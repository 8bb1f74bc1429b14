"""What changed on a table between two RGB-D frames of one camera."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from grip_bt.base.values import RgbdFrame

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
    """Classify what changed.

    A pixel has changed when a colour channel differs by more than the threshold (`cv2.absdiff`) or its height does;
    the mask is opened with a 3 x 3 square, so that noise and the fringes of edges drop out. By depth, a changed pixel
    is *vacated* when it showed something above the table and shows the table now, and *appeared* when it is the other
    way round.

    Args:
        before: the first frame.
        after: the second frame, of the same camera.
        place: where the object stood, shape (2,) or (3,) in world [m]; None looks at everything above the table.
        limits: thresholds.
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
    before: RgbdFrame,
    after: RgbdFrame,
    z_before: NDArray[np.float64],
    z_after: NDArray[np.float64],
    limits: Thresholds,
) -> Mask:
    color = cv2.absdiff(before.image.pixels, after.image.pixels).max(axis=2) > limits.color
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
    opened: Mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
    return opened
