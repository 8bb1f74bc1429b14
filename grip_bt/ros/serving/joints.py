"""Measured joints as `sensor_msgs/msg/JointState`, so often a second."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

from grip_bt.base.errors import GripError
from grip_bt.base.ports import Executor

from ..bus import Bus
from ..convert_geometry import header

TYPE = "sensor_msgs/msg/JointState"


class ServedJoints:
    """Publishes where joints are, stamped with the wall's time, in one message for all of them.

    Args:
        bus: the connection to ROS.
        topic: such as `/joint_states`.
        executors: which measure them.
        rate: messages a second.
    """

    def __init__(self, bus: Bus, topic: str, executors: Sequence[Executor], rate: float = 50.0):
        self._writer, self._executors, self._period = bus.writer(TYPE, topic), executors, 1 / rate
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._publish, name="grip_joint_states", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Publish no more."""
        self._closed.set()
        self._thread.join(2.0)

    def _publish(self) -> None:
        due = time.monotonic()
        while not self._closed.wait(max(0.0, due - time.monotonic())):
            due = max(due + self._period, time.monotonic())
            try:
                self._writer.publish(self._message())
            except GripError:
                return  # what measures has ended; whoever runs it says so

    def _message(self) -> object:
        stamp, states = time.time(), [executor.state() for executor in self._executors]
        message = self._writer.type(header=header("", stamp))
        message.name = [name for state in states for name in state.names]
        message.position = [float(value) for state in states for value in state.position]
        for field in ("velocity", "effort"):
            known = [getattr(state, field) for state in states]
            if all(values is not None for values in known):
                setattr(message, field, [float(value) for values in known for value in values])
        return message
