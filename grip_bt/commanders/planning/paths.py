"""Piecewise linear paths in joint space: arrays of shape (k, n) whose rows are configurations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grip_bt.base.arrays import Array, Path

EdgeCheck = Callable[[Array, Array], bool]
"""`(one, other) -> whether the straight motion between two configurations is free`."""
_WORTH = 0.01
"""A shortcut that makes the path shorter by less than this part isn't worth its collision check."""
_PATIENCE = 18


def interpolated(path: Path, resolution: float) -> Path:
    """Return the path with rows added so that no joint moves more than `resolution` [rad] between two."""
    pieces = [path[:1]]
    for one, other in zip(path[:-1], path[1:], strict=True):
        steps = max(1, int(np.ceil(np.abs(other - one).max() / resolution)))
        pieces.append(one + (other - one) * (np.arange(1, steps + 1) / steps)[:, None])
    return np.concatenate(pieces)


def length(path: Path) -> float:
    """Return the length of a path [rad], joints weighted alike."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def shortened(path: Path, edge_free: EdgeCheck, rng: np.random.Generator, rounds: int = 60) -> Path:
    """Return a path with the same ends that is no longer.

    First every row that can be skipped is skipped, from the far end on; then random pairs of points on the path
    are joined where the straight motion is free (Geraerts and Overmars 2007). It ends after so many rounds, or when
    a dozen in a row had nothing to gain, so the result depends on nothing but the arguments.
    """
    path, idle = _pruned(path, edge_free), 0
    for _ in range(rounds):
        if len(path) < 3 or idle >= _PATIENCE:
            break
        idle += 1
        at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        low, high = np.sort(rng.uniform(0.0, at[-1], 2))
        i, j = int(np.searchsorted(at, low, "right")) - 1, int(np.searchsorted(at, high, "right")) - 1
        if i == j:
            continue
        one, other = _point(path, at, i, low), _point(path, at, j, high)
        gain = high - low - float(np.linalg.norm(other - one))
        if gain > _WORTH * at[-1] and edge_free(one, other):
            idle = 0
            path = np.concatenate([path[: i + 1], [one, other], path[j + 1 :]])
    return _pruned(path, edge_free)


def _pruned(path: Path, edge_free: EdgeCheck) -> Path:
    rows, i = [0], 0
    while i < len(path) - 1:
        i = next((j for j in range(len(path) - 1, i + 1, -1) if edge_free(path[i], path[j])), i + 1)
        rows.append(i)
    return path[rows]


def _point(path: Path, at: Array, row: int, where: float) -> Array:
    if row >= len(path) - 1:
        return np.array(path[-1])
    span = at[row + 1] - at[row]
    return path[row] + (path[row + 1] - path[row]) * ((where - at[row]) / span if span > 0 else 0.0)
