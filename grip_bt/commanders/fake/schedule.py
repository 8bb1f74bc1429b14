"""When things happen in a fake: at once, or when a clock gets there."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator
from itertools import chain, repeat
from typing import Protocol

from grip_bt.base.failures import ExpectedError

Script = Iterable[ExpectedError | None]


def steps_of(script: Script) -> Iterator[ExpectedError | None]:
    """Return the script's entries, and None for ever after."""
    return chain(script, repeat(None))


class MovableClock(Protocol):
    """A clock that tells when it was moved, such as `runtime.clock.ManualClock`."""

    def now(self) -> float:
        """Return the time [s]."""

    def on_advance(self, listener: Callable[[], None]) -> None:
        """Call `listener()` after each move."""


class Schedule(Protocol):
    """A fake's time."""

    def now(self) -> float:
        """Return the time [s]."""

    def stamp(self) -> float:
        """Return the stamp of what is measured now [s]; 0 where nobody else's time goes like this."""

    def after(self, delay: float, action: Callable[[], None]) -> None:
        """Call `action()` when `delay` [s] has passed."""


class AtOnce:
    """Time that passes when somebody waits for it: whatever takes time has taken it at once."""

    def __init__(self) -> None:
        self._time = 0.0

    def now(self) -> float:
        """Return the time [s]: the sum of all delays so far."""
        return self._time

    def stamp(self) -> float:
        """Return 0: what is measured has no stamp."""
        return 0.0

    def after(self, delay: float, action: Callable[[], None]) -> None:
        """Let `delay` [s] pass and call `action()`."""
        self._time += delay
        action()


class OnClock:
    """Time of a clock that somebody moves; what has come due happens in order, within the move.

    Args:
        clock: the clock.
    """

    def __init__(self, clock: MovableClock):
        self._clock = clock
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        clock.on_advance(self._run)

    def now(self) -> float:
        """Return the time [s]."""
        return self._clock.now()

    def stamp(self) -> float:
        """Return the time [s]."""
        return self._clock.now()

    def after(self, delay: float, action: Callable[[], None]) -> None:
        """Call `action()` when the clock has moved `delay` [s] on."""
        self._count += 1
        heapq.heappush(self._due, (self._clock.now() + delay, self._count, action))

    def _run(self) -> None:
        # A hair of tolerance: sums of clock steps aren't exact.
        while self._due and self._due[0][0] <= self._clock.now() + 1e-9:
            heapq.heappop(self._due)[2]()
