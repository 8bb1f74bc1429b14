"""A position controller that follows a topic: trajectories are sampled and streamed to it."""

from __future__ import annotations

import threading
import time
from array import array
from collections.abc import Sequence

import numpy as np

from grip_bt.errors import CanceledError, ExecutionAbortedError, SensorError, ServerTimeOutError
from grip_bt.operation import Operation
from grip_bt.values import JointState, Trajectory

from ..bus import Bus
from ..types import load_type
from .joint_states import JointStates
from .motion import RosExecutor

MESSAGE = "std_msgs/msg/Float64MultiArray"
RATE = 100.0
"""Set-points a second."""
REACHED = 1e-3
"""Joints so near to the last set-point are there [rad or m]."""
STILL = 0.3
"""Joints that were measured where they are for so long don't come nearer to it [s]."""
MOVED = 1e-4
"""A joint that moved less between two measurements stood still [rad or m]."""
SETTLE = 3.0
"""How long joints may take in all to catch up with the last set-point [s]."""


class StreamedExecutor(RosExecutor):
    """Implements `grip_bt.ports.Executor` over a joint group position controller.

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

    def stop(self) -> None:
        """Hold where the joints are, and end a motion under way; no set-point of it comes afterwards."""
        super().stop()
        if self._motion is not None:
            self._motion.wait(1.0)

    def _begin(self, trajectory: Trajectory) -> Operation[None]:
        stop = threading.Event()
        done: Operation[None] = Operation(on_cancel=stop.set)
        threading.Thread(target=self._stream, args=(trajectory, stop, done), name="grip_stream", daemon=True).start()
        return done

    def _stream(self, trajectory: Trajectory, stop: threading.Event, done: Operation[None]) -> None:
        """Publish set-points in time; on a stop, where the joints are measured to be."""
        try:
            order = [trajectory.names.index(name) for name in self._names]
            began = time.monotonic()
            first = self._publish(trajectory.positions[0][order], 1)
            if not first.wait(6.0):
                raise ServerTimeOutError(f"{self._topic}: nobody listens")
            first.result()
            began = time.monotonic()
            while (passed := time.monotonic() - began) < trajectory.duration:
                if stop.wait(self._period):
                    break
                self._publish(trajectory.at(passed + self._period)[order], 0)
            else:
                self._publish(trajectory.positions[-1][order], 0).wait(1.0)
                self._settle(trajectory.positions[-1][order], stop)
            if stop.is_set():
                self._publish(self.state().position, 0)
                done.fail(CanceledError("the motion was stopped"))
            else:
                done.succeed(None)
        except ServerTimeOutError as error:
            done.fail(ExecutionAbortedError(error.message, cause=error.code))
        except BaseException as error:  # noqa: BLE001 - of this thread; the owner has to hear of it
            done.fail(error)

    def _settle(self, target: np.ndarray, stop: threading.Event) -> None:
        """Wait until the joints are at `target` or stand still elsewhere, by the stamps of what is measured."""
        deadline = time.monotonic() + SETTLE
        moved: JointState | None = None
        while time.monotonic() < deadline and not stop.wait(self._period):
            try:
                now = self.state()
            except SensorError:
                return  # the measurement at the end says so
            if np.abs(now.position - target).max() <= REACHED:
                return
            if moved is None or np.abs(now.position - moved.position).max() > MOVED:
                moved = now
            elif now.time - moved.time > STILL:
                return

    def _publish(self, positions: Sequence[float], subscribers: int) -> Operation[None]:
        return self._writer.publish(self._message(data=array("d", positions)), subscribers)
