"""The fastest velocities along a path by reachability analysis (TOPP-RA).

TOPP-RA (Pham and Pham 2018) asks at each point of a grid, from the end to the start, for the largest squared path
velocity from which the rest of the path can be driven; then it drives from the start as fast as these allow. Each
question is a linear program in the path acceleration u and the squared path velocity x. The library `toppra` hands
them to a solver of general programs, one by one, which takes as long as finding a path. With symmetric limits of
velocity and acceleration alone, and rest at both ends, standing still is always allowed, and each program is the
least of a few straight lines: their coefficients are computed for all points at once. The answers are the same;
the tests compare them with those of `toppra`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from grip_bt.base.arrays import Array

_TINY = 1e-12


class _Lines(NamedTuple):
    """For each stage, shape (m, k): |u + slope * x| <= height, once for each joint and each end of the stage."""

    slope: Array
    height: Array


def squared_velocities(grid: Array, first: Array, second: Array, velocity: Array, acceleration: Array) -> Array:
    """Return the largest squared path velocities from rest to rest [1/s^2], shape (m + 1,).

    Between two points of the grid the path acceleration is constant. Accelerations keep their limits at both ends of
    each stage (TOPP-RA's "interpolation" scheme), velocities at the points of the grid.
    """
    doubled = 2.0 * np.diff(grid)
    lines = _lines(doubled, first, second, acceleration)
    with np.errstate(divide="ignore"):
        ceiling = np.min((velocity / np.abs(first)) ** 2, axis=1)[:-1]
    highest = _controllable(doubled, lines, np.minimum(ceiling, _crossings(doubled, lines)))
    return _driven(doubled, lines, highest)


def _lines(doubled: Array, first: Array, second: Array, acceleration: Array) -> _Lines:
    at_end = first[1:] + doubled[:, None] * second[1:]  # there the squared velocity is x + doubled * u
    factor = np.concatenate([first[:-1], at_end], axis=1)
    factor = np.where(np.abs(factor) < _TINY, _TINY, factor)
    bend = np.concatenate([second[:-1], second[1:]], axis=1)
    return _Lines(bend / factor, np.tile(acceleration, 2) / np.abs(factor))


def _crossings(doubled: Array, lines: _Lines) -> Array:
    """Return the largest x of each stage for which some u keeps all lines and stops short of driving backwards."""
    slope, height = lines
    one, other = np.triu_indices(slope.shape[1], 1)
    apart, together = np.abs(slope[:, one] - slope[:, other]), height[:, one] + height[:, other]
    pairs = np.divide(together, apart, out=np.full_like(apart, np.inf), where=apart > 0).min(axis=1)
    steep = slope - 1.0 / doubled[:, None]
    forwards = np.divide(height, steep, out=np.full_like(height, np.inf), where=steep > 0).min(axis=1)
    return np.minimum(pairs, forwards)


def _controllable(doubled: Array, lines: _Lines, ceiling: Array) -> list[float]:
    """Return the largest x of each grid point, m + 1, from which the end can be reached at rest."""
    room = 1.0 - doubled[:, None] * lines.slope
    held = room > 0
    part = np.divide(1.0, room, out=np.zeros_like(room), where=held)
    gained = np.where(held, doubled[:, None] * lines.height * part, np.inf)
    stages = zip(ceiling[::-1].tolist(), part[::-1].tolist(), gained[::-1].tolist(), strict=True)
    highest = [0.0]
    for top, parts, gains in stages:
        after = highest[-1]
        highest.append(min(top, min([p * after + g for p, g in zip(parts, gains, strict=True)])))
    return highest[::-1]


def _driven(doubled: Array, lines: _Lines, highest: list[float]) -> Array:
    """Drive from rest as fast as the acceleration limits and the `highest` squared velocities allow."""
    stages = zip(doubled.tolist(), lines.slope.tolist(), lines.height.tolist(), highest[1:], strict=True)
    driven = [0.0]
    for twice, slopes, heights, top in stages:
        x = driven[-1]
        hardest = min([h - s * x for s, h in zip(slopes, heights, strict=True)])
        driven.append(min(top, max(0.0, x + twice * hardest)))
    return np.array(driven)
