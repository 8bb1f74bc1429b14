"""Whether a motion is free all along, not only where it was sampled.

Two links come no closer between two configurations than by the sum over the joints between them of each joint's motion
times its reach (Schwarzer, Saha and Latombe 2005). So where all are clear by half of that at two neighbouring samples,
nothing between them can touch. Where they aren't clear, fine samples decide.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..collision import CollisionChecker
from .paths import interpolated

FINE = 0.004
"""Joint step of the samples where clearance doesn't decide [rad]."""
_LEVELS = 3.0
"""Rows are asked about in groups whose needs differ by this factor at most: a clearance is set for a whole group."""
_GROUPS = 4


def continuously_free(checker: CollisionChecker, positions: NDArray[np.float64]) -> bool:
    """Tell whether the motion through the rows, shape (k, n), straight between two, touches nothing."""
    if len(positions) < 2:
        return checker.all_free(positions)
    halves = half_motions(positions)
    needs = halves @ checker.reaches
    clear = np.zeros(len(positions), dtype=bool)
    level = float(needs.max())
    for group in range(_GROUPS):
        lower = level / _LEVELS if group < _GROUPS - 1 else -1.0
        rows = np.flatnonzero((needs > lower) & (needs <= level))
        if len(rows):
            clear[rows] = checker.clear_while_moving(positions[rows], halves[rows].max(axis=0))
        level = lower
    doubtful = np.flatnonzero(~(clear[:-1] & clear[1:]))
    if not len(doubtful):
        return True
    samples = np.concatenate([interpolated(positions[k : k + 2], FINE) for k in doubtful])
    return checker.all_free(samples)


def half_motions(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far each joint moves [rad] from each row, shape (k, n), half-way to its neighbours; shape (k, n)."""
    half = np.abs(np.diff(positions, axis=0)) / 2
    moves = np.zeros_like(positions)
    moves[:-1] = half
    moves[1:] = np.maximum(moves[1:], half)
    return moves
