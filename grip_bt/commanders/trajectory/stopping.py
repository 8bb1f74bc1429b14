"""Coming to rest, and going on: along the path that was checked, within the joints' own limits.

Along a path q(s), followed at the rate r = ds/dt, a joint's acceleration is q'' r^2 + q' r', and its jerk is
q''' r^3 + 3 q'' r r' + q' r''. A ramp lowers r step by step, as hard as every joint's limits allow (path-velocity
scaling, Dahl and Nielsen 1990), and is looked at as a controller draws it: beyond a limit, less of it is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Trajectory

from .splines import peaks, s_curve

ACCELERATION = 2.0
"""Deceleration of a joint without a stated limit [rad/s^2 or m/s^2]."""
ANY = 1e6
"""Jerk of a joint without a stated limit [rad/s^3 or m/s^3]."""
LATER = 0.14
"""Coming to rest on the path may take this much longer than each joint takes by itself [s]."""
_STEP = 0.01
"""Time between two points of a ramp beside the path [s]."""
_SLOW = 1e-5
"""Joints slower than this [rad/s or m/s] are at rest."""
_PERIOD = 1e-3
"""Controllers take their set points at this period [s]."""
_USED, _TRIES = 0.97, 7
_GRID = 0.0025
"""Spacing of the places on a path at which the limits are looked at [s]."""
_SHORTEST, _LONGEST = 0.002, 0.005
"""Time of a step [s]."""
_FASTEST = 100.0
"""No rate changes quicker [1/s]: where joints hardly move that wouldn't brake them."""
_SAME = 1 + 1e-6
_SLIVER = 1e-6
"""No two points of a ramp are closer [s]."""
_RISES = np.geomspace(0.02, 2.0, 14)
"""Times to come up to a trajectory's own speed that are tried [s]."""


def accelerations_of(names: Sequence[str], limits: Mapping[str, float]) -> Array:
    """Return the acceleration limits of joints, shape (n,); `ACCELERATION` for those that `limits` doesn't name."""
    return np.array([limits.get(name, ACCELERATION) for name in names], dtype=float)


def jerks_of(names: Sequence[str], limits: Mapping[str, float]) -> Array | None:
    """Return the jerk limits of joints, shape (n,), `ANY` where `limits` has none; None where it has none at all."""
    if not any(name in limits for name in names):
        return None
    return np.array([limits.get(name, ANY) for name in names], dtype=float)


def stop_ramp(trajectory: Trajectory, time: float, acceleration: Array, jerk: Array | None = None) -> Trajectory:
    """Return how a motion comes to rest from a moment on: on its own path, which was checked to be free.

    A path that is itself beyond the limits, or can't be braked on in time, is left as `even_ramp` does.

    Args:
        trajectory: what is followed, interpolated as `Trajectory.sampled` does.
        time: for how long it has been followed [s]; the ramp's times begin there.
        acceleration: limits of its joints, shape (n,) [rad/s^2 or m/s^2].
        jerk: likewise [rad/s^3 or m/s^3]; None for any.
    """
    position, velocity, now = trajectory.sampled(np.array([time]))
    moves = jerk is not None or np.abs(velocity).max() >= _SLOW
    ramp = (
        _smooth_stop(trajectory, time, acceleration, np.full(len(now[0]), ANY) if jerk is None else jerk)
        if moves
        else None
    )
    return ramp or even_ramp(trajectory.names, position[0], velocity[0], acceleration, jerk, now[0])


def even_ramp(
    names: Sequence[str],
    position: Array,
    velocity: Array,
    acceleration: Array,
    jerk: Array | None = None,
    now: Array | None = None,
) -> Trajectory:
    """Return how joints come to rest from a position and a velocity, all at the same moment; each shape (n,).

    With limits of jerk, each comes to rest from the acceleration that it has `now` as soon as its own limits allow.
    """
    if jerk is not None:
        return each_by_itself(names, position, velocity, 0.0 * velocity if now is None else now, acceleration, jerk)
    if np.abs(velocity).max() < _SLOW:
        return Trajectory(tuple(names), np.zeros(1), position[None], np.zeros((1, len(position))))
    braking = float((np.abs(velocity) / (0.98 * acceleration)).max())
    times = np.linspace(0.0, braking, max(2, int(np.ceil(braking / _STEP)) + 1))
    return Trajectory(
        tuple(names),
        times,
        position + np.outer(times - times**2 / (2 * braking), velocity),
        np.outer(1.0 - times / braking, velocity),
    )


