"""What a run offers to its leaves, its clock, and what can be paused."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar, runtime_checkable

from grip_bt.base.operation import Operation

from .hands import Hand
from .motion import Arm
from .world import Camera, Component, Messages, Ros, Scene, Sensor


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

    def __call__(self, operation: Operation[T], *, holds: bool) -> Operation[T]:
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


T = TypeVar("T")


class Context(Protocol):
    """What a run offers to its leaves."""

    @property
    def clock(self) -> Clock:
        """The run's clock."""

    @property
    def preempt_requested(self) -> bool:
        """Whether somebody asked the task to come to an end on its own terms."""

    def wake(self) -> None:
        """Have the task ticked soon; from any thread."""

    def wake_at(self, time: float) -> None:
        """Have the task ticked when the run's clock reaches `time` [s]."""

    def run_in_worker(self, work: Callable[[], T]) -> Operation[T]:
        """Run blocking code in a worker thread."""

    def left(self, path: str, work: Operation[T]) -> None:
        """Take note of a leaf's work that was told to stop, and may move something until it has ended."""

    def unfinished(self) -> Sequence[str]:
        """Return the paths of the leaves of which that was said and whose work hasn't ended; else arms and hands.

        These are named whose motions were told to stop, and haven't, whoever has begun them.

        Raises:
            NotStoppedError: of one of them nobody can say whether it has.
        """

    def arm(self, name: str) -> Arm:
        """Return an arm; UnknownNameError lists those that exist. An empty name means the only one."""

    def hand(self, name: str) -> Hand:
        """Return a hand, likewise."""

    def camera(self, name: str) -> Camera:
        """Return a sensor's camera, likewise."""

    def component(self, name: str) -> Component:
        """Return an external component, likewise."""

    def scene(self) -> Scene:
        """Return the planning scene."""

    def sensor(self, name: str) -> Sensor:
        """Return a sensor that gives what topics carry; UnknownNameError lists those that exist."""

    def ros(self) -> Ros:
        """Return the connection to ROS; MissingPartError when this run has none."""

    def messages(self) -> Messages:
        """Return the project's named values; MissingPartError when this run has none."""
