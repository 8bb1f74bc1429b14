"""What executors over a topic have in common: nobody answers there, so a thread sees to each motion to its end."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.failures import CanceledError, ExecutionAbortedError, SensorError, ServerTimeOutError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Trajectory
from grip_bt.commanders.trajectory.braking import accelerations_of

from ..bus import Bus
from .joint_states import JointStates
from .motion import RosExecutor


class Course:
    """A motion under way.

    Attributes:
        trajectory: what is followed.
        stop: set when it is to come to rest.
        dropped: set, with `stop`, when nothing more is to be sent, since another motion takes its place.
    """

    def __init__(self, trajectory: Trajectory):
        self.trajectory = trajectory
        self.stop, self.dropped, self._left = threading.Event(), threading.Event(), threading.Event()

    def drop(self) -> None:
        """Have nothing more sent, and wait until that is so."""
        self.dropped.set()
        self.stop.set()
        self._left.wait(1.0)

    def leave(self) -> None:
        """Say that nothing more is sent."""
        self._left.set()


C = TypeVar("C", bound=Course)


class OverTopic(RosExecutor, Generic[C]):
    """An executor over a topic, but for how a motion is seen to.

    Args:
        bus: the connection to ROS.
        topic: the controller's.
        names: its joints, in its order.
        states: where they are measured.
        accelerations: joint -> limit, for braking; see `trajectory.braking.accelerations_of`.
    """

    message: str
    """The topic's interface."""

    def __init__(
        self,
        bus: Bus,
        topic: str,
        names: Sequence[str],
        states: JointStates,
        accelerations: Mapping[str, float] | None = None,
    ):
        super().__init__(names, states)
        self._accelerations = accelerations or {}
        self._topic, self._writer, self._guard = topic, bus.writer(self.message, topic), bus.guard
        self._course: C | None = None

    def _begin(self, trajectory: Trajectory) -> Operation[None]:
        self._course = course = self._course_of(trajectory)
        done: Operation[None] = Operation(on_cancel=course.stop.set)
        threading.Thread(target=self._see_to, args=(course, done), name="grip_over_topic", daemon=True).start()
        return done

    def _drop(self) -> None:
        if self._course is not None:
            self._course.drop()

    def _see_to(self, course: C, done: Operation[None]) -> None:
        try:
            self._follow(course)
            if course.stop.is_set():
                done.fail(CanceledError("the motion was stopped"))
            else:
                done.succeed(None)
        except (ServerTimeOutError, SensorError) as error:
            done.fail(ExecutionAbortedError(error.message, cause=error.code))
        except BaseException as error:  # noqa: BLE001 - of this thread; the owner has to hear of it
            done.fail(error)
        finally:
            course.leave()

    def _order(self, trajectory: Trajectory) -> list[int]:
        """Return where in the trajectory each of our joints is."""
        return [trajectory.names.index(name) for name in self._names]

    def _limits(self, trajectory: Trajectory) -> NDArray[np.float64]:
        """Return the acceleration limits of the trajectory's joints [rad/s^2 or m/s^2]."""
        return accelerations_of(trajectory.names, self._accelerations)

    @abstractmethod
    def _course_of(self, trajectory: Trajectory) -> C:
        """Return a motion that begins."""

    @abstractmethod
    def _follow(self, course: C) -> None:
        """See to a motion until it has ended, or, on a stop, has braked.

        Raises:
            ServerTimeOutError: nobody listens.
            SensorError: nothing is measured of the joints any more.
            ExecutionAbortedError: the joints don't do it.
        """
