"""Whether a motion is free all along, not only where it was sampled.

Two links come no closer between two configurations than by the sum over the joints between them of each joint's motion
times its reach (Schwarzer, Saha and Latombe 2005). So where all are clear by that much in the middle of a piece of the
motion, nothing in it can touch. Pieces where they aren't are divided, until they are or what is left nearly touches.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from grip_bt.base.arrays import Array, Mask, Path
from grip_bt.base.values import Trajectory

from ..kinematics.collision import CollisionChecker
from ..trajectory.splines import cubics
from ..trajectory.stopping import quintic_jerks

FINE = (1e-3, 1e-4)
"""Joint steps in which a hand's shapes are looked at, not its hull [rad]. What isn't clear even at the last, by
some 0.05 mm, counts as touching."""
_NEEDS = (0.03, 0.008, 0.002)
"""Pieces are made so short, one level after the other, that nothing moves further than this from their middles [m]."""
_GROUPS = 3
"""Middles are asked about in groups of similar needs: a clearance is set for a whole group."""

Curve = Callable[[Array], Path]
"""Parameters, shape (m,) -> configurations, shape (m, n)."""


class _Pieces(NamedTuple):
    """Pieces of a motion, k of them.

    Attributes:
        begin: parameter where each begins, shape (k,).
        end: where each ends, shape (k,).
        bow: how far each joint is at most off the straight way from one end of a piece to the other, shape (k, n).
    """

    begin: Array
    end: Array
    bow: Array

    @property
    def middle(self) -> Array:
        return (self.begin + self.end) / 2

    def those(self, kept: Mask) -> _Pieces:
        return _Pieces(self.begin[kept], self.end[kept], self.bow[kept])

    def divided(self, counts: Array) -> _Pieces:
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

    def between(where: Array) -> Path:
        begin = np.minimum(where.astype(int), len(positions) - 2)
        return positions[begin] + (positions[begin + 1] - positions[begin]) * (where - begin)[:, None]

    pieces = _Pieces(rows[:-1], rows[1:], np.zeros((len(rows) - 1, positions.shape[1])))
    return _undecided(checker, between, pieces) is None


def trajectory_free(checker: CollisionChecker, trajectory: Trajectory) -> bool:
    """Tell whether a trajectory of the checker's joints touches nothing wherever it is, as it is executed."""
    return _undecided(checker, *_executed(checker, (trajectory,))) is None


def first_touch(
    checker: CollisionChecker, *trajectories: Trajectory
) -> tuple[float, tuple[tuple[str, str], ...]] | None:
    """Return after what time [s] a motion touches something, and what; None when it is free all along.

    Args:
        checker: of the joints of all trajectories.
        trajectories: what is executed at once, as `Trajectory.sampled` interpolates; each is of other joints.
    """
    curve, pieces = _executed(checker, trajectories)
    left = _undecided(checker, curve, pieces)
    if left is None:
        return None
    rows = curve(left.middle)
    first = int(np.argmin(checker.free_each(rows)))  # none of them, where all only come too near
    return float(left.middle[first]), checker.pairs(rows[first])


def _executed(checker: CollisionChecker, trajectories: Sequence[Trajectory]) -> tuple[Curve, _Pieces]:
    """Return the configurations of a motion by time, and pieces of it that are smooth."""
    joints = checker.chain.joints
    parts = [(each, [joints.index(name) for name in each.names]) for each in trajectories]

    def curve(times: Array) -> Path:
        rows = np.zeros((len(times), len(joints)))
        for trajectory, columns in parts:
            rows[:, columns] = trajectory.sampled(times)[0]
        return rows

    times = np.unique(np.concatenate([each.times for each in trajectories]))
    if len(times) < 2:
        return curve, _Pieces(times, times, np.zeros((1, len(joints))))
    moved = np.cumsum(np.abs(np.diff(curve(times), axis=0)) @ checker.reaches)
    ends = [0, *np.searchsorted(moved, np.arange(0.0, moved[-1], 2 * _NEEDS[0])), len(moved)]
    corners = [each.times if each.velocities is None else each.times[-1:] for each in trajectories]
    at = times[np.unique(np.concatenate([ends, np.searchsorted(times, np.concatenate(corners))]))]
    bow = np.zeros((len(at) - 1, len(joints)))
    for trajectory, columns in parts:
        bow[:, columns] = _hardest(trajectory, at) * (np.diff(at)[:, None] ** 2 / 8)
    return curve, _Pieces(at[:-1], at[1:], bow)


def _hardest(trajectory: Trajectory, at: Array) -> Array:
    """Return accelerations that a trajectory is nowhere above between times, shape (m,): shape (m - 1, n)."""
    if len(trajectory.times) < 2 or trajectory.velocities is None:
        return np.zeros((len(at) - 1, len(trajectory.names)))
    steps, given = np.diff(trajectory.times)[:, None], trajectory.accelerations
    if given is None:
        _, _, second, third = cubics(trajectory)
        bounds = [second, second + third * steps]
    else:  # the Bernstein coefficients of a quintic's acceleration, which is between the least and the largest
        first, _, last = quintic_jerks(trajectory) * (steps / 3)
        bounds = [given[:-1], given[:-1] + first, given[1:] - last, given[1:]]
    hardest = np.abs(bounds).max(axis=0)
    begin = np.searchsorted(trajectory.times, at[:-1], side="right") - 1
    end = np.searchsorted(trajectory.times, at[1:])
    spans = np.clip(np.stack([begin, np.maximum(end, begin + 1)], axis=1), [0, 1], [len(steps) - 1, len(steps)])
    whole: Array = np.maximum.reduceat(np.concatenate([hardest, hardest[-1:]]), spans.ravel(), axis=0)
    return whole[::2]


def _undecided(checker: CollisionChecker, curve: Curve, pieces: _Pieces) -> _Pieces | None:
    """Return the pieces that touch something or may, which clearance and then fine samples don't decide; None: free."""
    for level, need in enumerate(_NEEDS):
        halves = _halves(curve, pieces)
        if level:
            pieces = pieces.divided((halves @ checker.reaches) / need)
            halves = _halves(curve, pieces)
        middles = curve(pieces.middle)
        clear = _clear(checker, middles, halves)
        pieces = pieces.those(~clear)
        if not level and not checker.all_free(middles[~clear]):  # what touches is mostly found out here
            return pieces
        if not len(pieces.begin):
            return None
    for step in FINE:  # near a hand's hull, or near to touching
        pieces = pieces.divided(2 * _halves(curve, pieces).max(axis=1) / step)
        for hulls in (True, False):
            pieces = pieces.those(~_clear(checker, curve(pieces.middle), _halves(curve, pieces), hulls))
            if not len(pieces.begin):
                return None
    return pieces


def _halves(curve: Curve, pieces: _Pieces) -> Array:
    """Return how far each joint moves at most from the middle of each piece, shape (k, n) [rad]."""
    middle = curve(pieces.middle)
    ends = np.maximum(np.abs(curve(pieces.begin) - middle), np.abs(curve(pieces.end) - middle))
    return ends + pieces.bow / 4


def _clear(checker: CollisionChecker, rows: Path, halves: Array, hulls: bool = True) -> Mask:
    """Tell from which rows, shape (k, n), the joints can move so far, shape (k, n), and touch nothing."""
    clear = np.zeros(len(rows), dtype=bool)
    order = np.argsort(halves @ checker.reaches)
    for some in np.array_split(order, min(_GROUPS, len(order))):
        clear[some] = checker.clear_while_moving(rows[some], halves[some].max(axis=0), hulls)
    return clear