def braking_times(velocity: Array, now: Array, acceleration: Array, jerk: Array) -> Array:
    """Return how long each joint by itself takes to rest [s]; each shape (n,)."""
    return _phases(velocity, now, acceleration, jerk)[0].sum(axis=0)


def _phases(velocity: Array, now: Array, acceleration: Array, jerk: Array) -> tuple[Array, Array]:
    """Return for how long a jerk, none, and the opposite one bring joints to rest, shape (3, n), and the first jerk."""
    against = np.where(velocity + now * np.abs(now) / (2 * jerk) < 0, 1.0, -1.0)
    left = np.maximum(now**2 / (2 * jerk) - against * velocity, 0.0)  # to be braked once the acceleration is 0
    most = np.minimum(np.sqrt(jerk * left), acceleration)
    first = np.maximum(most - against * now, 0.0) / jerk
    return np.stack([first, (left - most**2 / jerk) / acceleration, most / jerk]), against * jerk


def each_by_itself(
    names: Sequence[str], position: Array, velocity: Array, now: Array, acceleration: Array, jerk: Array
) -> Trajectory:
    """Return how joints come to rest, each as soon as its own limits allow; arrays as for `braking_times`."""
    most = np.maximum(acceleration * 0.999, np.abs(now))  # between points an acceleration may rise a little
    phases, first = _phases(velocity, now, most, jerk * 0.99)
    ends = np.cumsum(phases, axis=0)
    times = np.unique(np.concatenate([np.arange(0.0, ends[-1].max(), 0.01), ends.ravel()]))
    times = times[np.append(True, np.diff(times) > _SLIVER)]
    p, v, a = (np.tile(row, (len(times), 1)) for row in (position, velocity, now))
    begin = np.zeros_like(ends[0])
    for end, sharp in zip(ends, (first, 0.0 * first, -first), strict=True):
        passed = np.clip(times[:, None] - begin, 0.0, end - begin)
        p, v, a = (
            p + v * passed + a * passed**2 / 2 + sharp * passed**3 / 6,
            v + a * passed + sharp * passed**2 / 2,
            (a + sharp * passed),
        )
        begin = end
    v[-1] = a[-1] = 0.0
    return Trajectory(tuple(names), times, p, v, a)


def excess(trajectory: Trajectory, acceleration: Array, jerk: Array) -> tuple[float, float]:
    """Return the largest acceleration and jerk over their limits on the quintics between a trajectory's points."""
    _, _, found = trajectory.sampled(np.arange(0.0, trajectory.duration, _PERIOD))
    sharpest = np.abs(quintic_jerks(trajectory)) / jerk
    return float((np.abs(found) / acceleration).max(initial=0.0)), float(sharpest.max(initial=0.0))


def quintic_jerks(trajectory: Trajectory) -> Array:
    """Return the jerks where each quintic begins, in its middle, and where it ends, shape (3, k - 1, n)."""
    assert trajectory.velocities is not None
    assert trajectory.accelerations is not None
    step = np.diff(trajectory.times)[:, None]
    way, (v0, v1) = np.diff(trajectory.positions, axis=0), (trajectory.velocities[:-1], trajectory.velocities[1:])
    a0, a1 = trajectory.accelerations[:-1], trajectory.accelerations[1:]
    even = 60 * way - 30 * step * (v0 + v1)
    begin = even - 6 * step * (v0 - v1) - step**2 * (9 * a0 - 3 * a1)
    end = even + 6 * step * (v0 - v1) + step**2 * (9 * a1 - 3 * a0)
    middle = -even / 2 + 1.5 * step**2 * (a0 - a1)
    return np.stack([begin, middle, end]) / step**3


