"""Waiting for something to look at. Any thread wakes; any number of threads wait, and none takes another's wake."""

from __future__ import annotations

import heapq
import threading
from typing import TYPE_CHECKING

from grip_bt.base.ports import Clock

if TYPE_CHECKING:
    from .lockstep import Lockstep


class Waker:
    """Counts wakes; who has seen number n waits for a later one.

    Attributes:
        condition: told of every wake.
        lockstep: with what the run takes turns, if it does.

    Args:
        clock: the run's clock, for `wake_at`.
    """

    def __init__(self, clock: Clock):
        self._clock = clock
        self.condition = threading.Condition()
        self.lockstep: Lockstep | None = None
        self._wakes = 0
        self._times: list[float] = []
        listen = getattr(clock, "on_advance", None)
        if listen is not None:
            listen(self._clock_moved)

    @property
    def wakes(self) -> int:
        """How many there were."""
        return self._wakes

    @property
    def due(self) -> float | None:
        """The next moment for which a wake was asked [s]."""
        return self._times[0] if self._times else None

    def now(self) -> float:
        """Return the run's time [s]."""
        return self._clock.now()

    def wake(self) -> None:
        """Have whoever waits look; from any thread."""
        with self.condition:
            self._wakes += 1
            self.condition.notify_all()

    def wake_at(self, time: float) -> None:
        """Wake when the clock reaches `time` [s]."""
        with self.condition:
            heapq.heappush(self._times, time)
            self.condition.notify_all()

    def wait(self, seen: int, timeout: float | None) -> None:
        """Return after a wake later than `seen`, or after `timeout` [s] of wall time; None waits for ever.

        A clock that runs faster than the wall and doesn't say when it moves is noticed at the latest after `timeout`.
        In lockstep with a simulated world, the time-out is on the run's clock.
        """
        if self.lockstep is not None and self.lockstep.on:
            self.lockstep.rest(seen, timeout)
            return
        with self.condition:
            self.ring()
            if self._wakes == seen:
                self.condition.wait(self._patience(timeout))
                self.ring()

    def _clock_moved(self) -> None:
        with self.condition:
            self.ring()

    def ring(self) -> None:
        """Turn times that are over into a wake; with the condition held."""
        now, over = self._clock.now(), False
        while self._times and self._times[0] <= now:
            heapq.heappop(self._times)
            over = True
        if over:
            self._wakes += 1
            self.condition.notify_all()

    def _patience(self, timeout: float | None) -> float | None:
        if not self._times:
            return timeout
        left = max(0.0, self._times[0] - self._clock.now())
        return left if timeout is None else min(timeout, left)
