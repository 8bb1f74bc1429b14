"""`smach_ros` on ROS 2: everything goes over one bus, so that states need no node and nobody has to spin one."""

from __future__ import annotations

import array
import importlib
import math
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Header

from grip_bt.base.errors import GripError
from grip_bt.base.failures import GoalRejectedError, ServerLostError
from grip_bt.base.operation import Operation
from grip_bt.smach_compat.smach_ros._port import ServiceFailedError

from .client.bus import Bus
from .client.goal import GoalEnd
from .client.graph import topics
from .client.types import InterfaceType, Message, type_name
from .interfaces.build import ensure_package
from .smach_server import Shutdown, SimpleServer, ended

SLICE = 0.1
"""How often a wait looks whether ROS was shut down [s]."""
_STATUS = {
    "succeeded": GoalStatus.STATUS_SUCCEEDED,
    "aborted": GoalStatus.STATUS_ABORTED,
    "preempted": GoalStatus.STATUS_CANCELED,
}


def connect(domain_id: int | None = None, interface_cache: Path | None = None) -> RclpyConnection:
    """Return a connection with a bus of its own.

    Args:
        domain_id: the DDS domain; ROS_DOMAIN_ID by default.
        interface_cache: where smach_msgs is built, if it has to be; the user's cache by default.

    Raises:
        MissingPartError: there is no ROS 2.
    """
    return RclpyConnection(Bus("smach", domain_id=domain_id, watched=True), interface_cache)


class RclpyConnection:
    """The port of `smach_ros` over rclpy; see `grip_bt.smach_compat.smach_ros._port.Ros`.

    A node that a state was given says how names are resolved, and isn't used otherwise.
    """

    def __init__(self, bus: Bus, interface_cache: Path | None = None):
        self._bus, self._cache = bus, interface_cache
        self._shutdown = Shutdown()
        self._messages: SimpleNamespace | None = None
        logger = bus.node.get_logger()
        self.loggers = (
            lambda text: logger.info(str(text)),
            lambda text: logger.warning(str(text)),
            lambda text: logger.debug(str(text)),
            lambda text: logger.error(str(text)),
        )

    def close(self) -> None:
        """Leave ROS."""
        self._bus.close()

    def is_shutdown(self) -> bool:
        """Tell whether the program or the connection is over."""
        return self._bus.closed or self._shutdown.over()

    def on_shutdown(self, hook: Callable[[], None]) -> None:
        """Call `hook()` when a shutdown was asked for."""
        self._shutdown.add(hook)

    def now(self) -> float:
        """Return ROS's time [s]."""
        return float(self._bus.node.get_clock().now().nanoseconds) / 1e9

    def sleep(self, seconds: float) -> None:
        """Wait; a shutdown ends it."""
        end = self.now() + seconds
        while (left := end - self.now()) > 0 and not self.is_shutdown():
            self._shutdown.wait(min(left, SLICE))

    def subscribe(self, topic: str, type_: InterfaceType, callback: Callable[[Message], None]) -> _Topic:
        """Call `callback(message)` on the bus's thread for each message."""
        node = self._bus.node
        name = self.name_of(topic, None)
        made = self._bus.ask(lambda: node.create_subscription(type_, name, callback, 10))
        return _Topic(self._bus, made, node.destroy_subscription)

    def advertise(self, topic: str, type_: InterfaceType) -> _Topic:
        """Return a publisher."""
        node = self._bus.node
        name = self.name_of(topic, None)
        made = self._bus.ask(lambda: node.create_publisher(type_, name, 10))
        return _Topic(self._bus, made, node.destroy_publisher)

    def topics_of(self, type_: InterfaceType) -> list[str]:
        """Return the topics that somebody sends messages of a type on."""
        wanted, found = type_name(type_), self._bus.ask(lambda: topics(self._bus.node))
        return [name for name, types, _ in found if wanted in types]

    def service(self, name: str, type_: InterfaceType) -> _Service:
        """Return a client."""
        return _Service(self._bus, self.name_of(name, None), type_)

    def action_client(self, name: str, type_: InterfaceType) -> _ActionClient:
        """Return a client."""
        return _ActionClient(self._bus, self.name_of(name, None), type_)

    def action_server(
        self, name: str, type_: InterfaceType, execute: Callable[[Message], None], preempt: Callable[[], None]
    ) -> SimpleServer:
        """Return a server, not started."""
        return SimpleServer(self._bus, self.name_of(name, None), type_, execute, preempt)

    def introspection(self) -> SimpleNamespace:
        """Return smach_msgs; built once, in some 15 s, where no package of the name can be imported.

        Raises:
            MissingPartError: it has to be built and there is no compiler.
        """
        if self._messages is None:
            ensure_package("smach_msgs", self._cache)
            messages, clock = importlib.import_module("smach_msgs.msg"), self._bus.node.get_clock()
            self._messages = SimpleNamespace(
                Status=messages.SmachContainerStatus,
                Structure=messages.SmachContainerStructure,
                Command=messages.SmachContainerInitialStatusCmd,
                header=lambda: Header(stamp=clock.now().to_msg()),
                packed=lambda data: array.array("B", data),
                unpacked=bytes,
            )
        return self._messages

    def name_of(self, name: str, node: Node | None) -> str:
        """Return the full name, by the user's node where there is one."""
        return str((self._bus.node if node is None else node).resolve_topic_name(name))


