"""Waiting for something to look at. Any thread wakes; any number of threads wait, and none takes another's wake."""

from __future__ import annotations

import heapq
import threading

from grip_bt.ports import Clock


class Waker:
    """Counts wakes; who has seen number n waits for a later one.

    Args:
        clock: the run's clock, for `wake_at`.
    """

    def __init__(self, clock: Clock):
        self._clock = clock
        self._condition = threading.Condition()
        self._wakes = 0
        self._times: list[float] = []
        listen = getattr(clock, "on_advance", None)
        if listen is not None:
            listen(self._clock_moved)

    @property
    def wakes(self) -> int:
        """How many there were."""
        return self._wakes

    def now(self) -> float:
        """Return the run's time [s]."""
        return self._clock.now()

    def wake(self) -> None:
        """Have whoever waits look; from any thread."""
        with self._condition:
            self._wakes += 1
            self._condition.notify_all()

    def wake_at(self, time: float) -> None:
        """Wake when the clock reaches `time` [s]."""
        with self._condition:
            heapq.heappush(self._times, time)
            self._condition.notify_all()

    def wait(self, seen: int, timeout: float | None) -> None:
        """Return after a wake later than `seen`, or after `timeout` [s] of wall time; None waits for ever.

        A clock that runs faster than the wall and doesn't say when it moves is noticed at the latest after `timeout`.
        """
        with self._condition:
            self._ring()
            if self._wakes == seen:
                self._condition.wait(self._patience(timeout))
                self._ring()

    def _clock_moved(self) -> None:
        with self._condition:
            self._ring()

    def _ring(self) -> None:
        """Turn times that are over into a wake."""
        now, over = self._clock.now(), False
        while self._times and self._times[0] <= now:
            heapq.heappop(self._times)
            over = True
        if over:
            self._wakes += 1
            self._condition.notify_all()

    def _patience(self, timeout: float | None) -> float | None:
        if not self._times:
            return timeout
        left = max(0.0, self._times[0] - self._clock.now())
        return left if timeout is None else min(timeout, left)
