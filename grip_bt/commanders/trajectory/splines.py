"""Trajectories that controllers follow as they were checked: cubic splines in time, twice continuously differentiable.

A joint_trajectory_controller draws a cubic between two points that have velocities, and a quintic where they have
accelerations too: between the points of a spline whose acceleration is linear both are that spline itself. It comes
from positions at even times as those of a B-spline's control points, so no extreme is added.
"""

from __future__ import annotations

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Trajectory

_STEP = 0.02
"""Time between two points of a motion in joint space [s]."""


def smoothed(names: tuple[str, ...], rows: Array, step: float) -> Trajectory:
    """Return a trajectory from rest to rest, without acceleration at its ends, two steps longer than the rows.

    Args:
        rows: positions at even times, shape (k, n); the first and the last are where it begins and ends.
        step: time between two rows [s].
    """
    controls = np.concatenate([rows[:1], rows[:1], rows, rows[-1:], rows[-1:]])
    before, here, after = controls[:-2], controls[1:-1], controls[2:]
    positions = here + (before - 2.0 * here + after) / 6.0
    times: Array = np.arange(len(positions), dtype=np.float64) * np.float64(step)
    return Trajectory(names, times, positions, (after - before) / (2.0 * step), (before - 2.0 * here + after) / step**2)


def eased(names: tuple[str, ...], start: Array, goal: Array, duration: float) -> Trajectory:
    """Return a motion from rest to rest on a straight line in joint space, of a given duration [s].

    Its largest velocity is about 1.5 times the mean one.
    """
    count = max(2, int(np.ceil(duration / _STEP)))
    part = np.linspace(0.0, 1.0, count + 1)
    rows = start + np.outer(3 * part**2 - 2 * part**3, goal - start)
    rows[-1] = goal
    return smoothed(names, rows, duration / (count + 2))


def s_curve(times: Array, duration: float, corner: float) -> tuple[Array, Array, Array]:
    """Return the integral of an S that rises from 0 to 1 within a time, the S, and its slope, each shape (k,).

    Args:
        times: shape (k,), from 0; after `duration` it stays 1 [s].
        duration: of the S [s].
        corner: for how long its slope rises, and falls, evenly: at most half of `duration` [s].
    """
    t = np.minimum(times, duration)
    up, down = np.minimum(t, corner), np.maximum(t - (duration - corner), 0.0)
    level, scale = t - up, 1.0 / (duration - corner)
    whole = scale * ((up**3 - down**3) / (6 * corner) + level * corner / 2 + level**2 / 2)
    curve = scale * ((up**2 - down**2) / (2 * corner) + level)
    return whole + np.maximum(times - duration, 0.0), curve, scale * (up - down) / corner


def averaged(rows: Array, count: int) -> Array:
    """Return rows at even times, shape (k, n), each the mean of `count` of them, `count` - 1 rows longer.

    With accelerations within limits, no jerk is then above twice the limit by the time that so many rows take, and
    velocities and accelerations stay within theirs (moving averages as in Biagiotti and Melchiorri 2012).
    """
    more = count - 1
    padded = np.concatenate([np.repeat(rows[:1], count, axis=0), rows[1:], np.repeat(rows[-1:], more, axis=0)])
    sums = np.concatenate([np.zeros_like(rows[:1]), np.cumsum(padded - rows[0], axis=0)])
    means: Array = rows[0] + (sums[count:] - sums[:-count]) / count
    means[0], means[-1] = rows[0], rows[-1]
    return means


def peaks(trajectory: Trajectory) -> tuple[Array, Array, Array]:
    """Return the largest velocity, acceleration and jerk of each joint on cubics between points, each shape (n,)."""
    _, first, second, third = cubics(trajectory)
    steps = np.diff(trajectory.times)[:, None]
    last = second + third * steps
    with np.errstate(divide="ignore", invalid="ignore"):
        turning = np.where(second * last < 0, first - second**2 / (2.0 * third), 0.0)
    assert trajectory.velocities is not None
    velocity = np.maximum(_largest(trajectory.velocities), _largest(turning))
    return velocity, np.maximum(_largest(second), _largest(last)), _largest(third)


def cubics(trajectory: Trajectory) -> tuple[Array, Array, Array, Array]:
    """Return position, velocity, acceleration and jerk where each cubic between two points begins, shape (k - 1, n)."""
    assert trajectory.velocities is not None
    steps = np.diff(trajectory.times)[:, None]
    begin, end = trajectory.positions[:-1], trajectory.positions[1:]
    first, last = trajectory.velocities[:-1], trajectory.velocities[1:]
    mean = (end - begin) / steps
    return begin, first, (6.0 * mean - 4.0 * first - 2.0 * last) / steps, (first + last - 2.0 * mean) * 6.0 / steps**2


def slowed(trajectory: Trajectory, velocity: Array, acceleration: Array, jerk: Array | None = None) -> Trajectory:
    """Return the same path, as much slower as keeps limits, each shape (n,), on the cubics between points."""
    fastest, hardest, sharpest = peaks(trajectory)
    factor = max(1.0, float((fastest / velocity).max()), float((hardest / acceleration).max()) ** (1 / 2))
    if jerk is not None:
        factor = max(factor, float((sharpest / jerk).max()) ** (1 / 3))
    return trajectory if factor <= 1.0 else trajectory.stretched(trajectory.duration * factor * (1 + 1e-9))


def _largest(values: Array) -> Array:
    return np.abs(values).max(axis=0, initial=0.0)


def joined(pieces: list[Trajectory]) -> Trajectory:
    """Return trajectories of the same joints, each of which begins at rest where the one before ends, as one."""
    first, *more = pieces
    times, end = [first.times], first.duration
    for piece in more:
        times.append(piece.times[1:] + end)
        end += piece.duration
    rows = {
        name: np.concatenate([getattr(first, name), *(getattr(piece, name)[1:] for piece in more)])
        for name in ("positions", "velocities", "accelerations")
    }
    return Trajectory(first.names, np.concatenate(times), **rows)
