"""Clocks of a run that happens again: recorded times first, then time goes on where the recording ends.

Nodes that decide by the time get clocks by which they decide as before, since the recording has the times of events and
not those of looks at the clock.
"""

from __future__ import annotations

from collections.abc import Callable
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


class TimeoutClock:
    """The clock of one timeout: its time is over when the recording says so."""

    def __init__(self, clock: RecordedClock, recording: Recording, path: str):
        self._clock, self._recording, self._path = clock, recording, path

    def now(self) -> float:
        """Return the time [s]; while it is recorded, that of the activation's beginning, or of its end."""
        if self._clock.going:
            return self._clock.now()
        over = self._recording.times_out(self._path)
        if over is not None:
            return over
        activation = self._recording.activation(self._path)
        if activation is None:
            return self._clock.now()
        return self._recording.events[activation.began].t


def recorded_judge(clock: RecordedClock, recording: Recording, path: str, child: str) -> Callable[[float], bool]:
    """Return what tells whether the time has come at which a container runs its child again: it has where it did."""

    def judge(at: float) -> bool:
        refuses = None if clock.going else recording.refuses(path, child)
        return clock.now() >= at if refuses is None else not refuses

    return judge
