"""Simulated time: the clock of a run over the topic `/clock`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from .client.bus import Bus
from .client.topic import Received
from .convert_geometry import seconds

TOPIC, MESSAGE = "/clock", "rosgraph_msgs/msg/Clock"


class RosClock:
    """Implements `grip_bt.base.ports.Clock`: the simulator's time, 0 until it is first heard; never goes back.

    A simulator that starts again sends an earlier time: the clock then stands still until the simulator has caught up.

    Args:
        bus: the connection to ROS.
    """

    def __init__(self, bus: Bus):
        self._time = 0.0
        self._started = threading.Event()
        self._listeners: list[Callable[[], None]] = []
        self._bus, self._reader = bus, bus.reader(MESSAGE, TOPIC)
        self._reader.listen(self._received)

    def now(self) -> float:
        """Return the time [s]."""
        return self._time

    def wait_started(self, timeout: float) -> bool:
        """Wait until the time was heard; False after `timeout` [s] of the wall's time."""
        return self._started.wait(timeout)

    def publishers(self) -> str:
        """Say who publishes the time, and which topics are published instead."""
        return self._bus.ask(self._reader.publishers)

    def on_advance(self, listener: Callable[[], None]) -> None:
        """Have `listener()` called whenever time passes, on the bus's thread."""
        self._listeners.append(listener)

    def close(self) -> None:
        """Listen no more."""
        self._reader.ignore(self._received)

    def __enter__(self) -> RosClock:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _received(self, received: Received) -> None:
        self._hear(received.message)

    def _hear(self, message: Any) -> None:
        time = seconds(message.clock)
        self._started.set()
        if time > self._time:
            self._time = time
            for listener in list(self._listeners):
                listener()
