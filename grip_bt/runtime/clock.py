"""Clocks of a run. Nothing else in GRIP asks the operating system for the time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class WallClock:
    """Seconds since it was made; never goes back."""

    def __init__(self) -> None:
        self._start = time.monotonic()

    def now(self) -> float:
        """Return the time [s]."""
        return time.monotonic() - self._start


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
