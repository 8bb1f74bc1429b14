"""`smach_ros` on ROS 2: everything goes over one bus, so that states need no node and nobody has to spin one."""

from __future__ import annotations

import array
import importlib
import math
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import TransformStamped
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from rclpy.time import Time as RclpyTime
from std_msgs.msg import Header

from grip_bt.base.errors import GripError
from grip_bt.base.failures import GoalRejectedError, ServerLostError
from grip_bt.base.operation import Operation
from grip_bt.smach_compat.smach_ros._connection import PROVIDED
from grip_bt.smach_compat.smach_ros._port import ActionClient, End, NoFrameError, Ros, Service, ServiceFailedError
from grip_bt.smach_compat.smach_ros.introspection import IntrospectionServer

from .client.bus import Bus
from .client.goal import GoalEnd
from .client.graph import topics
from .client.types import InterfaceType, Message, load_type, type_name
from .interfaces.build import ensure_package
from .smach_server import Shutdown, SimpleServer, ended
from .transforms import MESSAGE, Transforms

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


class RclpyConnection(Ros):
    """ROS 2 for `smach_ros` and `rospy`.

    A node that a state was given says how names are resolved, and isn't used otherwise.
    """

    def __init__(self, bus: Bus, interface_cache: Path | None = None):
        super().__init__()
        self._bus, self._cache = bus, interface_cache
        self._shutdown = Shutdown()
        self._transforms = Transforms(bus)
        self._tf: End | None = None
        self._messages: SimpleNamespace | None = None
        logger = bus.node.get_logger()
        self.loggers = (
            lambda text: logger.info(str(text)),
            lambda text: logger.warning(str(text)),
            lambda text: logger.debug(str(text)),
            lambda text: logger.error(str(text)),
        )

    def close(self) -> None:
        self._bus.close()

    def is_shutdown(self) -> bool:
        return self._bus.closed or self._shutdown.over()

    def on_shutdown(self, hook: Callable[[], None]) -> None:
        self._shutdown.add(hook)

    def shut_down(self, reason: str = "") -> None:
        self._shutdown.begin()

    def spin(self) -> None:
        while not self.is_shutdown():
            self._shutdown.wait(SLICE)

    def now(self) -> float:
        return float(self._bus.node.get_clock().now().nanoseconds) / 1e9

    def sleep(self, seconds: float) -> None:
        end = self.now() + seconds
        while (left := end - self.now()) > 0 and not self.is_shutdown():
            self._shutdown.wait(min(left, SLICE))

    def subscribe(self, topic: str, type_: InterfaceType, callback: Callable[[Message], None]) -> End:
        node, name = self._bus.node, self.name_of(topic, None)
        made = self._bus.ask(lambda: node.create_subscription(type_, name, callback, 10))
        return self._end(made, node.destroy_subscription)

    def advertise(self, topic: str, type_: InterfaceType) -> End:
        """Return a publisher; what it publishes is under way when that returns."""
        node, name = self._bus.node, self.name_of(topic, None)
        made = self._bus.ask(lambda: node.create_publisher(type_, name, 10))
        return self._end(made, node.destroy_publisher, made.publish, lambda: int(made.get_subscription_count()))

    def _end(
        self,
        made: object,
        destroy: Callable[[Any], object],
        send: Callable[[Message], None] | None = None,
        listeners: Callable[[], int] = int,
    ) -> End:
        closed = threading.Event()

        def close() -> None:
            if not closed.is_set():
                closed.set()
                self._bus.post(lambda: destroy(made))

        def publish(message: Message) -> None:
            if send is not None and not closed.is_set():
                self._bus.post(lambda: send(message))

        return End(close, publish, listeners)

    def topics_of(self, type_: InterfaceType) -> list[str]:
        wanted, found = type_name(type_), self._bus.ask(lambda: topics(self._bus.node))
        return [name for name, types, _ in found if wanted in types]

    def wait_for_server(self, name: str, timeout: float) -> bool:
        wanted = {name, f"{name}/_action/send_goal"}
        end = self.now() + timeout
        while not wanted & {service for service, _ in self._bus.ask(self._bus.node.get_service_names_and_types)}:
            if self.now() >= end or self.is_shutdown():
                return False
            self.sleep(SLICE)
        return True

    def service(self, name: str, type_: InterfaceType) -> _Service:
        return _Service(self, self._bus, self.name_of(name, None), type_)

    def serve(self, name: str, type_: InterfaceType, answer: Callable[[Message], Message]) -> End:
        """Answer requests by a function, each on a thread of its own; one that raises gives no answer."""
        node, full = self._bus.node, self.name_of(name, None)

        async def served(request: Message, response: Message) -> Message:
            future = Future(executor=node.executor)

            def work() -> None:
                try:
                    future.set_result(answer(request))
                except Exception as error:  # noqa: BLE001 - the program's own
                    self.loggers[3](f"service {full}: {error!r}")
                    future.set_exception(error)

            threading.Thread(target=work, name=f"service {full}", daemon=True).start()
            return await future

        made: Any = self._bus.ask(lambda: node.create_service(type_, full, served))  # type: ignore[misc]
        return self._end(made, node.destroy_service)

    def action_client(self, name: str, type_: InterfaceType) -> _ActionClient:
        return _ActionClient(self, self._bus, self.name_of(name, None), type_)

    def action_server(
        self, name: str, type_: InterfaceType, execute: Callable[[Message], None], preempt: Callable[[], None]
    ) -> SimpleServer:
        return SimpleServer(self, self._bus, self.name_of(name, None), type_, execute, preempt)

    def transform(
        self, target: str, source: str, at: float | None, timeout: float
    ) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
        ensure_package("tf2_msgs", self._cache)
        try:
            pose = ended(self._transforms.lookup(target, source, timeout, at))
        except GripError as error:
            raise NoFrameError(str(error)) from error
        (x, y, z), (qw, qx, qy, qz) = map(float, pose.position), map(float, pose.quaternion)
        return (x, y, z), (qx, qy, qz, qw)

    def broadcast(
        self, parent: str, child: str, move: tuple[float, ...], turn: tuple[float, ...], stamp: float
    ) -> None:
        ensure_package("tf2_msgs", self._cache)
        if self._tf is None:
            self._tf = self.advertise("/tf", load_type(MESSAGE))
        made = TransformStamped(child_frame_id=child)
        made.header.frame_id, made.header.stamp = parent, RclpyTime(nanoseconds=round(stamp * 1e9)).to_msg()
        for axis, value in zip("xyz", move, strict=True):
            setattr(made.transform.translation, axis, float(value))
        for axis, value in zip("xyzw", turn, strict=True):
            setattr(made.transform.rotation, axis, float(value))
        self._tf.publish(load_type(MESSAGE)(transforms=[made]))

    def introspection(self) -> SimpleNamespace:
        """Return smach_msgs; built once, in some 15 s, where no package of the name can be imported."""
        if self._messages is None:
            PROVIDED.end()
            ensure_package("smach_msgs", self._cache)
            messages, clock = importlib.import_module("smach_msgs.msg"), self._bus.node.get_clock()
            self._messages = SimpleNamespace(
                Status=messages.SmachContainerStatus,
                Structure=messages.SmachContainerStructure,
                InitialStatusCmd=messages.SmachContainerInitialStatusCmd,
                header=lambda: Header(stamp=clock.now().to_msg()),
                packed=lambda data: array.array("B", data),
                unpacked=bytes,
            )
        return self._messages

    def name_of(self, name: str, node: Any) -> str:
        return str((self._bus.node if node is None else node).resolve_topic_name(name))


