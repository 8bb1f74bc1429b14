"""Clocks of a run, and waiting for something to look at. Nobody else in GRIP asks the operating system for the time."""

from __future__ import annotations

import heapq
import threading
import time
from contextlib import AbstractContextManager
from typing import Protocol

from grip_bt.base.ports import Clock


class Turns(Protocol):
    """With what a run takes turns, while it is `on`."""

    @property
    def on(self) -> bool: ...

    def rest(self, seen: int, poll: float | None) -> None:
        """Return after a wake later than number `seen`, or after `poll` [s] of the run's clock."""

    def fork(self, count: int) -> list[AbstractContextManager[object]]:
        """Return what threads enter that this thread starts, each for as long as it works."""

    def joined(self) -> AbstractContextManager[object]:
        """Return what this thread enters while it waits for them."""


class WallClock:
    """Seconds since it was made, pauses left out; never goes back."""

    def __init__(self) -> None:
        self._start = time.monotonic()
        self._stood_at: float | None = None

    def now(self) -> float:
        stood_at = self._stood_at
        return time.monotonic() - self._start if stood_at is None else stood_at

    def pause(self) -> None:
        if self._stood_at is None:
            self._stood_at = time.monotonic() - self._start

    def resume(self) -> None:
        if self._stood_at is not None:
            self._start = time.monotonic() - self._stood_at
            self._stood_at = None


class Waker:
    """Counts wakes; who has seen number n waits for a later one."""

    def __init__(self, clock: Clock):
        self._clock = clock
        self.condition = threading.Condition()
        self.turns: Turns | None = None
        self.wakes = 0
        self._times: list[float] = []
        listen = getattr(clock, "on_advance", None)
        if listen is not None:
            listen(self._clock_moved)

    @property
    def due(self) -> float | None:
        return self._times[0] if self._times else None

    def now(self) -> float:
        return self._clock.now()

    def wake(self) -> None:
        """Have whoever waits look; from any thread."""
        with self.condition:
            self.wakes += 1
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
        if self.turns is not None and self.turns.on:
            self.turns.rest(seen, timeout)
            return
        with self.condition:
            self.ring()
            if self.wakes == seen:
                left = max(0.0, self._times[0] - self._clock.now()) if self._times else timeout
                self.condition.wait(left if timeout is None or left is None else min(timeout, left))
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
            self.wakes += 1
            self.condition.notify_all()
