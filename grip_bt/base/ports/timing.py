"""What passes time, and what can be held still."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from grip_bt.base.operation import Operation


@runtime_checkable
class Clock(Protocol):
    """The one clock of a run: wall, simulator, ROS or manual."""

    def now(self) -> float:
        """Return the time [s]; it never decreases."""


@runtime_checkable
class Pausable(Protocol):
    """A clock, or a part of a robot, that can stand still in the middle of what it does and go on afterwards."""

    def pause(self) -> None:
        """Hold what moves where it is and keep what is left of it; harmless when it is paused."""

    def resume(self) -> None:
        """Go on with what is left; harmless when it isn't paused."""


class InTurnOf(Protocol):
    """Makes of an operation one whose end comes when it is its turn."""

    def __call__(self, operation: Operation[Any], *, holds: bool) -> Operation[Any]:
        """Return it for the run; `holds` says whether time stands still until it ends."""


class Stepped(Protocol):
    """A simulated world whose time can be made to stand still but for as long as it is told to go on."""

    @property
    def sent(self) -> int:
        """How many requests it was sent; they may have ended motions."""

    @property
    def clock(self) -> Clock:
        """Simulated time."""

    def keep_to_simulated(self, only: bool) -> None:
        """Have the clock show simulated time alone, or let ours go on in it while nothing moves."""

    def take_turns(self, in_turn: InTurnOf, stood: Callable[[], None]) -> None:
        """Stand still from now on.

        Args:
            in_turn: makes what the run gets of every motion and every frame that is begun from now on.
            stood: called each time it has gone as far as it was told, when all ends until then were handed on.
        """

    def go(self, until: float | None) -> bool:
        """Go on up to a moment [s], or until a motion ends, and stand still; False when it is lost."""

    def stand(self) -> None:
        """Stand still now, if it goes."""

    def go_freely(self) -> None:
        """Go by itself again."""
