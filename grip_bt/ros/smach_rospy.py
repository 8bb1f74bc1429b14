"""`smach_ros` on ROS 1: rospy and actionlib, where they can be imported."""

from __future__ import annotations

import base64
import importlib
import threading
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

from grip_bt.smach_compat.smach_ros._port import ServiceFailedError

Callback = Callable[[Any], None]
_ENDINGS = {2: "preempted", 3: "succeeded", 4: "aborted", 5: "rejected", 9: "lost"}
"""actionlib's GoalStatus, of a goal that has ended."""


def connect(find: Callable[[str], ModuleType] = importlib.import_module) -> RospyConnection:
    """Return the connection; the program itself calls `rospy.init_node`, as any ROS 1 program does.

    Args:
        find: gives a module of ROS 1 by name.
    """
    return RospyConnection(find)


class RospyConnection:
    """The port of `smach_ros` over rospy; see `grip_bt.smach_compat.smach_ros._port.Ros`."""

    def __init__(self, find: Callable[[str], ModuleType]):
        self._find = find
        self._rospy = rospy = find("rospy")
        self._actionlib = find("actionlib")
        self.loggers = (rospy.loginfo, rospy.logwarn, rospy.logdebug, rospy.logerr)

    def is_shutdown(self) -> bool:
        """Tell whether rospy is being shut down."""
        return bool(self._rospy.is_shutdown())

    def on_shutdown(self, hook: Callable[[], None]) -> None:
        """Call `hook()` before rospy ends."""
        self._rospy.core.add_client_shutdown_hook(hook)

    def now(self) -> float:
        """Return ROS's time [s]."""
        return float(self._rospy.get_rostime().to_sec())

    def sleep(self, seconds: float) -> None:
        """Wait; a shutdown ends it."""
        try:
            self._rospy.sleep(seconds)
        except self._rospy.ROSInterruptException:
            return

    def subscribe(self, topic: str, type_: type, callback: Callback) -> _Closable:
        """Call `callback(message)` for each message."""
        return _Closable(self._rospy.Subscriber(topic, type_, callback).unregister)

    def advertise(self, topic: str, type_: type) -> _Publisher:
        """Return a publisher."""
        return _Publisher(self._rospy.Publisher(topic, type_, queue_size=1))

    def topics_of(self, type_: Any) -> list[str]:
        """Return the topics of a message type."""
        return list(self._find("rostopic").find_by_type(type_._type))

    def service(self, name: str, type_: type) -> _Service:
        """Return a client."""
        return _Service(self._rospy, name, type_)

    def action_client(self, name: str, type_: type) -> _ActionClient:
        """Return a client."""
        return _ActionClient(self._rospy, self._actionlib, name, type_)

    def action_server(self, name: str, type_: type, execute: Callback, preempt: Callable[[], None]) -> _ActionServer:
        """Return a server, not started."""
        return _ActionServer(self._actionlib, name, type_, execute, preempt)

    def introspection(self) -> SimpleNamespace:
        """Return smach_msgs, with userdata as text in base64."""
        messages, header = self._find("smach_msgs.msg"), self._find("std_msgs.msg").Header
        return SimpleNamespace(
            Status=messages.SmachContainerStatus,
            Structure=messages.SmachContainerStructure,
            Command=messages.SmachContainerInitialStatusCmd,
            header=lambda: header(stamp=self._rospy.get_rostime()),
            packed=lambda data: base64.b64encode(data).decode(),
            unpacked=base64.b64decode,
        )

    def name_of(self, name: str, node: object) -> str:
        """Return the name as it is: rospy resolves it."""
        return name


class _Closable:
    def __init__(self, close: Callable[[], None]):
        self.close = close


class _Publisher:
    def __init__(self, publisher: Any):
        self.publish, self.close = publisher.publish, publisher.unregister


class _Service:
    def __init__(self, rospy: ModuleType, name: str, type_: type):
        self._rospy, self._name = rospy, name
        self._proxy = rospy.ServiceProxy(name, type_)

    def wait(self, timeout: float) -> bool:
        """Tell whether there is a server within `timeout` [s]."""
        try:
            self._rospy.wait_for_service(self._name, timeout)
        except self._rospy.ROSException:
            return False
        return True

    def call(self, request: object) -> Any:
        """Return the answer."""
        try:
            return self._proxy(request)
        except self._rospy.ServiceException as error:
            raise ServiceFailedError(str(error)) from error


class _ActionClient:
    def __init__(self, rospy: ModuleType, actionlib: ModuleType, name: str, type_: type):
        self._duration = rospy.Duration
        self._client = actionlib.SimpleActionClient(name, type_)
        self._sent = threading.Event()

    def wait(self, timeout: float) -> bool:
        """Tell whether there is a server within `timeout` [s]; of 0 actionlib makes "for ever"."""
        return bool(self._client.wait_for_server(self._duration(max(timeout, 0.01))))

    def send(self, goal: object, done: Callable[[str, int, Any], None], feedback: Callback) -> None:
        """Send a goal."""
        self._client.send_goal(
            goal,
            lambda status, result: done(_ENDINGS.get(status, "aborted"), status, result),
            None,
            feedback,
        )
        self._sent.set()

    def cancel(self) -> None:
        """Ask the server to end the goal."""
        if self._sent.is_set():
            self._client.cancel_goal()


class _ActionServer:
    def __init__(
        self,
        actionlib: ModuleType,
        name: str,
        type_: type,
        execute: Callback,
        preempt: Callable[[], None],
    ):
        self._server = actionlib.SimpleActionServer(name, type_, execute_cb=execute, auto_start=False)
        self._server.register_preempt_callback(preempt)

    def start(self) -> None:
        """Take goals."""
        self._server.start()

    def feedback(self, message: object) -> None:
        """Send feedback."""
        self._server.publish_feedback(message)

    def end(self, ending: str, result: object = None) -> None:
        """End the goal."""
        finish = {
            "succeeded": self._server.set_succeeded,
            "preempted": self._server.set_preempted,
            "aborted": self._server.set_aborted,
        }[ending]
        finish(result)
