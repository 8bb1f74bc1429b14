"""How long a search may take: time that it worked, so that a busy machine finds the plans that a quiet one finds."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

BACKSTOP = 20.0
"""Wall time ends a search at so many times its budget, however little of it was worked."""


class Clocks(NamedTuple):
    """Two clocks, in seconds from wherever they begin.

    Attributes:
        worked: CPU time of the thread that asks.
        passed: wall time.
    """

    worked: Callable[[], float]
    passed: Callable[[], float]


REAL = Clocks(time.thread_time, time.monotonic)
"""The thread's time, not the process's: while several threads share a batch of collision checks, it counts once."""


class Budget:
    """Time to work in, from now on; asked in the thread that searches.

    Args:
        seconds: CPU time [s].
        clocks: what tells the time.
        wall: wall time that ends it too [s]; `BACKSTOP` times `seconds` where nothing is said.
    """

    __slots__ = ("_began", "_clocks", "_seconds", "_wall")

    def __init__(self, seconds: float, clocks: Clocks = REAL, wall: float | None = None):
        self._clocks, self._seconds = clocks, seconds
        self._wall = BACKSTOP * seconds if wall is None else wall
        self._began = clocks.worked(), clocks.passed()

    @property
    def over(self) -> bool:
        """Whether it is spent, or the wall time is over."""
        return self._passed() > self._wall or self._worked() > self._seconds

    @property
    def wall_left(self) -> float:
        """How much wall time is left [s]; not below 0."""
        return max(0.0, self._wall - self._passed())

    def share(self, parts: int) -> Budget:
        """Return a budget of an even part of what is left, for the next of so many searches."""
        left = max(0.0, self._seconds - self._worked())
        return Budget(left / parts, self._clocks, self.wall_left / parts)

    def __str__(self) -> str:
        """Say what ended it."""
        if self._worked() > self._seconds:
            return f"within {self._seconds:.3g} s of CPU time"
        got = f"it got only {self._worked():.2g} of its {self._seconds:.3g} s of CPU time"
        return f"within {self._wall:.3g} s, in which {got}: the machine is busy"

    def _worked(self) -> float:
        return self._clocks.worked() - self._began[0]

    def _passed(self) -> float:
        return self._clocks.passed() - self._began[1]
