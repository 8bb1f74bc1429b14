"""From a path to a trajectory: the fastest timing within the limits (TOPP-RA, Pham and Pham 2018)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy

import numpy as np
from scipy.interpolate import BSpline

from grip_bt.base.arrays import Array
from grip_bt.base.failures import PathInvalidError
from grip_bt.base.values import Trajectory
from grip_bt.commanders.trajectory.limits import Limits
from grip_bt.commanders.trajectory.splines import averaged, slowed, smoothed
from grip_bt.commanders.trajectory.toppra_alone import ParametrizeConstAccel, Timing, toppra

toppra.setup_logging("ERROR")
_VELOCITIES = toppra.constraint.JointVelocityConstraint(np.ones(1))
_ACCELERATIONS = toppra.constraint.JointAccelerationConstraint(np.ones(1))
"""Copied, with other limits: each that is made says its limits in words, which takes longer than its use."""

SAMPLING = 0.01
"""Time between two points of a trajectory [s]; of a short one, down to `_SHORTEST`."""
_SHORTEST, _POINTS = 0.004, 100
STILL = 1e-6
"""A path on which no joint moves further than this [rad or m] has been followed already."""
_GRID = 0.02
"""Distance along the path [rad] between the points where the limits are held."""
_FINER, _LEAST, _MOST = 4, 40, 400
"""Points of the grid between two knots, and on the whole path."""
_SAME = 1e-7
"""Rows of a path that are closer than this part of all of it are one."""
_TINY = 1e-9
"""Joints that move less than this part of the path count as ones that move as much."""
_SPACINGS = (0.25, 0.12, 0.06, 0.03)
_SLOWER = (1.0, 1.25, 1.6, 2.0, 3.0, 5.0)
"""Where keeping to a jerk leads too far off the path, times are made this much longer, one after the other."""


def timed(
    names: tuple[str, ...],
    path: Array,
    limits: Limits,
    acceptable: Callable[[Trajectory], bool],
) -> Trajectory:
    """Return the path as a smooth trajectory that starts and ends at rest.

    Velocities, accelerations and jerks are within what is allowed at its points and wherever a controller interpolates
    between them, since it is a cubic spline in time; see `splines`.

    A B-spline along the path cuts its corners, by about a sixth of the distance of its knots. So the result is put to
    `acceptable`, and where it isn't, the knots are set closer.

    Args:
        path: shape (k, n) [rad].
        limits: what the joints may do of what they can.
        acceptable: takes the trajectory and tells whether it is free.

    Raises:
        PathInvalidError: no spacing of the knots is acceptable.
    """
    rows = _apart(path)
    if len(rows) < 2:
        still = np.zeros((1, len(names)))
        return Trajectory(names, np.zeros(1), path[:1], still, still)
    for trajectory in _candidates(names, rows, limits):
        if acceptable(trajectory):
            return trajectory
    raise PathInvalidError("the path can't be timed without leaving the free space", knots=len(path))


def _apart(path: Array) -> Array:
    """Return the path without rows that are where the one before is; one row, where nothing moves."""
    largest = np.abs(path - path[0]).max()
    if largest <= STILL:
        return path[:1]
    kept = [0]
    for k in range(1, len(path)):
        if np.abs(path[k] - path[kept[-1]]).max() > _SAME * largest:
            kept.append(k)
    rows = path[kept]
    rows[-1] = path[-1]
    return rows


def _candidates(names: tuple[str, ...], path: Array, limits: Limits) -> Iterator[Trajectory]:
    slower = (1.0,) if limits.jerk is None else _SLOWER
    for spacing in _SPACINGS:
        at, curve = _curve(_knots(path, spacing))
        drive = _drive(at, curve, limits)
        for factor in slower:
            step, rows = _sampled(drive, factor, limits)
            if limits.jerk is not None:
                rows = averaged(rows, _window(rows, step, limits.jerk))
            yield slowed(smoothed(names, rows, step), limits.velocity, limits.acceleration, limits.jerk)


def _sampled(drive: ParametrizeConstAccel, slower: float, limits: Limits) -> tuple[float, Array]:
    """Return the time between positions on the path [s], and these, shape (k, n)."""
    duration = drive.duration * slower
    count = max(2, int(np.ceil(duration / np.clip(duration / _POINTS, _SHORTEST, SAMPLING))))
    rows = drive(np.linspace(0.0, drive.duration, count + 1))
    rows = np.clip(rows, limits.lower, limits.upper)  # on a limit, rounding would be outside
    return max(duration / count, _SHORTEST), rows


def _window(rows: Array, step: float, jerk: Array) -> int:
    """Return of how many rows the mean is taken so that no jerk is above its limit; a power of 1.25, about."""
    count = 1
    while count <= len(rows):
        mean = averaged(rows, count)
        ends = np.concatenate([np.repeat(mean[:1], 3, axis=0), mean[1:], np.repeat(mean[-1:], 2, axis=0)])
        if (np.abs(np.diff(ends, 3, axis=0)).max(axis=0) <= jerk * step**3).all():
            break
        count += max(1, count // 4)
    return count


def _knots(path: Array, spacing: float) -> Array:
    """Return the path's corners and points between them, at most `spacing` [rad] apart, and no two alike."""
    rows = [path[0]]
    for corner in path[1:]:
        last = rows[-1]
        steps = int(np.ceil(np.linalg.norm(corner - last) / spacing))
        rows.extend(last + (corner - last) * (np.arange(1, steps + 1) / steps)[:, None])
    return np.stack(rows)


