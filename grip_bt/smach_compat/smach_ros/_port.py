"""What `smach_ros` asks of ROS: a small port with an adapter for rclpy and one for rospy (`grip_bt.ros.smach*`).

All callbacks come on threads of the adapter. Times are seconds of ROS time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

Logger = Callable[[object], object]


class ServiceFailedError(Exception):
    """A service call ended without an answer."""


class Closable(Protocol):
    """A subscription or publisher."""

    def close(self) -> None:
        """Leave the topic."""


class Publisher(Closable, Protocol):
    """Sends on one topic."""

    def publish(self, message: object) -> None:
        """Send a message to who is there."""


class Service(Protocol):
    """The client of a service."""

    def wait(self, timeout: float) -> bool:
        """Tell whether there is a server within `timeout` [s]."""

    def call(self, request: object) -> Any:
        """Return the answer, or raise ServiceFailedError."""


class ActionClient(Protocol):
    """The client of an action, one goal at a time."""

    def wait(self, timeout: float) -> bool:
        """Tell whether there is a server within `timeout` [s]."""

    def send(self, goal: object, done: Callable[[str, int, object], None], feedback: Callable[[object], None]) -> None:
        """Send a goal and return at once; `done(ending, status, result)` is called once.

        `ending` is `succeeded`, `aborted`, `preempted`, `rejected` or `lost`, `status` this ROS's number for it.
        """

    def cancel(self) -> None:
        """Ask the server to end the goal; harmless when there is none."""


class ActionServer(Protocol):
    """A server of one action, one goal at a time: a new goal preempts the one that is being worked on."""

    def start(self) -> None:
        """Take goals from now on."""

    def feedback(self, message: object) -> None:
        """Send feedback on the goal being worked on; nothing when there is none."""

    def end(self, ending: str, result: object = None) -> None:
        """End the goal being worked on as `succeeded`, `aborted` or `preempted`."""


class Introspection(Protocol):
    """The messages of smach_msgs as this ROS has them."""

    Status: Any
    Structure: Any
    Command: Any

    def header(self) -> Any:
        """Return a header with the time."""

    def packed(self, data: bytes) -> Any:
        """Return bytes as the field `local_data` has them."""

    def unpacked(self, local_data: object) -> bytes:
        """Return the bytes of a field `local_data`."""


class Ros(Protocol):
    """One process's ROS."""

    loggers: Sequence[Logger]
    """Where info, warnings, debugging and errors go, in the order of `smach.set_loggers`."""

    def is_shutdown(self) -> bool:
        """Tell whether ROS is being shut down."""

    def on_shutdown(self, hook: Callable[[], None]) -> None:
        """Call `hook()` when a shutdown was asked for, while ROS still works."""

    def now(self) -> float:
        """Return the time [s]."""

    def sleep(self, seconds: float) -> None:
        """Wait; less when ROS is shut down meanwhile."""

    def subscribe(self, topic: str, type_: object, callback: Callable[[object], None]) -> Closable:
        """Call `callback(message)` for each message."""

    def advertise(self, topic: str, type_: object) -> Publisher:
        """Return a publisher."""

    def topics_of(self, type_: object) -> list[str]:
        """Return the names of the topics that somebody sends messages of a type on."""

    def service(self, name: str, type_: object) -> Service:
        """Return a client."""

    def action_client(self, name: str, type_: object) -> ActionClient:
        """Return a client."""

    def action_server(
        self, name: str, type_: object, execute: Callable[[object], None], preempt: Callable[[], None]
    ) -> ActionServer:
        """Return a server, not started.

        It calls `execute` with each goal on a thread of its own, which has to call `end`; and `preempt` when the goal
        being worked on was canceled or another one came.
        """

    def introspection(self) -> Introspection:
        """Return the messages of smach_msgs."""

    def name_of(self, name: str, node: object) -> str:
        """Return the full name of a topic, service or action as a node of the user's would have it."""
