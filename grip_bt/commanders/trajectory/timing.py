"""From a path to a trajectory: the fastest timing within the limits (TOPP-RA, Pham and Pham 2018)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint
from numpy.typing import NDArray

from grip_bt.errors import PathInvalidError
from grip_bt.values import Trajectory

from ..model import Limits

SAMPLING = 0.02
"""Time between two points of a trajectory [s]."""
_GRID = 0.02
"""Distance along the path [rad] between the points where the limits are held; TOPP-RA's own choice takes as long as its
solution."""
_SPACINGS = (0.25, 0.12, 0.06)
toppra.setup_logging("ERROR")


def timed(
    names: tuple[str, ...],
    path: NDArray[np.float64],
    limits: Limits,
    speed: float,
    acceptable: Callable[[NDArray[np.float64]], bool],
    acceleration: float | None = None,
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

    Raises:
        PathInvalidError: no spacing of the knots is acceptable, or there is no timing.
    """
    if np.abs(path - path[0]).max() < 1e-6:
        return Trajectory(names, np.zeros(1), path[:1], np.zeros((1, len(names))), np.zeros((1, len(names))))
    for spacing in _SPACINGS:
        trajectory = _timed_spline(names, _knots(path, spacing), limits, speed, acceleration or speed)
        if trajectory is not None and acceptable(trajectory.positions):
            return trajectory
    raise PathInvalidError("the path can't be timed without leaving the free space", knots=len(path))


def _knots(path: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """Return the path's corners and points between them, at most `spacing` [rad] apart, and no two alike."""
    rows = [path[0]]
    for corner in path[1:]:
        last = rows[-1]
        steps = int(np.ceil(np.linalg.norm(corner - last) / spacing))
        rows.extend(last + (corner - last) * (k / steps) for k in range(1, steps + 1))
    return np.stack(rows)


def _timed_spline(
    names: tuple[str, ...], knots: NDArray[np.float64], limits: Limits, speed: float, acceleration: float
) -> Trajectory | None:
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    spline = toppra.SplineInterpolator(at, knots, bc_type="natural")
    fastest, hardest = limits.velocity * speed, limits.acceleration * acceleration
    constraints = [
        toppra.constraint.JointVelocityConstraint(np.stack([-fastest, fastest], axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack([-hardest, hardest], axis=1)),
    ]
    grid = np.linspace(0.0, at[-1], int(np.clip(np.ceil(at[-1] / _GRID), 40, 400)) + 1)
    method = toppra.algorithm.TOPPRA(constraints, spline, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    timing = method.compute_trajectory(0, 0)
    if timing is None:
        return None
    times = np.linspace(0.0, timing.duration, max(2, int(np.ceil(timing.duration / SAMPLING)) + 1))
    # Between knots that lie on a limit the spline swings past it a little; an executor must not see that.
    positions = np.clip(timing(times), limits.lower, limits.upper)
    positions[0], positions[-1] = knots[0], knots[-1]
    return Trajectory(names, times, positions, timing(times, 1), timing(times, 2))
