"""An action server on rclpy that works as actionlib's SimpleActionServer: one goal at a time, on its own thread."""

from __future__ import annotations

import queue
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any, NamedTuple, TypeVar

from action_msgs.msg import GoalStatus
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.task import Future
from rclpy.utilities import get_default_context

from grip_bt.base.operation import Operation

from .client.bus import Bus
from .client.types import InterfaceType, Message

T = TypeVar("T")


def ended(operation: Operation[T]) -> T:
    """Wait for an operation's end and return its result; for threads that may block, as those of SMACH do."""
    operation.wait()
    return operation.result()


class _Work(NamedTuple):
    handle: ServerGoalHandle
    future: Future


class SimpleServer:
    """Serves one action; see `grip_bt.smach_compat.smach_ros._port.ActionServer`.

    A goal that comes while another is being worked on preempts that one, and waits for its end.
    """

    def __init__(
        self,
        bus: Bus,
        name: str,
        type_: InterfaceType,
        execute: Callable[[Message], object],
        preempt: Callable[[], object],
    ):
        self._bus, self._name, self._type = bus, name, type_
        self._execute, self._preempt = execute, preempt
        self._queue: queue.SimpleQueue[_Work] = queue.SimpleQueue()
        self._current: _Work | None = None
        self._server: ActionServer | None = None
        self._lock = threading.Lock()

    # --- from any thread ---

    def start(self) -> None:
        """Take goals."""
        self._bus.ask(self._create)
        threading.Thread(target=self._work, name=f"smach-server {self._name}", daemon=True).start()

    def feedback(self, message: Message) -> None:
        """Send feedback on the goal being worked on."""
        work = self._current
        if work is not None:
            self._bus.post(lambda: work.handle.is_active and work.handle.publish_feedback(message))

    def end(self, ending: str, result: Message | None = None) -> None:
        """End the goal being worked on; `preempted` becomes `aborted` where its client hasn't canceled it."""
        work = self._current
        if work is not None:
            self._bus.ask(lambda: self._end(work, ending, result))

    # --- the worker ---

    def _work(self) -> None:
        while not self._bus.closed:
            work = self._queue.get()
            with self._lock:
                self._current = work
                asked = work.handle.is_cancel_requested or not self._queue.empty()
            self._bus.ask(work.handle.execute)
            if asked:
                self._ask()
            try:
                self._execute(work.handle.request)
            finally:
                self.end("aborted")  # nothing when it was ended, as it should be
                with self._lock:
                    self._current = None

    def _ask(self) -> None:
        """Ask for the end of the goal; not on the bus's thread, since a machine may take its time to hear it."""
        threading.Thread(target=self._preempt, name=f"smach-preempt {self._name}", daemon=True).start()

    # --- on the bus's thread ---

    def _create(self) -> None:
        self._server = ActionServer(
            self._bus.node,
            self._type,
            self._name,
            execute_callback=self._ended,
            goal_callback=lambda goal: GoalResponse.ACCEPT,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._canceled,
        )
        self._futures: dict[bytes, Future] = {}

    def _accepted(self, handle: ServerGoalHandle) -> None:
        future = self._futures[bytes(handle.goal_id.uuid)] = Future(executor=self._bus.node.executor)
        with self._lock:
            self._queue.put(_Work(handle, future))
            # A goal that has its result is over, though its thread may not have come back from telling it.
            busy = self._current is not None and not self._current.future.done()
        if busy:
            self._ask()

    def _canceled(self, handle: ServerGoalHandle) -> CancelResponse:
        with self._lock:
            current = self._current is not None and self._current.handle.goal_id == handle.goal_id
        if current:
            self._ask()
        return CancelResponse.ACCEPT

    async def _ended(self, handle: ServerGoalHandle) -> Message:
        """Hand rclpy the result when there is one; awaited, so that the bus goes on meanwhile."""
        key = bytes(handle.goal_id.uuid)
        try:
            return await self._futures[key]
        finally:
            del self._futures[key]

    def _end(self, work: _Work, ending: str, result: Message | None) -> None:
        if work.future.done():
            return
        if ending == "succeeded":
            work.handle.succeed()
        elif ending == "preempted" and work.handle.status == GoalStatus.STATUS_CANCELING:
            work.handle.canceled()
        else:
            work.handle.abort()
        work.future.set_result(self._type.Result() if result is None else result)


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
        """Tell whether it is over."""
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
        """Wait; a shutdown by signal ends it."""
        self._over.wait(max(0.0, seconds))

    def _interrupted(self, number: int, frame: FrameType | None) -> None:
        for signal_number, previous in self._previous.items():
            signal.signal(signal_number, previous)
        # Hooks wait for machines, and the main thread may be what executes them.
        threading.Thread(target=self.begin, name="smach-shutdown").start()

    def begin(self) -> None:
        """Shut down, from now on."""
        try:
            for hook in self._hooks:
                hook()
        finally:
            self._over.set()
