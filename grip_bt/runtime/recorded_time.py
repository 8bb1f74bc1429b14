"""Clocks of a run that happens again: recorded times first, then time goes on where the recording ends.

Containers that ask for the time are answered as before, since the recording has the times of events and not those of
looks at the clock.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any

from grip_bt.base.ports import Clock, Pausable

from .recording import Recording


class RecordedClock:
    """Shows the time of the last recorded event until `go`, and from then on that time and what has passed since.

    Args:
        clock: what goes on then.
        recording: the recorded events.
    """

    def __init__(self, clock: Clock, recording: Recording):
        self._clock, self._recording = clock, recording
        self._since: float | None = None

    def now(self) -> float:
        """Return the time [s]."""
        if self._since is None:
            return self._recording.time()
        return self._recording.end_time + (self._clock.now() - self._since)

    def go(self) -> None:
        """Let time pass."""
        self._since = self._clock.now()

    @property
    def going(self) -> bool:
        """Whether it does."""
        return self._since is not None

    def pause(self) -> None:
        """Stand still, where the clock can."""
        if isinstance(self._clock, Pausable):
            self._clock.pause()

    def resume(self) -> None:
        """Go on from where it stands."""
        if isinstance(self._clock, Pausable):
            self._clock.resume()

    def on_advance(self, listener: Callable[[], None]) -> None:
        """Call `listener()` after each advance, where the clock says when it moves."""
        listen: Any = getattr(self._clock, "on_advance", None)
        if listen is not None:
            listen(listener)


def recorded_limit(
    clock: RecordedClock, recording: Recording, path: str, codes: Collection[str]
) -> Callable[[float], bool]:
    """Return what tells a container that halts its child at a time whether that has come: it has where it did so.

    Args:
        clock: the run's.
        recording: the recorded events.
        path: the container's.
        codes: with which it fails then.
    """

    def judge(at: float) -> bool:
        if clock.going:
            return clock.now() >= at
        halted = recording.halted(path, codes)
        return halted if isinstance(halted, bool) else halted >= at

    return judge


def recorded_rest(
    clock: RecordedClock, recording: Recording, path: str, children: Sequence[str]
) -> Callable[[float], bool]:
    """Return what tells a container that runs a child from a time on whether that has come: it has where it did so."""

    def judge(at: float) -> bool:
        refused = None if clock.going else recording.refused(path, children)
        return clock.now() >= at if refused is None else not refused

    return judge
