"""Coming to rest: along the path that was checked, as hard as the joints' own limits allow.

Along a path q(s), followed at the rate r = ds/dt (1 as planned), a joint's acceleration is q''(s) r^2 + q'(s) dr/dt. So
what each joint has left bounds dr/dt, and the strictest joint decides. Where the path is within the limits, dr/dt = 0
always is: there is no dead end. This is path-velocity scaling (Dahl and Nielsen 1990), with TOPP-RA's bounds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Trajectory

from .jerk_limited import each_by_itself, smooth_stop
from .splines import peaks

ACCELERATION = 2.0
"""Of a joint whose limit nobody says [rad/s^2 or m/s^2]."""
LATER = 0.1
"""Coming to rest on the path may take so much longer than beside it [s]; only a path beyond the limits takes more."""
STEP = 0.01
"""Time between two points of a ramp [s]."""
_TRIES = 4
"""So often a ramp is made gentler because what is drawn between its points is beyond the limits."""
_USED = 0.98
"""Part of the limits that is used to brake: what is drawn between two points swings a little past."""
_SLOW = 1e-5
"""Joints slower than this [rad/s or m/s] are at rest."""
_GRID = 0.0025
"""Spacing of the places on a path at which the limits are looked at [s]."""
_ANY = 1e3
"""How quickly a rate may change where no joint moves [1/s]."""


def accelerations_of(names: Sequence[str], limits: Mapping[str, float]) -> Array:
    """Return the acceleration limits of joints, shape (n,); `ACCELERATION` for those that `limits` doesn't name."""
    return np.array([limits.get(name, ACCELERATION) for name in names], dtype=float)


def stop_ramp(trajectory: Trajectory, time: float, acceleration: Array, jerk: Array | None = None) -> Trajectory:
    """Return how a motion comes to rest from a moment on: on its own path, which was checked to be free.

    A path that is itself beyond the limits, or can't be braked on in time, is left: all joints brake evenly, each
    within its limit, and are at rest together; with limits of jerk, each as soon as its own allow.

    Args:
        trajectory: what is followed, interpolated as `Trajectory.sampled` does.
        time: for how long it has been followed [s]; the ramp's times begin there.
        acceleration: limits of its joints, shape (n,) [rad/s^2 or m/s^2].
        jerk: likewise [rad/s^3 or m/s^3]; None for any.

    Returns:
        Positions and velocities, `STEP` apart; it begins with those of the motion, and its last velocities are 0. With
        limits of jerk it has accelerations too, which begin with those of the motion.
    """
    position, velocity, now = trajectory.sampled(np.array([time]))
    if jerk is not None:
        ramp = smooth_stop(trajectory, time, acceleration, jerk)
        return ramp or each_by_itself(trajectory.names, position[0], velocity[0], now[0], acceleration, jerk)
    evenly = even_ramp(trajectory.names, position[0], velocity[0], acceleration)
    if np.abs(velocity).max() < _SLOW:
        return evenly
    limit = acceleration
    for _ in range(_TRIES):
        along = _along(trajectory, time, limit, evenly.duration + LATER)
        if along.duration > evenly.duration + LATER:
            return evenly
        over = float((peaks(along)[1] / acceleration).max())
        if over <= 1.0:
            return along
        limit = limit / (over * 1.005)
    return evenly


def even_ramp(
    names: Sequence[str], position: Array, velocity: Array, acceleration: Array, jerk: Array | None = None
) -> Trajectory:
    """Return how joints come to rest from a position and a velocity, all at the same moment; each shape (n,).

    With limits of jerk, each comes to rest as soon as its own limits allow.
    """
    if jerk is not None:
        return each_by_itself(names, position, velocity, np.zeros_like(velocity), acceleration, jerk)
    braking = float((np.abs(velocity) / (_USED * acceleration)).max())
    if np.abs(velocity).max() < _SLOW:
        return Trajectory(tuple(names), np.zeros(1), position[None], np.zeros((1, len(position))))
    times = np.linspace(0.0, braking, max(2, int(np.ceil(braking / STEP)) + 1))
    return Trajectory(
        tuple(names),
        times,
        position + np.outer(times - times**2 / (2 * braking), velocity),
        np.outer(1.0 - times / braking, velocity),
    )


def _along(trajectory: Trajectory, begin: float, acceleration: Array, within: float) -> Trajectory:
    """Return how a trajectory comes to rest on its path from a moment on [s], as quickly as may be.

    Args:
        acceleration: limits of its joints, shape (n,) [rad/s^2 or m/s^2].
        within: time that this may take [s]; it goes on at the rate that is reached then.
    """
    where, rates, times = [begin], [1.0], [0.0]
    left = _Left(trajectory, begin, min(begin + within, trajectory.duration), acceleration * _USED)
    while rates[-1] > 0 and where[-1] < trajectory.duration - 1e-9 and times[-1] <= within:
        s, r = where[-1], rates[-1]
        loss = left.hardest(s, r)
        needed = r / max(loss, 1e-12)
        last = needed <= 1.5 * STEP  # no sliver: two points that are too close make a rough spline
        step = max(needed, STEP / 2) if last else STEP
        slower = 0.0 if last else r - loss * step
        ahead = trajectory.duration - s
        if (r + slower) * step > 2 * ahead - r * STEP:
            step = 2 * ahead / (r + slower)
            where.append(trajectory.duration)
        else:
            where.append(s + (r + slower) / 2 * step)
        rates.append(slower)
        times.append(times[-1] + step)
    positions, velocities, _ = trajectory.sampled(np.array(where))
    velocities = velocities * np.array(rates)[:, None]
    if where[-1] >= trajectory.duration - 1e-9:
        velocities[-1] = 0.0
    return Trajectory(trajectory.names, np.array(times), positions, velocities)


class _Left:
    """What joints have left along a piece of a path."""

    def __init__(self, trajectory: Trajectory, begin: float, end: float, limit: Array):
        self._begin, self._last = begin, max(1, int(np.ceil((end - begin) / _GRID)))
        _, velocity, curving = trajectory.sampled(np.array([begin + _GRID * k for k in range(self._last + 1)]))
        moving = np.abs(velocity) > _SLOW
        size = np.where(moving, np.abs(velocity), 1.0)
        self._limit = np.where(moving, limit / size, _ANY)
        self._taken = np.where(moving, -curving * np.sign(velocity) / size, 0.0)

    def hardest(self, s: float, r: float) -> float:
        """Return how quickly the rate may fall over the next step, whatever it is then; at least 0 [1/s]."""
        first = min(round((s - self._begin) / _GRID), self._last)
        rows = slice(first, min(first + 2 + round(r * STEP / _GRID), self._last + 1))
        limit, taken = self._limit[rows], self._taken[rows]
        now = float((limit - taken * r * r).min())
        then = min(max(0.0, r - STEP * now), 1.0)
        return max(0.0, min(now, float((limit - taken * then * then).min())))
