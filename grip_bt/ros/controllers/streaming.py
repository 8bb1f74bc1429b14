"""A position controller that follows a topic: trajectories are sampled and streamed to it, and so is braking."""

from __future__ import annotations

import threading
import time
from array import array
from collections.abc import Mapping, Sequence

import numpy as np

from grip_bt.commanders.steering import spliced
from grip_bt.commanders.trajectory.braking import accelerations_of, stop_ramp
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
        accelerations: joint -> limit, for braking; see `trajectory.braking.accelerations_of`.
    """

    def __init__(
        self,
        bus: Bus,
        topic: str,
        names: Sequence[str],
        states: JointStates,
        rate: float = RATE,
        accelerations: Mapping[str, float] | None = None,
    ):
        super().__init__(names, states)
        self._accelerations = accelerations or {}
        self._topic, self._period = topic, 1.0 / rate
        self._writer = bus.writer(MESSAGE, topic)
        self._message = load_type(MESSAGE)
        self._way: _Way | None = None

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
        self._way = way = _Way(trajectory)
        done: Operation[None] = Operation(on_cancel=way.stop.set)
        threading.Thread(target=self._stream, args=(way, done), name="grip_stream", daemon=True).start()
        return done

    def _drop(self) -> None:
        if self._way is not None:
            self._way.drop()

    def _stream(self, way: _Way, done: Operation[None]) -> None:
        """Publish set-points in time; on a stop, those of a ramp."""
        try:
            order = [way.trajectory.names.index(name) for name in self._names]
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
                done.fail(CanceledError("the motion was stopped"))
            else:
                done.succeed(None)
        except ServerTimeOutError as error:
            done.fail(ExecutionAbortedError(error.message, cause=error.code))
        except BaseException as error:  # noqa: BLE001 - of this thread; the owner has to hear of it
            done.fail(error)
        finally:
            way.leave()

    def _brake(self, way: _Way, order: list[int]) -> None:
        """Stream the ramp from the last set-point on; where something keeps the joints off their way, they stay there.

        A measurement is late. Joints that follow were there a moment ago, and holding there would send them back.
        """
        held = self._held_back(way)
        if held is not None and not way.dropped.is_set():
            self._publish(held[order].tolist(), 0)
            return
        limits = accelerations_of(way.trajectory.names, self._accelerations)
        ramp, began, passed = stop_ramp(way.trajectory, way.sent, limits), time.monotonic(), 0.0
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


class _Way:
    """What is streamed: a trajectory that may be changed while its set-points are sent."""

    def __init__(self, trajectory: Trajectory):
        self._lock = threading.Lock()
        self._began: float | None = None
        self.trajectory, self.over = trajectory, False
        self.stop, self.dropped, self._left = threading.Event(), threading.Event(), threading.Event()
        self.sent = 0.0
        """The time of the last set-point [s]."""

    def begin(self) -> None:
        self._began = time.monotonic()

    def drop(self) -> None:
        """Have no more set-points sent, and wait until that is so."""
        self.dropped.set()
        self.stop.set()
        self._left.wait(1.0)

    def leave(self) -> None:
        """Say that no more set-points are sent."""
        self.over = True
        self._left.set()

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
