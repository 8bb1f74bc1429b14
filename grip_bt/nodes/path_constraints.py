"""What a motion keeps to on its way, as tasks say it: the parameter `keep`, or a bound `PathConstraint`.

keep: {orientation: now, tolerance: [0.1, 0.1, free]}
keep: {box: {position: [0.5, 0, 0.4], size: [0.4, 0.8, 0.3]}}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from grip_bt.base.errors import listing, nearest
from grip_bt.base.types import Value
from grip_bt.base.values import PathConstraint, Pose

from .leaf import Leaf

NOW = "now"
"""The orientation that the hand has when the motion begins."""
FREE = "free"
"""A tolerance that any turn is within."""
_KEYS = ("orientation", "tolerance", "axes", "box")
_BOX = ("position", "quaternion", "size")


def verify_keep(leaf: Leaf, keep: Mapping[str, object]) -> None:
    """Verify before the run what a leaf's motion has to keep to.

    Raises:
        ValueError: it is said twice, or wrongly.
    """
    if not keep:
        return
    if "constraint" in leaf.readers:
        raise ValueError(f"{leaf.path}: give either `with: {{keep: ...}}` or `in: {{constraint: ...}}`")
    if keep.get("orientation") == NOW and "start" in leaf.readers:
        raise ValueError(f"{leaf.path}: keep: `{NOW}` is how the hand is; this plan begins at a given `start`")
    try:
        read_keep(keep, Pose())
    except ValueError as error:
        raise ValueError(f"{leaf.path}: keep: {error}") from error


def read_keep(keep: Mapping[str, object], here: Pose) -> PathConstraint:
    """Read the parameter `keep`.

    Args:
        keep: `orientation` (`now`, or w x y z), `tolerance` (3 angles [rad], or `free`), `axes`, `box`.
        here: the pose that `now` means.

    Raises:
        ValueError: a key or a value isn't one of these, or there is nothing to keep to.
    """
    _known(keep, _KEYS, "keep")
    if "orientation" not in keep and "box" not in keep:
        raise ValueError("it holds an `orientation`, a `box` or both")
    if "orientation" not in keep and ("tolerance" in keep or "axes" in keep):
        raise ValueError("`tolerance` and `axes` belong to an `orientation`: `now`, or the numbers w, x, y, z")
    fields: dict[str, Value] = {}
    if "orientation" in keep:
        fields["orientation"] = _orientation(keep["orientation"], here)
        fields["axes"] = keep.get("axes", "world")
        fields["tolerance"] = _tolerance(keep.get("tolerance", (0.1, 0.1, FREE)))
    if "box" in keep:
        fields |= _box(keep["box"])
    return PathConstraint(**fields)


def _orientation(given: object, here: Pose) -> Pose:
    if given == NOW:
        return Pose(quaternion=here.quaternion)
    if isinstance(given, str):
        raise ValueError(f"orientation is `{NOW}` or the numbers w, x, y, z, not {given!r}{nearest(given, [NOW])}")
    return Pose(quaternion=_numbers(given, 4, "orientation"))


def _tolerance(given: object) -> tuple[float, ...]:
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 3:
        raise ValueError(f"tolerance is 3 angles [rad], each a number or `{FREE}`, not {given!r}")
    return tuple(_numbers([np.inf if angle == FREE else angle for angle in given], 3, "tolerance"))


def _box(given: object) -> dict[str, Value]:
    if not isinstance(given, Mapping) or "position" not in given or "size" not in given:
        raise ValueError("box is `{position: [x, y, z], size: [x, y, z]}`: its centre and edge lengths [m]")
    _known(given, _BOX, "box")
    centre = Pose(
        _numbers(given["position"], 3, "box: position"),
        _numbers(given.get("quaternion", (1, 0, 0, 0)), 4, "box: quaternion"),
    )
    return {"box": centre, "size": tuple(_numbers(given["size"], 3, "box: size"))}


def _numbers(given: Any, count: int, name: str) -> list[float]:
    fits = isinstance(given, Sequence) and not isinstance(given, str) and len(given) == count
    if not fits or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in given):
        raise ValueError(f"{name} is {count} numbers, not {given!r}")
    return [float(x) for x in given]


def _known(given: Mapping[str, object], keys: tuple[str, ...], where: str) -> None:
    for key in given:
        if key not in keys:
            raise ValueError(f"{where} has no {key!r}{nearest(key, keys)} (available: {listing(keys)})")
