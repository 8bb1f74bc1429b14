"""One motion as a trajectory controller follows it: in goals, each of which replaces the one before.

A motion is changed by sending the rest of it, timed from when it comes. No clocks have to agree for that, and no
message lets the joints go back, however late it is: they are slower, or at rest, until it comes.

A joint trajectory controller of ros2_control that gets a goal while it follows another one gives that up and goes, by
the cubic with the position and the velocity that the joints have then, to the first point of the new one, timed from
when the goal came (`Trajectory::sample` of joint_trajectory_controller, for points with velocities and no
accelerations). Nobody knows when that is: messages take as long as they take. So the first point is chosen so that the
joints go back from nowhere where they may be by then, be it the place where the motion before has come to rest.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from grip_bt.base.failures import ExecutionAbortedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Trajectory
from grip_bt.commanders.steering import spliced

from ..client.goal import GoalEnd

LATEST = 0.03
"""A motion can be changed until so long before the change takes effect [s]."""
USUAL = 0.01
"""A goal is reckoned with to take no more than this [s]: one that came sooner would make the joints too fast."""
KEPT = 10
"""So many of the last goals tell how long a goal takes until it is accepted."""

Send = Callable[[Trajectory, float, Callable[[], None]], Operation[GoalEnd]]
"""Trajectory, how long after now its first point is reached [s], what is called when it was accepted -> the goal."""


class Clock:
    """A steady clock, and what happens later."""

    def now(self) -> float:
        """Return the time [s]."""
        return time.monotonic()

    def after(self, delay: float, action: Callable[[], None]) -> None:
        """Call `action()` when `delay` [s] has passed, on a thread of its own; at once where that is now."""
        if delay <= 0:
            action()
            return
        timer = threading.Timer(delay, action)
        timer.daemon = True
        timer.start()


class Following:
    """A motion under way.

    Attributes:
        whole: ends as the last goal does.
        replaceable: False once the controller has refused a goal while it followed another one.
    """

    def __init__(self, send: Send, trajectory: Trajectory, clock: Clock | None = None):
        self._send, self._trajectory, self._clock = send, trajectory, clock or Clock()
        self._lock = threading.RLock()
        self._sent = 0.0
        self._began: float | None = None
        """When the motion has begun at the latest: never before the controller began, but soon after."""
        self._delays: deque[float] = deque(maxlen=KEPT)
        self._blends: Samples | None = None
        self._goals: list[Operation[GoalEnd]] = []
        self._waiting: GoalReplacement | None = None
        self._flying: GoalReplacement | None = None
        self.replaceable = True
        self.whole: Operation[GoalEnd] = Operation(on_cancel=self._cancel)

    def begin(self) -> None:
        """Send the first goal."""
        self._sent = self._clock.now()
        goal = self._send(self._trajectory, 0.0, self._accepted)
        self._goals.append(goal)
        self._watch(goal)

    def passed(self) -> float | None:
        """Return for how long it has been followed [s]; None when it has ended, or can't be changed."""
        with self._lock:
            if self.whole.done() or not self.replaceable:
                return None
            return 0.0 if self._began is None else self._clock.now() - self._began

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`.

        False, too, where the points have no velocities, or the joints might go back if the goal were late.
        """
        with self._lock:
            passed = self.passed()
            if passed is None or self._began is None or self._waiting or self._flying:
                return False  # a change whose acceptance isn't heard of yet: `tail` goes on with what isn't known here
            whole = spliced(self._trajectory, tail, at)
            if whole.velocities is None or self.whole.cancel_asked or passed > at - LATEST:
                return False
            # Soon enough to be there in time; sooner would let a late goal find the joints further from where it goes.
            begin = max(passed, at - LATEST - 2 * max(self._delays))
            possible = places(self._trajectory, begin)
            if self._blends is not None:
                possible = np.vstack([possible, self._blends[self._blends[:, 0] >= begin]])
            likely = begin + min(USUAL, *self._delays)
            found = change(possible, self._trajectory, whole, likely) or change(
                possible, self._trajectory, whole, begin
            )
            if found is None:
                return False
            self._waiting = found
        self._clock.after(begin - passed, partial(self._replace, found))
        return True

    def _replace(self, found: GoalReplacement) -> None:
        with self._lock:
            if self._waiting is not found or self.whole.done() or self.whole.cancel_asked:
                return
            self._waiting, self._flying = None, found
            self._sent = self._clock.now()
            goal = self._send(found.rest, found.ahead, partial(self._replaced, found))
            self._goals.append(goal)
        self._watch(goal)

    def _watch(self, goal: Operation[GoalEnd]) -> None:
        goal.add_done_callback(partial(self._ended, goal))
        if self.whole.cancel_asked:
            goal.cancel()

    def _accepted(self) -> None:
        with self._lock:
            self._began = self._clock.now()
            self._delays.append(self._began - self._sent)

    def _replaced(self, found: GoalReplacement) -> None:
        with self._lock:
            now = self._clock.now()
            self._delays.append(now - self._sent)
            self._trajectory, self._began, self._blends = found.whole, now + found.began, found.underway
            self._flying = None

    def _cancel(self) -> None:
        with self._lock:
            goals, self._waiting = list(self._goals), None
        for goal in reversed(goals):
            goal.cancel()

    def _ended(self, goal: Operation[GoalEnd]) -> None:
        """End with the last goal; the one before stands where the controller didn't let it be replaced."""
        with self._lock:
            if goal is not self._goals[-1]:
                return
            if len(self._goals) > 1 and _was_rejected(goal):
                self.replaceable, self._flying = False, None
                self._goals.pop()
                goal = self._goals[-1]
                if not goal.done():
                    return
            late = self._waiting
        try:
            end = goal.result()
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            self.whole.fail(error)
            return
        if late is not None:  # the joints are at rest before the change was sent
            self._replace(late)
        else:
            self.whole.succeed(end)


def _was_rejected(goal: Operation[GoalEnd]) -> bool:
    try:
        goal.result()
    except ExecutionAbortedError as error:
        return bool(error.data.get("cause") == "rejected")
    except BaseException:  # noqa: BLE001 - any other end is told as the motion's
        return False
    return False


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


Samples = Array
"""Where joints may be, and how fast: rows of a time of the motion [s], n positions and n velocities."""


@dataclass(frozen=True)
class GoalReplacement:
    """A goal that takes the place of the one before.

    Attributes:
        whole: the motion from its beginning, as it is to be.
        rest: the goal's points, the first of them at 0.
        ahead: how long after the goal came that is due [s].
        began: when the motion would have begun, had all of it been timed as the goal is; from when the goal came [s].
        underway: where joints may be before they are there.
    """

    whole: Trajectory
    rest: Trajectory
    ahead: float
    began: float
    underway: Samples


def places(trajectory: Trajectory, time: float) -> Samples:
    """Return where the joints of a motion may be at a time [s] or later; its points have velocities."""
    assert trajectory.velocities is not None
    rows = np.column_stack([trajectory.times, trajectory.positions, trajectory.velocities])
    speed = [np.interp(time, trajectory.times, column) for column in trajectory.velocities.T]
    return np.vstack([[time, *trajectory.at(time), *speed], rows[trajectory.times > time]])


def change(possible: Samples, before: Trajectory, whole: Trajectory, time: float) -> GoalReplacement | None:
    """Return the goal by which a motion is changed; None, where the joints might go back or aside by any.

    Args:
        possible: where the joints may be when the goal comes.
        before: the motion as it has been until now.
        whole: the motion as it is to be; its points have velocities.
        time: of the motion when the goal is likely to come [s]; where it comes then, the motion goes on in time.
    """
    since, n = float(possible[:, 0].min()), len(whole.names)
    assert whole.velocities is not None
    both = np.vstack([possible[:, 1 + n :], whole.velocities[whole.times >= since]])
    slowest, fastest = 1.1 * np.minimum(0, both.min(axis=0)) - EVEN, 1.1 * np.maximum(0, both.max(axis=0)) + EVEN
    for row in np.flatnonzero(whole.times >= time + SOONEST):
        due = float(whole.times[row])
        ahead, end, speed = due - time, whole.positions[row], whole.velocities[row]
        low, high = extremes(possible, end, speed, ahead)
        if (low >= slowest).all() and (high <= fastest).all():
            order = possible[np.argsort(possible[:, 0], kind="stable")]
            few = order[np.unique(np.linspace(0, len(order) - 1, _FEW).round().astype(int))]
            underway = _underway(few, end, speed, time, ahead)
            aside = np.minimum(*(_aside(underway[:, 1 : 1 + n], path, since) for path in (before, whole)))
            if aside.max() > ASIDE:
                return None
            rest = Trajectory(whole.names, whole.times[row:] - due, whole.positions[row:], whole.velocities[row:])
            return GoalReplacement(whole, rest, ahead, ahead - due, underway)
    return None


def extremes(begin: Samples, end: Array, speed: Array, duration: float) -> tuple[Array, Array]:
    """Return the least and the greatest velocities on cubics from places to one place, each shape (m, n)."""
    positions, first = np.split(begin[:, 1:], 2, axis=1)
    mean, last = (end - positions) / duration, np.broadcast_to(speed, first.shape)
    # Of velocity = first + 2 b s + 3 c s^2 for s from 0 to 1, where b and c are of the Hermite form:
    b, c = 3 * mean - 2 * first - last, first + last - 2 * mean
    with np.errstate(divide="ignore", invalid="ignore"):
        at = -b / (3 * c)
    inside = np.isfinite(at) & (at > 0) & (at < 1)
    at = np.where(inside, at, 0.0)
    turning = np.where(inside, first + 2 * b * at + 3 * c * at**2, first)
    return np.minimum(turning, np.minimum(first, last)), np.maximum(turning, np.maximum(first, last))


def _underway(begin: Samples, end: Array, speed: Array, time: float, duration: float) -> Samples:
    """Return places on the cubics, by the time that the goal says."""
    positions, velocities = np.split(begin[:, 1:], 2, axis=1)
    ends = np.broadcast_to(end, positions.shape), np.broadcast_to(speed, positions.shape)
    path = CubicHermiteSpline([0.0, duration], (positions, ends[0]), (velocities, ends[1]))
    at, shape = _WAY * duration, (-1, positions.shape[1])
    return np.column_stack([np.repeat(time + at, len(begin)), path(at).reshape(shape), path(at, nu=1).reshape(shape)])


def _aside(positions: Array, trajectory: Trajectory, time: float) -> Array:
    """Return how far each of m positions is from what is left of a path, in its furthest joint [rad or m]."""
    path = places(trajectory, time)[:, 1 : 1 + positions.shape[1]]
    first, along = path[:-1], np.diff(path, axis=0)
    away = positions[:, None] - first
    length = (along**2).sum(axis=1)
    part = np.clip((away * along).sum(axis=2) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    aside: Array = np.abs(away - part[..., None] * along).max(axis=2).min(axis=1, initial=np.inf)
    return aside