class _Service(Service):
    def __init__(self, ros: Ros, bus: Bus, name: str, type_: InterfaceType):
        super().__init__(ros, name, type_)
        self._client = bus.service(type_, name)

    def wait(self, timeout: float) -> bool:
        return _ready(self._client.wait_ready(timeout))

    def call(self, request: Message) -> Message:
        """Return the answer, however long it takes; the end of the server ends it."""
        try:
            return ended(self._client.call(request, timeout=math.inf))
        except (GripError, TypeError, AssertionError) as error:  # rclpy's, of a request that isn't one
            raise ServiceFailedError(str(error)) from error


class _ActionClient(ActionClient):
    def __init__(self, ros: Ros, bus: Bus, name: str, type_: InterfaceType):
        super().__init__(ros, name, type_)
        self._client = bus.action(type_, name)
        if bus.watchdog is not None:
            bus.watchdog.expect_server(name)
        self._sent: Operation[GoalEnd] | None = None

    def wait(self, timeout: float) -> bool:
        return _ready(self._client.wait_ready(timeout))

    def send(self, goal: Message, done: Callable[[str, int, Any], None], feedback: Callable[[Message], None]) -> None:
        """Send a goal; noetic gives a server all the time it wants, and so does this."""
        operation = self._client.send(goal, timeout=math.inf, on_feedback=feedback, cancel_within=math.inf)
        self._sent = operation
        operation.add_done_callback(lambda: done(*_end_of(operation)))

    def cancel(self) -> None:
        if self._sent is not None:
            self._sent.cancel()


def _ready(operation: Operation[None]) -> bool:
    try:
        ended(operation)
    except ServerLostError:
        return False
    return True


def _end_of(operation: Operation[GoalEnd]) -> tuple[str, int, Message | None]:
    try:
        end = operation.result()
    except GoalRejectedError:
        return "rejected", GoalStatus.STATUS_UNKNOWN, None
    except Exception:  # noqa: BLE001 - whatever it was, nobody knows what became of the goal
        return "lost", GoalStatus.STATUS_UNKNOWN, None
    ending = "preempted" if end.status == "canceled" else end.status
    return ending, _STATUS[ending], end.result


class IntrospectionServerNode(IntrospectionServer, Node):
    """ROS 2's: a node that puts a container, and those inside it, on the network."""

    def __init__(self, server_name: str, state: object, path: str):
        Node.__init__(self, server_name)
        IntrospectionServer.__init__(self, self, server_name, state, path)


class SmachNode(Node):
    """A node of the user's, for the user's own publishers, timers and so on; states don't need it."""

    _spinner: threading.Thread | None = None

    def start(self) -> None:
        """Spin in a thread until ROS is shut down."""
        self._spinner = threading.Thread(target=self._spin, name=f"smach-{self.get_name()}", daemon=True)
        self._spinner.start()

    def _spin(self) -> None:
        executor = SingleThreadedExecutor(context=self.context)
        executor.add_node(self)
        with suppress(ExternalShutdownException):
            while self.context.ok():
                executor.spin_once(timeout_sec=0.5)
        executor.shutdown()

    def join(self) -> None:
        if self._spinner is not None:
            self._spinner.join()