def _smooth_stop(trajectory: Trajectory, time: float, acceleration: Array, jerk: Array) -> Trajectory | None:
    """Return how a motion comes to rest on its path from a moment on; None where the path itself breaks the limits."""
    _, velocity, now = trajectory.sampled(np.array([time]))
    soonest = float(braking_times(velocity[0], now[0], acceleration, jerk).max())
    within, left = soonest + LATER, trajectory.duration - time
    part = _USED
    for _ in range(_TRIES if left > soonest + 0.02 else 0):
        ramp = _at_rates(trajectory, time, _Slowing(trajectory, time, acceleration * part, jerk * part, within).rates())
        over = _over(ramp, acceleration, jerk)
        if over <= _SAME:
            return ramp if ramp.duration <= within else None
        part /= min(over, 1.05) * 1.01
    if not _SLIVER < left <= within:
        return None
    times = _apart(trajectory.times - time, left)
    ramp = _at_rates(trajectory, time, _Rates(times, times, np.ones_like(times), np.zeros_like(times)))
    return ramp if _over(ramp, acceleration, jerk) <= _SAME else None


def _over(ramp: Trajectory, acceleration: Array, jerk: Array) -> float:
    """Return the largest part of the limits; without limits of jerk on the cubics of a controller too."""
    cubic = peaks(ramp)[1] / acceleration if jerk.min() >= ANY else np.zeros(1)
    return max(*excess(ramp, acceleration, jerk), float(cubic.max(initial=0.0)))


def _apart(times: Array, end: float) -> Array:
    """Return 0, those of the times that are between it and the end, and that."""
    return np.concatenate([[0.0], times[(times > _SHORTEST) & (times < end - _SHORTEST)], [end]])


def smooth_start(trajectory: Trajectory, begin: float, acceleration: Array, jerk: Array) -> Trajectory:
    """Return how a trajectory is followed from rest at a moment on to its end; arguments as for `smooth_stop`.

    The rate rises in an S from 0 to 1, and all of it is as much slower as the limits ask for: the S that is over first.
    """
    if trajectory.duration - begin <= _SLIVER:
        still = np.zeros((1, len(trajectory.names)))
        return Trajectory(trajectory.names, np.zeros(1), trajectory.positions[-1:], still, still)
    tried = (_at_rates(trajectory, begin, _rising(trajectory, begin, rise)) for rise in _RISES)
    return min((eased_down(one, acceleration, jerk) for one in tried), key=lambda one: one.duration)


def eased_down(trajectory: Trajectory, acceleration: Array, jerk: Array) -> Trajectory:
    """Return a trajectory from rest to rest, as much slower as keeps to limits, each shape (n,).

    Accelerations are within theirs on cubics between the points too: not every controller takes accelerations.
    """
    for _ in range(3):
        hardest, sharpest = excess(trajectory, acceleration, jerk)
        hardest = max(hardest, float((peaks(trajectory)[1] / acceleration).max(initial=0.0)))
        if max(hardest, sharpest) <= _SAME:
            break
        factor = max(hardest ** (1 / 2), sharpest ** (1 / 3))
        trajectory = trajectory.stretched(trajectory.duration * factor * 1.001)
    return trajectory


def _rising(trajectory: Trajectory, begin: float, rise: float) -> _Rates:
    left = trajectory.duration - begin
    times = np.linspace(0.0, rise, 3 * int(np.ceil(rise / 0.03)) + 1)  # the jerk changes where points are
    places, _, _ = s_curve(times, rise, rise / 3)
    rows = places[-1] + _apart(trajectory.times - begin - places[-1], left - places[-1])[1:]
    if places[-1] > left - _SHORTEST:
        fine = np.linspace(0.0, 2.0 * rise, 4000)
        end = float(np.interp(left, s_curve(fine, rise, rise / 3)[0], fine))
        times, rows = times[times < end - _SHORTEST], np.array([])
        times = np.append(times, end)
    times = np.concatenate([times, rise + rows - rise / 2])
    places, rates, gains = s_curve(times, rise, rise / 3)
    return _Rates(times, places, rates, -gains)


class _Rates(NamedTuple):
    """How a path is followed: times, places on it from where that begins, rates there, and what these lose [1/s]."""

    times: Array
    places: Array
    rates: Array
    losses: Array


def _at_rates(trajectory: Trajectory, begin: float, rates: _Rates) -> Trajectory:
    positions, velocities, accelerations = trajectory.sampled(np.minimum(begin + rates.places, trajectory.duration))
    r, loss = rates.rates[:, None], rates.losses[:, None]
    accelerations = accelerations * r**2 - velocities * loss
    velocities = velocities * r
    velocities[-1] = accelerations[-1] = 0.0
    return Trajectory(trajectory.names, rates.times, positions, velocities, accelerations)