class _Topic:
    def __init__(self, bus: Bus, entity: Any, destroy: Callable[[Any], object]):
        self._bus, self._entity, self._destroy = bus, entity, destroy

    def publish(self, message: Message) -> None:
        """Send a message; it is under way when this returns."""
        entity = self._entity
        if entity is not None:
            self._bus.post(lambda: entity.publish(message))

    def close(self) -> None:
        """Leave the topic."""
        entity, self._entity = self._entity, None
        if entity is not None:
            self._bus.post(lambda: self._destroy(entity))


class _Service:
    def __init__(self, bus: Bus, name: str, type_: InterfaceType):
        self._client = bus.service(type_, name)

    def wait(self, timeout: float) -> bool:
        """Tell whether there is a server within `timeout` [s]."""
        return _ready(self._client.wait_ready(timeout))

    def call(self, request: Message) -> Message:
        """Return the answer, however long it takes; the end of the server ends it."""
        try:
            return ended(self._client.call(request, timeout=math.inf))
        except (GripError, TypeError, AssertionError) as error:  # rclpy's, of a request that isn't one
            raise ServiceFailedError(str(error)) from error


class _ActionClient:
    def __init__(self, bus: Bus, name: str, type_: InterfaceType):
        self._client = bus.action(type_, name)
        if bus.watchdog is not None:
            bus.watchdog.expect_server(name)
        self._goal: Operation[GoalEnd] | None = None

    def wait(self, timeout: float) -> bool:
        """Tell whether there is a server within `timeout` [s]."""
        return _ready(self._client.wait_ready(timeout))

    def send(
        self, goal: Message, done: Callable[[str, int, Message | None], None], feedback: Callable[[Message], None]
    ) -> None:
        """Send a goal; noetic gives a server all the time it wants, and so does this."""
        operation = self._client.send(goal, timeout=math.inf, on_feedback=feedback, cancel_within=math.inf)
        self._goal = operation
        operation.add_done_callback(lambda: done(*_end_of(operation)))

    def cancel(self) -> None:
        """Ask the server to end the goal."""
        if self._goal is not None:
            self._goal.cancel()


def _ready(operation: Operation[None]) -> bool:
    try:
        ended(operation)
    except ServerLostError:
        return False
    return True


def _end_of(operation: Operation[GoalEnd]) -> tuple[str, int, Message | None]:
    """Return how a goal ended, as (ending, status, result)."""
    try:
        end = operation.result()
    except GoalRejectedError:
        return "rejected", GoalStatus.STATUS_UNKNOWN, None
    except Exception:  # noqa: BLE001 - whatever it was, nobody knows what became of the goal
        return "lost", GoalStatus.STATUS_UNKNOWN, None
    ending = "preempted" if end.status == "canceled" else end.status
    return ending, _STATUS[ending], end.result


class SmachNode(Node):
    """A node of the user's, for the user's own publishers, timers and so on; states don't need it.

    Args:
        **kwargs: see `rclpy.node.Node`.
    """

    def __init__(self, node_name: str, **kwargs: Any):
        super().__init__(node_name, **kwargs)
        self._spinner: threading.Thread | None = None

    def start(self) -> None:
        """Spin in a thread until ROS is shut down."""
        self._spinner = threading.Thread(target=self._spin, name=f"smach-{self.get_name()}", daemon=True)
        self._spinner.start()

    def _spin(self) -> None:
        executor = SingleThreadedExecutor(context=self.context)
        executor.add_node(self)
        try:
            while self.context.ok():
                executor.spin_once(timeout_sec=0.5)
        except ExternalShutdownException:
            pass
        finally:
            executor.shutdown()

    def join(self) -> None:
        """Wait until it has stopped spinning."""
        if self._spinner is not None:
            self._spinner.join()
