"""An action server on rclpy that works as actionlib's SimpleActionServer: one goal at a time, on its own thread."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any, TypeVar

from action_msgs.msg import GoalStatus
from rclpy.action.server import ActionServer as RclpyServer
from rclpy.action.server import CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.task import Future
from rclpy.utilities import get_default_context

from grip_bt.base.operation import Operation
from grip_bt.smach_compat.smach_ros._port import ActionServer, Goal, Ros

from .client.bus import Bus
from .client.types import InterfaceType, Message

T = TypeVar("T")


def ended(operation: Operation[T]) -> T:
    """Wait for an operation's end and return its result; for threads that may block, as those of SMACH do."""
    operation.wait()
    return operation.result()


class _Served(Goal):
    """A goal of rclpy's; its result is handed over by a future."""

    def __init__(self, bus: Bus, handle: ServerGoalHandle, empty: Callable[[], Message]):
        super().__init__(handle.request, lambda ending, status, result: None, self._tell)
        self._bus, self._handle, self._empty = bus, handle, empty
        self.future = Future(executor=bus.node.executor)

    def begin(self) -> None:
        self.canceled = self._handle.is_cancel_requested
        self._bus.ask(self._handle.execute)

    def _tell(self, message: Message) -> None:
        self._bus.post(lambda: self._handle.is_active and self._handle.publish_feedback(message))

    def end(self, ending: str, result: Any) -> None:
        """End it; `preempted` becomes `aborted` where its client hasn't canceled it."""
        self._bus.ask(lambda: self._end(ending, result))

    def _end(self, ending: str, result: Message | None) -> None:
        if self.over:
            return
        self.over = True
        if ending == "succeeded":
            self._handle.succeed()
        elif ending == "preempted" and self._handle.status == GoalStatus.STATUS_CANCELING:
            self._handle.canceled()
        else:
            self._handle.abort()
        self.future.set_result(self._empty() if result is None else result)


class SimpleServer(ActionServer):
    """Serves one action of rclpy, one goal at a time."""

    def __init__(
        self,
        ros: Ros,
        bus: Bus,
        name: str,
        type_: InterfaceType,
        execute: Callable[[Message], None],
        preempt: Callable[[], None],
    ):
        super().__init__(ros, name, execute, preempt)
        self._bus, self._type = bus, type_
        self._served: dict[bytes, _Served] = {}

    def start(self) -> None:
        self._bus.ask(self._create)
        super().start()

    def _create(self) -> None:
        self._server = RclpyServer(
            self._bus.node,
            self._type,
            self._name,
            execute_callback=self._ended,
            goal_callback=lambda goal: GoalResponse.ACCEPT,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._canceled,
        )

    def _accepted(self, handle: ServerGoalHandle) -> None:
        served = self._served[bytes(handle.goal_id.uuid)] = _Served(self._bus, handle, self._type.Result)
        self.take(served)

    def _canceled(self, handle: ServerGoalHandle) -> CancelResponse:
        self.canceled(self._served[bytes(handle.goal_id.uuid)])
        return CancelResponse.ACCEPT

    async def _ended(self, handle: ServerGoalHandle) -> Message:
        """Hand rclpy the result when there is one; awaited, so that the bus goes on meanwhile."""
        key = bytes(handle.goal_id.uuid)
        try:
            return await self._served[key].future
        finally:
            del self._served[key]


class Shutdown:
    """Whether the program is being shut down, and what to do then.

    A program that has called `rclpy.init` is shut down with rclpy's own context. In one that hasn't, as programs in
    ROS 1's style, hooks are called at the first SIGINT or SIGTERM, as rospy does; a second one acts as ever.
    """

    def __init__(self) -> None:
        self._hooks: list[Callable[[], None]] = []
        self._over = threading.Event()
        self._context_was_up = False
        self._previous: dict[int, Any] = {}

    def over(self) -> bool:
        up = bool(get_default_context().ok())
        self._context_was_up = self._context_was_up or up
        return self._over.is_set() or (self._context_was_up and not up)

    def add(self, hook: Callable[[], None]) -> None:
        """Call `hook()` when a shutdown was asked for."""
        context = get_default_context()
        if context.ok():
            self._context_was_up = True
            context.on_shutdown(hook)
            return
        self._hooks.append(hook)
        if not self._previous and threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._previous[number] = signal.signal(number, self._interrupted)

    def wait(self, seconds: float) -> None:
        self._over.wait(max(0.0, seconds))

    def _interrupted(self, number: int, frame: FrameType | None) -> None:
        for signal_number, previous in self._previous.items():
            signal.signal(signal_number, previous)
        # Hooks wait for machines, and the main thread may be what executes them.
        threading.Thread(target=self.begin, name="smach-shutdown").start()

    def begin(self) -> None:
        try:
            for hook in self._hooks:
                hook()
        finally:
            self._over.set()
