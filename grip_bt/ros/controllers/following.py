"""One motion as a trajectory controller follows it: in goals, each of which takes the place of the one before.

A motion is changed by sending the rest of it, timed from when it comes. No clocks have to agree for that, and no
message lets the joints go back, however late it is (`blending`): they are slower, or at rest, until it comes.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Protocol

from grip_bt.base.failures import ExecutionAbortedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Trajectory
from grip_bt.commanders.steering import spliced

from ..goal import GoalEnd
from .blending import Change, Places, change, places

LATEST = 0.03
"""A motion can be changed until so long before the change takes effect [s]."""
USUAL = 0.01
"""A goal is reckoned with to take no more than this [s]: one that came sooner would make the joints too fast."""
KEPT = 10
"""So many of the last goals tell how long a goal takes until it is accepted."""

Send = Callable[[Trajectory, float, Callable[[], None]], Operation[GoalEnd]]
"""Trajectory, how long after now its first point is reached [s], what is called when it was accepted -> the goal."""


class Time(Protocol):
    """A steady clock, and what happens later."""

    def now(self) -> float:
        """Return the time [s]."""

    def after(self, delay: float, action: Callable[[], None]) -> None:
        """Call `action()` when `delay` [s] has passed."""


class WallTime:
    """Time as it passes."""

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

    Args:
        send: sends a goal.
        trajectory: what is followed at first.
        clock: its time.
    """

    def __init__(self, send: Send, trajectory: Trajectory, clock: Time | None = None):
        self._send, self._trajectory, self._clock = send, trajectory, clock or WallTime()
        self._lock = threading.RLock()
        self._sent = 0.0
        self._began: float | None = None
        """When the motion has begun at the latest: never before the controller began, but soon after."""
        self._delays: deque[float] = deque(maxlen=KEPT)
        self._blends: Places | None = None
        self._goals: list[Operation[GoalEnd]] = []
        self._waiting: Change | None = None
        self._flying: Change | None = None
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
                possible = possible.and_those(self._blends.since(begin))
            likely = begin + min(USUAL, *self._delays)
            found = change(possible, self._trajectory, whole, likely) or change(
                possible, self._trajectory, whole, begin
            )
            if found is None:
                return False
            self._waiting = found
        self._clock.after(begin - passed, partial(self._replace, found))
        return True

    def _replace(self, found: Change) -> None:
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

    def _replaced(self, found: Change) -> None:
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
