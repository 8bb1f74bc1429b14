"""What a run offers to its leaves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

from grip_bt.base.operation import Operation

from .external import Component, Ros
from .hands import Hand
from .messages import Messages
from .motion import Arm
from .scene import Scene
from .sensing import Camera, Sensor
from .timing import Clock, Pausable

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

    def left(self, path: str, work: Operation[Any]) -> None:
        """Take note of a leaf's work that was told to stop, and may move something until it has ended."""

    def unfinished(self) -> Sequence[str]:
        """Return the paths of the leaves of which that was said and whose work hasn't ended; else arms and hands.

        These are named whose motions were told to stop, and haven't, whoever has begun them.

        Raises:
            NotStoppedError: of one of them nobody can say whether it has.
        """

    def hold_with(self, part: Pausable) -> Callable[[], None]:
        """Have `part` stand still whenever the run is paused, at once if it is; call what is returned to end that."""

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
