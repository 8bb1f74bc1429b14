"""How long a search may take: time that it worked, so that a busy machine finds the plans that a quiet one finds."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

BACKSTOP = 20.0
"""Wall time ends a search at this many times its budget, however little CPU time it got."""
RATE = 4000.0
"""Checks of motions that stand for a second where searches share work: about half of what one core gets through."""


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
    """Work and time for one request, from now on; asked in the thread that searches.

    Searches that take turns, each with a share, are ended by how often they have asked: what is found is the same on a
    fast machine and on a slow one. Time ends the whole request, which has failed then.

    Args:
        seconds: CPU time [s].
        clocks: what tells the time; `REAL` where nothing is said.
    """

    def __init__(self, seconds: float, clocks: Clocks | None = None):
        self._clocks, self._seconds, self._wall = clocks or REAL, seconds, BACKSTOP * seconds
        self._began = self._clocks.worked(), self._clocks.passed()
        self._asked, self._most = 0.0, RATE * seconds
        self._of: Budget | None = None

    def over(self, work: float = 1.0) -> bool:
        """Tell whether a search has to end; each call counts as some work, a check of RRTConnect being 1."""
        self._asked += work
        if self._of is None:
            return self.out_of_time
        return self._asked > self._most or self._of.over(work)

    @property
    def out_of_time(self) -> bool:
        """Whether the time of the whole request is spent."""
        if self._of is not None:
            return self._of.out_of_time
        return self._passed() > self._wall or self._worked() > self._seconds

    @property
    def wall_left(self) -> float:
        """How much wall time is left [s]; not below 0."""
        return self._of.wall_left if self._of is not None else max(0.0, self._wall - self._passed())

    def share(self, parts: int) -> Budget:
        """Return a budget of an even part of the work that is left, for the next of so many searches.

        The last one is ended by time alone.
        """
        if parts == 1:
            return self
        return self.part(max(0.0, self._most - self._asked) / parts / RATE)

    def part(self, seconds: float) -> Budget:
        """Return a budget of the work that is done in some seconds."""
        part = Budget(self._seconds, self._clocks)
        part._most, part._of = RATE * seconds, self
        return part

    def __str__(self) -> str:
        """Say what ended it."""
        if not self.out_of_time:
            return f"within {self._most:.3g} checks, its share of the work"
        if self._of is not None:
            return str(self._of)
        if self._worked() > self._seconds:
            return f"within {self._seconds:.3g} s of CPU time"
        got = f"it got only {self._worked():.2g} of its {self._seconds:.3g} s of CPU time"
        return f"within {self._wall:.3g} s, in which {got}: the machine is busy"

    def _worked(self) -> float:
        return self._clocks.worked() - self._began[0]

    def _passed(self) -> float:
        return self._clocks.passed() - self._began[1]
