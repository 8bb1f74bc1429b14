"""Whether a motion is free all along, not only where it was sampled.

Two links come no closer between two configurations than by the sum over the joints between them of each joint's motion
times its reach (Schwarzer, Saha and Latombe 2005). So where all are clear by that much in the middle of a piece of the
motion, nothing in it can touch. Pieces where they aren't are divided, until they are or what is left nearly touches.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grip_bt.values import Trajectory

from ..collision import CollisionChecker
from ..trajectory.splines import cubics
from .paths import Path

FINE = (1e-3, 1e-4)
"""Joint steps in which a hand's shapes are looked at, not its hull [rad]. What isn't clear even at the last, by
some 0.05 mm, counts as touching."""
_NEEDS = (0.03, 0.008, 0.002)
"""Pieces are made so short, one level after the other, that nothing moves further than this from their middles [m]."""
_GROUPS = 3
"""Middles are asked about in groups of alike needs: a clearance is set for a whole group."""

Curve = Callable[[NDArray[np.float64]], Path]
"""Parameters, shape (m,) -> configurations, shape (m, n)."""


class _Pieces(NamedTuple):
    """Pieces of a motion, k of them.

    Attributes:
        begin: parameter where each begins, shape (k,).
        end: where each ends, shape (k,).
        bow: how far each joint is at most off the straight way from one end of a piece to the other, shape (k, n).
    """

    begin: NDArray[np.float64]
    end: NDArray[np.float64]
    bow: NDArray[np.float64]

    @property
    def middle(self) -> NDArray[np.float64]:
        middle: NDArray[np.float64] = (self.begin + self.end) / 2
        return middle

    def those(self, kept: NDArray[np.bool_]) -> _Pieces:
        return _Pieces(self.begin[kept], self.end[kept], self.bow[kept])

    def divided(self, counts: NDArray[np.float64]) -> _Pieces:
        """Return each in so many pieces, shape (k,)."""
        whole = np.maximum(np.ceil(counts), 1).astype(int)
        piece = np.repeat(np.arange(len(whole)), whole)
        nth = np.arange(len(piece)) - np.repeat(np.cumsum(whole) - whole, whole)
        length = ((self.end - self.begin) / whole)[piece]
        begin = self.begin[piece] + nth * length
        return _Pieces(begin, begin + length, self.bow[piece] / whole[piece][:, None] ** 2)


def continuously_free(checker: CollisionChecker, positions: Path) -> bool:
    """Tell whether the motion through the rows, shape (k, n), straight between two, touches nothing."""
    if len(positions) < 2:
        return checker.all_free(positions)
    rows = np.arange(len(positions), dtype=float)

    def between(where: NDArray[np.float64]) -> Path:
        begin = np.minimum(where.astype(int), len(positions) - 2)
        rows: Path = positions[begin] + (positions[begin + 1] - positions[begin]) * (where - begin)[:, None]
        return rows

    return _free(checker, between, _Pieces(rows[:-1], rows[1:], np.zeros((len(rows) - 1, positions.shape[1]))))


def trajectory_free(checker: CollisionChecker, trajectory: Trajectory) -> bool:
    """Tell whether a trajectory touches nothing wherever it is on the cubics between its points, as it is executed.

    Args:
        checker: of its joints, in its order.
        trajectory: its points have velocities.
    """
    if len(trajectory.times) < 2:
        return checker.all_free(trajectory.positions)
    moved = np.cumsum(np.abs(np.diff(trajectory.positions, axis=0)) @ checker.reaches)
    rows = np.unique([0, *np.searchsorted(moved, np.arange(0.0, moved[-1], 2 * _NEEDS[0])), len(moved)])
    _, _, second, third = cubics(trajectory)
    last = second + third * np.diff(trajectory.times)[:, None]
    hardest = np.maximum.reduceat(np.maximum(np.abs(second), np.abs(last)), rows[:-1], axis=0)
    at = trajectory.times[rows]
    pieces = _Pieces(at[:-1], at[1:], hardest * (np.diff(at)[:, None] ** 2 / 8))
    return _free(checker, lambda where: trajectory.sampled(where)[0], pieces)


def _free(checker: CollisionChecker, curve: Curve, pieces: _Pieces) -> bool:
    """Tell whether a motion is free: what clearance doesn't decide, by pieces of it, and then by fine samples."""
    for level, need in enumerate(_NEEDS):
        halves = _halves(curve, pieces)
        if level:
            pieces = pieces.divided((halves @ checker.reaches) / need)
            halves = _halves(curve, pieces)
        middles = curve(pieces.middle)
        clear = _clear(checker, middles, halves)
        if not level and not checker.all_free(middles[~clear]):  # what touches is mostly found out here
            return False
        pieces = pieces.those(~clear)
        if not len(pieces.begin):
            return True
    for step in FINE:  # near a hand's hull, or near to touching
        pieces = pieces.divided(2 * _halves(curve, pieces).max(axis=1) / step)
        for hulls in (True, False):
            pieces = pieces.those(~_clear(checker, curve(pieces.middle), _halves(curve, pieces), hulls))
            if not len(pieces.begin):
                return True
    return False


def _halves(curve: Curve, pieces: _Pieces) -> NDArray[np.float64]:
    """Return how far each joint moves at most from the middle of each piece, shape (k, n) [rad]."""
    middle = curve(pieces.middle)
    ends = np.maximum(np.abs(curve(pieces.begin) - middle), np.abs(curve(pieces.end) - middle))
    halves: NDArray[np.float64] = ends + pieces.bow / 4
    return halves


def _clear(checker: CollisionChecker, rows: Path, halves: NDArray[np.float64], hulls: bool = True) -> NDArray[np.bool_]:
    """Tell from which rows, shape (k, n), the joints can move so far, shape (k, n), and touch nothing."""
    clear = np.zeros(len(rows), dtype=bool)
    order = np.argsort(halves @ checker.reaches)
    for some in np.array_split(order, min(_GROUPS, len(order))):
        clear[some] = checker.clear_while_moving(rows[some], halves[some].max(axis=0), hulls)
    return clear
