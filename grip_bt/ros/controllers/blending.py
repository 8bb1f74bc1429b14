"""How a controller goes over from one motion to a changed one, whenever it hears of the change.

A joint trajectory controller of ros2_control that gets a goal while it follows another one gives that up and goes, by
the cubic with the position and the velocity that the joints have then, to the first point of the new one, timed from
when the goal came (`Trajectory::sample` of joint_trajectory_controller, for points with velocities and no
accelerations). Nobody knows when that is: messages take as long as they take. So the first point is chosen so that the
joints go back from nowhere where they may be by then, be it the place where the motion before has come to rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.values import Trajectory

Array = NDArray[np.float64]
EVEN = 1e-3
"""Joints may go so fast where neither motion does [rad/s], or a tenth faster than both."""
ASIDE = 0.01
"""On their way to the first point joints are so near to the paths of the motion before and after [rad or m]."""
SOONEST = 0.02
"""The first point is due no sooner after the goal came [s]."""
_WAY = np.linspace(0.0, 1.0, 9)[1:]
_FEW = 16
"""So many of the places from which joints may be under way stand for all of them."""


class Places(NamedTuple):
    """Where joints may be, and how fast.

    Attributes:
        times: of the motion [s], shape (m,).
        positions: shape (m, n).
        velocities: shape (m, n).
    """

    times: Array
    positions: Array
    velocities: Array

    def since(self, time: float) -> Places:
        """Return those of a time [s] and later."""
        kept = self.times >= time
        return Places(*(values[kept] for values in self))

    def few(self) -> Places:
        """Return some, from the first to the last."""
        order = np.argsort(self.times, kind="stable")
        kept = order[np.unique(np.linspace(0, len(order) - 1, _FEW).round().astype(int))]
        return Places(*(values[kept] for values in self))

    def and_those(self, others: Places) -> Places:
        """Return these and others."""
        return Places(*(np.concatenate(both) for both in zip(self, others, strict=True)))


@dataclass(frozen=True)
class Change:
    """A goal that takes the place of the one before.

    Attributes:
        whole: the motion from its beginning, as it is to be.
        row: of its points, the goal's first one.
        ahead: how long after the goal came that is due [s].
        underway: where joints may be before they are there.
    """

    whole: Trajectory
    row: int
    ahead: float
    underway: Places

    @property
    def began(self) -> float:
        """When the motion would have begun, had all of it been timed as the goal is; from when the goal came [s]."""
        return self.ahead - float(self.whole.times[self.row])

    @property
    def rest(self) -> Trajectory:
        """The goal's points, the first of them at 0."""
        whole, row = self.whole, self.row
        velocities = None if whole.velocities is None else whole.velocities[row:]
        return Trajectory(whole.names, whole.times[row:] - whole.times[row], whole.positions[row:], velocities)


def places(trajectory: Trajectory, time: float) -> Places:
    """Return where the joints of a motion may be at a time [s] or later; its points have velocities."""
    assert trajectory.velocities is not None
    later = trajectory.times > time
    now = np.array([np.interp(time, trajectory.times, column) for column in trajectory.velocities.T])
    return Places(
        np.array([time, *trajectory.times[later]]),
        np.vstack([trajectory.at(time), trajectory.positions[later]]),
        np.vstack([now, trajectory.velocities[later]]),
    )


def change(possible: Places, before: Trajectory, whole: Trajectory, time: float) -> Change | None:
    """Return the goal by which a motion is changed; None, where the joints might go back or aside by any.

    Args:
        possible: where the joints may be when the goal comes.
        before: the motion as it has been until now.
        whole: the motion as it is to be; its points have velocities.
        time: of the motion when the goal is likely to come [s]; where it comes then, the motion goes on in time.
    """
    since = float(possible.times.min())
    assert whole.velocities is not None
    both = np.vstack([possible.velocities, whole.velocities[whole.times >= since]])
    slowest, fastest = 1.1 * np.minimum(0, both.min(axis=0)) - EVEN, 1.1 * np.maximum(0, both.max(axis=0)) + EVEN
    for row in np.flatnonzero(whole.times >= time + SOONEST):
        ahead = float(whole.times[row]) - time
        end, speed = whole.positions[row], whole.velocities[row]
        low, high = extremes(possible, end, speed, ahead)
        if (low >= slowest).all() and (high <= fastest).all():
            underway = _underway(possible.few(), end, speed, time, ahead)
            aside = np.minimum(*(_aside(underway.positions, path, since) for path in (before, whole)))
            near = aside.max() <= ASIDE
            return Change(whole, int(row), ahead, underway) if near else None
    return None


def extremes(begin: Places, end: Array, speed: Array, duration: float) -> tuple[Array, Array]:
    """Return the least and the greatest velocities on cubics from places to one place, each shape (m, n)."""
    mean = (end - begin.positions) / duration
    first, last = begin.velocities, np.broadcast_to(speed, begin.velocities.shape)
    # Of velocity = first + 2 b s + 3 c s^2 for s from 0 to 1, where b and c are of the Hermite form:
    b, c = 3 * mean - 2 * first - last, first + last - 2 * mean
    with np.errstate(divide="ignore", invalid="ignore"):
        at = -b / (3 * c)
    inside = np.isfinite(at) & (at > 0) & (at < 1)
    at = np.where(inside, at, 0.0)
    turning = np.where(inside, first + 2 * b * at + 3 * c * at**2, first)
    return np.minimum(turning, np.minimum(first, last)), np.maximum(turning, np.maximum(first, last))


def _underway(begin: Places, end: Array, speed: Array, time: float, duration: float) -> Places:
    """Return places on the cubics, by the time that the goal says."""
    part = _WAY[:, None, None]
    mean = (end - begin.positions) / duration
    b, c = 3 * mean - 2 * begin.velocities - speed, begin.velocities + speed - 2 * mean
    positions = begin.positions + duration * (part * begin.velocities + part**2 * b + part**3 * c)
    velocities = begin.velocities + 2 * part * b + 3 * part**2 * c
    times = np.repeat(time + _WAY * duration, len(begin.times))
    shape = (len(times), begin.positions.shape[1])
    return Places(times, positions.reshape(shape), velocities.reshape(shape))


def _aside(positions: Array, trajectory: Trajectory, time: float) -> Array:
    """Return how far each of m positions is from what is left of a path, in its furthest joint [rad or m]."""
    path = places(trajectory, time).positions
    first, along = path[:-1], np.diff(path, axis=0)
    away = positions[:, None] - first
    length = (along**2).sum(axis=1)
    part = np.clip((away * along).sum(axis=2) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    aside: Array = np.abs(away - part[..., None] * along).max(axis=2).min(axis=1, initial=np.inf)
    return aside
