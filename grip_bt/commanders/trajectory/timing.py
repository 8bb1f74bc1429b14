"""From a path to a trajectory: the fastest timing within the limits (TOPP-RA, Pham and Pham 2018)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from grip_bt.errors import PathInvalidError
from grip_bt.values import Trajectory

from ..model import Limits
from . import Timing
from .reachability import squared_velocities

SAMPLING = 0.02
"""Time between two points of a trajectory [s]."""
_GRID = 0.02
"""Distance along the path [rad] between the points where the limits are held."""
_FINER = 4
"""Points of the grid between two knots that are closer than that."""
_SPACINGS = (0.25, 0.12, 0.06)


def timed(
    names: tuple[str, ...],
    path: NDArray[np.float64],
    limits: Limits,
    speed: float,
    acceptable: Callable[[NDArray[np.float64]], bool],
    acceleration: float | None = None,
    timing: Timing = "direct",
) -> Trajectory:
    """Return the path as a smooth trajectory that starts and ends at rest.

    A cubic spline through the path cuts its corners, by an eighth of the distance of its knots. So the spline's samples
    are put to `acceptable`, and where they aren't, the knots are set closer.

    Args:
        names: the n joints.
        path: shape (k, n) [rad].
        limits: of the joints.
        speed: part of the velocity limits to use, in (0, 1].
        acceptable: takes the trajectory's positions, shape (m, n), and tells whether they are free.
        acceleration: part of the acceleration limits to use, in (0, 1]; as `speed` when it isn't given.
        timing: who finds the velocities.

    Raises:
        PathInvalidError: no spacing of the knots is acceptable.
    """
    if np.abs(path - path[0]).max() < 1e-6:
        return Trajectory(names, np.zeros(1), path[:1], np.zeros((1, len(names))), np.zeros((1, len(names))))
    for spacing in _SPACINGS:
        trajectory = _timed_spline(names, _knots(path, spacing), limits, speed, acceleration or speed, timing)
        if acceptable(trajectory.positions):
            return trajectory
    raise PathInvalidError("the path can't be timed without leaving the free space", knots=len(path))


def _knots(path: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """Return the path's corners and points between them, at most `spacing` [rad] apart, and no two alike."""
    rows = [path[0]]
    for corner in path[1:]:
        last = rows[-1]
        steps = int(np.ceil(np.linalg.norm(corner - last) / spacing))
        rows.extend(last + (corner - last) * (np.arange(1, steps + 1) / steps)[:, None])
    return np.stack(rows)


def _timed_spline(
    names: tuple[str, ...],
    knots: NDArray[np.float64],
    limits: Limits,
    speed: float,
    acceleration: float,
    timing: Timing,
) -> Trajectory:
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    spline = CubicSpline(at, knots, bc_type="natural")
    grid = _grid(at)
    allowed = limits.velocity * speed, limits.acceleration * acceleration
    if timing == "toppra":
        from .library import squared_velocities as by_the_library  # a second to import, and seldom asked for

        squared = by_the_library(grid, spline, *allowed)
    else:
        squared = squared_velocities(grid, spline(grid, 1), spline(grid, 2), *allowed)
    drive = _Drive(grid, squared)
    times = np.linspace(0.0, drive.duration, max(2, int(np.ceil(drive.duration / SAMPLING)) + 1))
    where, velocity, change = drive(times)
    by_path = spline(where, 1)
    # Between knots that lie on a limit the spline swings past it a little; an executor must not see that.
    positions = np.clip(spline(where), limits.lower, limits.upper)
    positions[0], positions[-1] = knots[0], knots[-1]
    velocities = by_path * velocity[:, None]
    accelerations = by_path * change[:, None] + spline(where, 2) * (velocity**2)[:, None]
    return Trajectory(names, times, positions, velocities, accelerations)


def _grid(at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return increasing path positions, from those of the knots, shape (k,): even, and finer where knots are close.

    Knots are close where the path turns sharply. With a step across such a place both its ends would have to be passed
    with one acceleration along the path, which only a stop allows.
    """
    even = np.linspace(0.0, at[-1], int(np.clip(np.ceil(at[-1] / _GRID), 40, 400)) + 1)
    close = np.flatnonzero(np.diff(at) < _GRID)
    fine = [np.linspace(at[k], at[k + 1], _FINER + 1)[1:] for k in close]
    both = np.unique(np.concatenate([even, *fine]))
    apart = np.concatenate([[True], np.diff(both) > 1e-6])
    apart[-1] = True
    grid: NDArray[np.float64] = both[apart]
    return grid


class _Drive:
    """Path position by time, with constant path acceleration between the points of a grid.

    Attributes:
        duration: when the path's end is reached [s].

    Args:
        grid: path positions, shape (m + 1,).
        squared: squared path velocities there, shape (m + 1,); two neighbours aren't both zero.
    """

    def __init__(self, grid: NDArray[np.float64], squared: NDArray[np.float64]):
        self._grid, self._velocity, steps = grid, np.sqrt(squared), np.diff(grid)
        self._change = np.diff(squared) / (2.0 * steps)
        self._times = np.concatenate([[0.0], np.cumsum(2.0 * steps / (self._velocity[:-1] + self._velocity[1:]))])
        self.duration = float(self._times[-1])

    def __call__(
        self, times: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return path position, its velocity and its acceleration at times in [0, duration], each of shape (k,)."""
        stage = np.clip(np.searchsorted(self._times, times, side="right") - 1, 0, len(self._change) - 1)
        since, begin, change = times - self._times[stage], self._velocity[stage], self._change[stage]
        where = np.minimum(self._grid[stage] + begin * since + change * since**2 / 2, self._grid[-1])
        return where, np.maximum(begin + change * since, 0.0), change
