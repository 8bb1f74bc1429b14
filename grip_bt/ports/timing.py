"""What passes time, and what can be held still."""

from __future__ import annotations

from typing import Protocol, runtime_checkable


@runtime_checkable
class Clock(Protocol):
    """The one clock of a run: wall, simulator, ROS or manual."""

    def now(self) -> float:
        """Return the time [s]; it never decreases."""
        ...


@runtime_checkable
class Pausable(Protocol):
    """A clock, or a part of a robot, that can stand still in the middle of what it does and go on afterwards."""

    def pause(self) -> None:
        """Hold what moves where it is and keep what is left of it; harmless when it is paused."""
        ...

    def resume(self) -> None:
        """Go on with what is left; harmless when it isn't paused."""
        ...