def _curve(knots: Array) -> tuple[Array, BSpline]:
    """Return path positions of the knots, shape (k, n), by their distances, and a cubic B-spline along them.

    Its control points are on the straight lines between the knots. So the curve stays in what these span, within the
    limits of the joints for one, and is straight where the path is.
    """
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    padded = np.concatenate([np.zeros(3), at, np.full(3, at[-1])])
    middles = (padded[1:-3] + padded[2:-2] + padded[3:-1]) / 3.0
    controls = np.stack([np.interp(middles, at, column) for column in knots.T], axis=1)
    return at, BSpline(padded, controls, 3)


def _drive(at: Array, curve: BSpline, limits: Limits) -> ParametrizeConstAccel:
    """Return the fastest way along the path, from rest to rest, as the library `toppra` finds it.

    The tolerances of the library are absolute, so it is given a path of length 1, accelerations of about 1,
    and joints that all move: each is scaled by how steep its curve is.
    """
    grid, along = _grid(at), float(at[-1])
    unit = float(np.sqrt(along / np.median(limits.acceleration)))
    steepest = np.maximum(np.abs(curve(grid, 1)).max(axis=0), _TINY)
    scale = unit / (along * steepest)
    velocity, acceleration = limits.velocity * scale, limits.acceleration * unit * scale
    first, last = (curve(end, 1) / steepest for end in (at[0], at[-1]))  # with these its spline is the same curve
    rows = (curve(at) - curve(at[0])) / (along * steepest)
    path = toppra.SplineInterpolator(at / along, rows, bc_type=((1, first), (1, last)))
    most = copy(_VELOCITIES), copy(_ACCELERATIONS)
    most[0].vlim, most[1].alim = (np.stack([-limit, limit], axis=1) for limit in (velocity, acceleration))
    most[0].dof = most[1].dof = len(velocity)
    _, found, _ = Timing([*most], path, grid / along).compute_parameterization(0, 0)
    if found is None or np.isnan(found).any():
        raise PathInvalidError("toppra finds no timing for the path", knots=len(at))
    return ParametrizeConstAccel(curve, grid, np.asarray(found, dtype=np.float64) * (along / unit))


def _grid(at: Array) -> Array:
    """Return increasing path positions, from those of the knots, shape (k,): the knots, and points between them.

    Accelerations along a cubic spline are extreme at its knots. Where they are close the path turns sharply; with a
    step across such a place both its ends would have to be passed with one acceleration, which only a stop allows.
    """
    gaps = np.diff(at)
    parts = np.maximum(np.ceil(gaps / max(_GRID, at[-1] / _MOST)), _FINER)
    parts = np.ceil(parts * max(1.0, _LEAST / parts.sum())).astype(int)
    pieces = [begin + gap * (np.arange(1, n + 1) / n) for begin, gap, n in zip(at[:-1], gaps, parts, strict=True)]
    return np.concatenate([at[:1], *pieces])
