"""The clock of a run over the simulator."""

from __future__ import annotations

import threading
import time


class SimClock:
    """Simulated time while something moves, our own time while nothing does; it never decreases but once.

    Physics stands still between motions, and whoever moves the robot by hand has time-outs all the same. A run that
    takes turns with the simulator has simulated time alone: nothing in it depends on how long anything takes us.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._simulated = 0.0
        self._idle = 0.0
        self._idle_since: float | None = time.monotonic()
        self._moving = 0
        self._latest = 0.0
        self._paused = self._simulated_only = False

    def now(self) -> float:
        """Return the time [s]."""
        with self._lock:
            idle = 0.0 if self._idle_since is None else time.monotonic() - self._idle_since
            # the same sum, rounded in another order, may be smaller in its last bit
            self._latest = max(self._latest, self._simulated + self._idle + idle)
            return self._latest

    @property
    def simulated(self) -> float:
        """Simulated time alone [s]."""
        return self._simulated

    def begin(self) -> None:
        """A motion begins."""
        with self._lock:
            self._moving += 1
            if self._idle_since is not None:
                self._idle += time.monotonic() - self._idle_since
                self._idle_since = None

    def end(self) -> None:
        """A motion has ended."""
        with self._lock:
            self._moving -= 1
            self._let_idle()

    def pause(self) -> None:
        """Stand still also while nothing moves; harmless when it does already."""
        with self._lock:
            self._paused = True
            if self._idle_since is not None:
                self._idle += time.monotonic() - self._idle_since
                self._idle_since = None

    def resume(self) -> None:
        """Go on; harmless when it goes."""
        with self._lock:
            if self._paused:
                self._paused = False
                self._let_idle()

    def keep_to_simulated(self, only: bool) -> None:
        """Show simulated time alone, from which our own is taken out again; or let our own go on."""
        with self._lock:
            if only == self._simulated_only:
                return
            self._simulated_only = only
            if only:
                self._idle, self._idle_since, self._latest = 0.0, None, self._simulated
            else:
                self._let_idle()

    def _let_idle(self) -> None:
        if self._moving == 0 and not self._paused and not self._simulated_only:
            self._idle_since = time.monotonic()

    def told(self, simulated: float) -> None:
        """Take over the simulator's time [s]."""
        with self._lock:
            self._simulated = max(self._simulated, simulated)