class _Slowing:
    """Lowers the rate at which a path is followed from 1 to 0."""

    def __init__(self, trajectory: Trajectory, begin: float, acceleration: Array, jerk: Array, within: float):
        self._left, self._within = trajectory.duration - begin, within
        self._knots = np.append(trajectory.times[trajectory.times > begin] - begin, np.inf)
        self._grid = np.arange(0.0, min(within, self._left) + 0.1, _GRID)
        _, first, second = trajectory.sampled(begin + self._grid)
        third = np.diff(second, axis=0, append=second[-1:]) / _GRID
        size = np.maximum(np.abs(first), acceleration / _FASTEST)
        sign = np.where(first < 0, -1.0, 1.0)
        self._jerk, self._acceleration = jerk / size, acceleration / size
        self._second, self._third = sign * second / size, sign * third / size
        shortest = float((acceleration / jerk).min())
        self._step = float(np.clip(shortest / 4, _SHORTEST, _LONGEST))
        self._ahead = int(np.ceil(1.5 * float((acceleration / jerk).max()) / _GRID)) + 2

    def rates(self) -> _Rates:
        """Return the rates until the joints rest, or the time is over."""
        time, place, rate, loss = 0.0, 0.0, 1.0, 0.0
        rows = [(time, place, rate, loss)]
        while time < self._within and place < self._left - 1e-9:
            first = min(int(place / _GRID), len(self._grid) - 1)
            ahead = slice(first, first + self._ahead)
            weakest = float(self._jerk[ahead].min())
            if loss > 0 and (loss**2 >= 1.6 * weakest * rate or loss * self._step >= rate / 2):
                rows += self._last(*rows[-1])
                break
            step = self._step_from(place, rate, loss)
            lower = self._lower(ahead, weakest, place, rate, loss, step)
            change = (lower - loss) / step
            place = min(place + (rate - (loss / 2 + change * step / 6) * step) * step, self._left)
            rate, loss, time = rate - (loss + lower) / 2 * step, lower, time + step
            rows.append((time, place, rate, loss))
        return _Rates(*np.array(rows).T)

    def _step_from(self, place: float, rate: float, loss: float) -> float:
        """Return how long the next step takes [s]: to the next point of the trajectory, where that is near."""
        knot = self._knots[np.searchsorted(self._knots, place + _SHORTEST * max(rate, 0.1))] - place
        step = knot / rate
        step = float(knot / max(rate - loss * step / 2, 1e-3)) if np.isfinite(step) else self._step
        return step if step < 1.4 * self._step else self._step

    def _lower(self, ahead: slice, weakest: float, place: float, rate: float, loss: float, step: float) -> float:
        """Return what the rate may lose after a step [1/s]."""
        near = slice(ahead.start, ahead.start + 2 + int(rate * step / _GRID))
        taken = self._third[near] * rate**3 - 3 * self._second[near] * rate * loss
        least, most = (taken - self._jerk[near]).max(), (taken + self._jerk[near]).min()
        soon = max(rate - 0.02 * loss, 0.0)
        curved = np.minimum(self._second[ahead] * rate**2, self._second[ahead] * soon**2)
        allowed = (self._acceleration[ahead] + curved).min(axis=1)
        falls = 0.8 * weakest * np.maximum(self._grid[ahead] - self._grid[ahead.start] - rate * step, 0.0)
        ending = np.sqrt(1.8 * weakest * max(rate - loss * step, 0.0))
        wanted = max(0.0, min(float((allowed + falls).min()), float(ending)))
        return max(0.0, loss + step * float(min(max((wanted - loss) / step, least), most)))

    def _last(self, time: float, place: float, rate: float, loss: float) -> list[tuple[float, float, float, float]]:
        """Return how the rate comes to 0, together with what it loses."""
        lasts = 2 * rate / loss
        count = max(1, int(np.ceil(lasts / self._step)))
        parts = np.arange(1, count + 1) / count
        left = 1.0 - parts
        places = place + rate * lasts * (1 - left**3) / 3
        return list(zip(time + lasts * parts, places, rate * left**2, loss * left, strict=True))
