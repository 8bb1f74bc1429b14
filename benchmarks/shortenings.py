"""Ways to shorten a path that were tried beside `planning.paths.shortened`; see `plan_ways.py`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from grip_bt.commanders.planning import paths
from grip_bt.commanders.planning.search import MotionCheck

Array = NDArray[np.float64]
SHORTENED = paths.shortened
_FRACTIONS = np.array([0.5, 0.25, 0.75])


def in_batches(
    path: Array, motion_free: MotionCheck, rng: np.random.Generator, rounds: int = 60, at_once: int = 8
) -> Array:
    """Draw several shortcuts, ask of all at once whether their middles and quarters are free, take the best that is."""
    path, idle, done = paths._pruned(path, motion_free), 0, 0
    while done < rounds and len(path) > 2 and idle < paths._PATIENCE:
        at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        drawn = []
        for _ in range(at_once):
            done, idle = done + 1, idle + 1
            low, high = np.sort(rng.uniform(0.0, at[-1], 2))
            i, j = int(np.searchsorted(at, low, "right")) - 1, int(np.searchsorted(at, high, "right")) - 1
            one, other = paths._point(path, at, i, low), paths._point(path, at, j, high)
            gain = high - low - float(np.linalg.norm(other - one))
            if i != j and gain > paths._WORTH * at[-1]:
                drawn.append((gain, i, j, one, other))
        if not drawn:
            continue
        rows = np.stack([one + (other - one) * f for *_, one, other in drawn for f in _FRACTIONS])
        likely = motion_free.checker.free_each(rows).reshape(-1, len(_FRACTIONS)).all(axis=1)
        for _, i, j, one, other in sorted((d for d, k in zip(drawn, likely, strict=True) if k), key=lambda d: -d[0]):
            if motion_free(one, other):
                path, idle = np.concatenate([path[: i + 1], [one, other], path[j + 1 :]]), 0
                break
    return paths._pruned(path, motion_free)


def patient(trials: int) -> Callable[..., Any]:
    """Return what gives up after other than 18 trials without a gain."""

    def shortened(*arguments: Any) -> Array:
        with mock.patch.object(paths, "_PATIENCE", trials):
            return SHORTENED(*arguments)

    return shortened


SHORTENINGS: dict[str, Callable[..., Any]] = {
    "shortcuts by fours": partial(in_batches, at_once=4),
    "shortcuts by eights": in_batches,
    "patience of 10": patient(10),
    "patience of 30": patient(30),
}
