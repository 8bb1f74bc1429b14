"""A position controller that follows a topic: trajectories are sampled and streamed to it."""

from __future__ import annotations

import threading
import time
from array import array
from collections.abc import Sequence

import numpy as np

from grip_bt.commanders.steering import spliced
from grip_bt.errors import CanceledError, ExecutionAbortedError, SensorError, ServerTimeOutError
from grip_bt.operation import Operation
from grip_bt.values import Trajectory

from ..bus import Bus
from ..types import load_type
from .joint_states import JointStates
from .motion import START_TOLERANCE, RosExecutor, settle

MESSAGE = "std_msgs/msg/Float64MultiArray"
RATE = 100.0
"""Set-points a second."""
BEHIND = 0.5
"""How far joints, or what is heard of them, may be behind the set-points [s] and still count as on their way."""


class StreamedExecutor(RosExecutor):
    """Implements `grip_bt.ports.Executor` and `Steerable` over a joint group position controller.

    Args:
        bus: the connection to ROS.
        topic: the controller's, such as `/arm_position_controller/commands`.
        names: its joints, in its order.
        states: where they are measured.
        rate: set-points a second.
    """

    def __init__(self, bus: Bus, topic: str, names: Sequence[str], states: JointStates, rate: float = RATE):
        super().__init__(names, states)
        self._topic, self._period = topic, 1.0 / rate
        self._writer = bus.writer(MESSAGE, topic)
        self._message = load_type(MESSAGE)
        self._way: _Way | None = None

    def stop(self) -> None:
        """Hold where the joints are, and end a motion under way; no set-point of it comes afterwards."""
        super().stop()
        if self._motion is not None:
            self._motion.wait(1.0)

    def passed(self) -> float | None:
        """Return for how long the motion under way has been followed [s]; see `ports.Steerable`."""
        way = self._way
        return None if way is None or way.over else way.passed()

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`."""
        way = self._way
        return way is not None and way.amend(tail, at)

    def expect(self, at: float | None) -> None:
        """Do nothing: its time is ours."""

    def _begin(self, trajectory: Trajectory) -> Operation[None]:
        stop, way = threading.Event(), _Way(trajectory)
        self._way = way
        done: Operation[None] = Operation(on_cancel=stop.set)
        threading.Thread(target=self._stream, args=(way, stop, done), name="grip_stream", daemon=True).start()
        return done

    def _stream(self, way: _Way, stop: threading.Event, done: Operation[None]) -> None:
        """Publish set-points in time; on a stop, where the joints hold."""
        try:
            order = [way.trajectory.names.index(name) for name in self._names]
            first = self._publish(way.trajectory.positions[0][order], 1)
            if not first.wait(6.0):
                raise ServerTimeOutError(f"{self._topic}: nobody listens")
            first.result()
            way.begin()
            while not way.ended():
                if stop.wait(self._period):
                    break
                way.sent = way.passed() + self._period
                self._publish(way.at(way.sent)[order].tolist(), 0)
            else:
                last, way.sent = way.trajectory.positions[-1][order], way.trajectory.duration
                self._publish(last.tolist(), 0).wait(1.0)
                settle(self.state, last, stop)
            way.over = True
            if stop.is_set():
                self._publish(self._rest(way)[order].tolist(), 0)
                done.fail(CanceledError("the motion was stopped"))
            else:
                done.succeed(None)
        except ServerTimeOutError as error:
            done.fail(ExecutionAbortedError(error.message, cause=error.code))
        except BaseException as error:  # noqa: BLE001 - of this thread; the owner has to hear of it
            done.fail(error)
        finally:
            way.over = True

    def _rest(self, way: _Way) -> np.ndarray:
        """Return where the joints hold on a stop, in the way's order: the last set-point; off the way, where they are.

        A measurement is late. Joints that follow were there a moment ago, and holding there would send them back.
        """
        last = way.at(way.sent)
        try:
            measured = self._states.state(way.trajectory.names).position
        except SensorError:
            return last  # the best that is known
        lately = np.stack([way.at(t) for t in np.linspace(max(0.0, way.sent - BEHIND), way.sent, 51)])
        return last if np.abs(lately - measured).max(axis=1).min() <= START_TOLERANCE else measured

    def _publish(self, positions: Sequence[float], subscribers: int) -> Operation[None]:
        return self._writer.publish(self._message(data=array("d", positions)), subscribers)


class _Way:
    """What is streamed: a trajectory that may be changed while its set-points are sent."""

    def __init__(self, trajectory: Trajectory):
        self._lock = threading.Lock()
        self._began: float | None = None
        self.trajectory, self.over = trajectory, False
        self.sent = 0.0
        """The time of the last set-point [s]."""

    def begin(self) -> None:
        self._began = time.monotonic()

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
