"""A position controller that follows a topic: trajectories are sampled and streamed to it, and so is braking."""

from __future__ import annotations

import threading
import time
from array import array
from collections.abc import Mapping, Sequence

import numpy as np

from grip_bt.base.failures import SensorError, ServerTimeOutError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Trajectory
from grip_bt.commanders.steering import spliced
from grip_bt.commanders.trajectory.braking import stop_ramp
from grip_bt.commanders.trajectory.smooth import jerks_of

from ..bus import Bus
from ..types import load_type
from .joint_states import JointStates
from .motion import START_TOLERANCE, settle
from .over_topic import Course, OverTopic

RATE = 100.0
"""Set-points a second."""
BEHIND = 0.5
"""How far joints, or what is heard of them, may be behind the set-points [s] and still count as on their way."""


class _Way(Course):
    """What is streamed: a trajectory that may be changed while its set-points are sent."""

    def __init__(self, trajectory: Trajectory):
        super().__init__(trajectory)
        self._lock = threading.Lock()
        self._began: float | None = None
        self.over = False
        self.sent = 0.0
        """The time of the last set-point [s]."""

    def begin(self) -> None:
        self._began = time.monotonic()

    def leave(self) -> None:
        self.over = True
        super().leave()

    def passed(self) -> float:
        """Return for how long it has been streamed [s]."""
        return 0.0 if self._began is None else time.monotonic() - self._began

    def at(self, time: float) -> np.ndarray:
        """Return the positions at a time [s], shape (n,)."""
        with self._lock:
            return self.trajectory.at(time)

    def ended(self) -> bool:
        """Tell whether all of it is sent; it can't be changed any more then."""
        with self._lock:
            self.over = self.over or self.passed() >= self.trajectory.duration
            return self.over

    def amend(self, tail: Trajectory, at: float) -> bool:
        with self._lock:
            whole = spliced(self.trajectory, tail, at)
            if self.over or self.passed() > min(at, self.trajectory.duration):
                return False
            self.trajectory = whole
            return True


class StreamedExecutor(OverTopic[_Way]):
    """Implements `grip_bt.base.ports.Executor` and `Steerable` over a joint group position controller.

    Args:
        bus: the connection to ROS.
        topic: the controller's, such as `/arm_position_controller/commands`.
        names: its joints, in its order.
        states: where they are measured.
        accelerations: joint -> limit, for braking; see `trajectory.braking.accelerations_of`.
        rate: set-points a second.
        jerks: joint -> limit, for braking too; any where it names none.
    """

    message = "std_msgs/msg/Float64MultiArray"

    def __init__(
        self,
        bus: Bus,
        topic: str,
        names: Sequence[str],
        states: JointStates,
        accelerations: Mapping[str, float] | None = None,
        rate: float = RATE,
        jerks: Mapping[str, float] | None = None,
    ):
        super().__init__(bus, topic, names, states, accelerations)
        self._period, self._message, self._jerks = 1.0 / rate, load_type(self.message), jerks or {}

    def passed(self) -> float | None:
        """Return for how long the motion under way has been followed [s]; see `ports.Steerable`."""
        way = self._course
        return None if way is None or way.over else way.passed()

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`."""
        way = self._course
        return way is not None and way.amend(tail, at)

    def expect(self, at: float | None) -> None:
        """Do nothing: its time is ours."""

    def _course_of(self, trajectory: Trajectory) -> _Way:
        return _Way(trajectory)

    def _follow(self, course: _Way) -> None:
        """Publish set-points in time; on a stop, those of a ramp."""
        way, order = course, self._order(course.trajectory)
        first = self._publish(way.trajectory.positions[0][order], 1)
        if not first.wait(6.0):
            raise ServerTimeOutError(f"{self._topic}: nobody listens")
        first.result()
        way.begin()
        while not way.ended():
            if way.stop.wait(self._period):
                break
            way.sent = way.passed() + self._period
            self._publish(way.at(way.sent)[order].tolist(), 0)
        else:
            last, way.sent = way.trajectory.positions[-1][order], way.trajectory.duration
            self._publish(last.tolist(), 0).wait(1.0)
            settle(self.state, last, way.stop)
        way.over = True
        if way.stop.is_set():
            self._brake(way, order)

    def _brake(self, way: _Way, order: list[int]) -> None:
        """Stream the ramp from the last set-point on; where something keeps the joints off their way, they stay there.

        A measurement is late. Joints that follow were there a moment ago, and holding there would send them back.
        """
        held = self._held_back(way)
        if held is not None and not way.dropped.is_set():
            self._publish(held[order].tolist(), 0)
            return
        jerks = jerks_of(way.trajectory.names, self._jerks)
        ramp = stop_ramp(way.trajectory, way.sent, self._limits(way.trajectory), jerks)
        began, passed = time.monotonic(), 0.0
        while passed < ramp.duration and not way.dropped.wait(self._period):
            passed = time.monotonic() - began
            self._publish(ramp.at(passed)[order].tolist(), 0)
        settle(self.state, ramp.positions[-1][order], way.dropped)  # set-points may still be on their way

    def _held_back(self, way: _Way) -> np.ndarray | None:
        """Return where joints are that aren't on their way, nor a bit behind on it, in the way's order; else None."""
        try:
            measured = self._states.state(way.trajectory.names).position
        except SensorError:
            return None  # to come to rest on the way is the best that is known then
        lately = np.stack([way.at(t) for t in np.linspace(max(0.0, way.sent - BEHIND), way.sent, 51)])
        off = np.abs(lately - measured).max(axis=1).min()
        return measured if off > START_TOLERANCE else None

    def _publish(self, positions: Sequence[float], subscribers: int) -> Operation[None]:
        return self._writer.publish(self._message(data=array("d", positions)), subscribers)
