"""Clocks of a run. Nothing else in GRIP asks the operating system for the time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class WallClock:
    """Seconds since it was made, pauses left out; never goes back.

    Attributes:
        turns: (moment [s, monotonic], its time then [s], 1 where it went from then on and 0 where it stood still); with
            them the journal turns moments into times long after.
    """

    def __init__(self) -> None:
        self._start = time.monotonic()
        self._stood_at: float | None = None
        self.turns: list[tuple[float, float, int]] = [(self._start, 0.0, 1)]

    def now(self) -> float:
        """Return the time [s]."""
        stood_at = self._stood_at
        return time.monotonic() - self._start if stood_at is None else stood_at

    def pause(self) -> None:
        """Stand still; harmless when it does already."""
        if self._stood_at is None:
            moment = time.monotonic()
            self._stood_at = moment - self._start
            self.turns.append((moment, self._stood_at, 0))

    def resume(self) -> None:
        """Go on from where it stands; harmless when it goes."""
        if self._stood_at is not None:
            moment = time.monotonic()
            self._start = moment - self._stood_at
            self.turns.append((moment, self._stood_at, 1))
            self._stood_at = None


class ManualClock:
    """Moves only when it is told to, so that a time-out of 30 s is tested in no time."""

    def __init__(self, start: float = 0.0):
        self._time = start
        self._lock = threading.Lock()
        self._listeners: list[Callable[[], None]] = []

    def now(self) -> float:
        """Return the time [s]."""
        return self._time

    def advance(self, seconds: float) -> None:
        """Let `seconds` [s] pass, and have those woken who wait for the time.

        Raises:
            ValueError: time doesn't go back.
        """
        if seconds < 0:
            raise ValueError(f"time doesn't go back: {seconds} s")
        with self._lock:
            self._time += seconds
            listeners = list(self._listeners)
        for listener in listeners:
            listener()

    def on_advance(self, listener: Callable[[], None]) -> None:
        """Call `listener()` after each advance."""
        with self._lock:
            self._listeners.append(listener)
