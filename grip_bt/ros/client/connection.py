"""A node of this process with its thread: one context, one executor, one thread that is joined, for its life.

Every rclpy entity is created, used and destroyed on that thread, because rclpy's clients aren't safe elsewhere.

The thread is a daemon *and* joined by `close`, which also runs at exit: a daemon thread that is still inside rcl_wait
when the interpreter ends aborts it, and one that isn't a daemon keeps it alive after an uncaught error. A forked child
must leave the connection alone and end by `os._exit`, as multiprocessing's does: DDS would join threads that aren't
there.
"""

from __future__ import annotations

import atexit
import logging
import os
import threading
import time
import warnings
import weakref
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Any, TypeVar

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import ok

from grip_bt.base.failures import CanceledError
from grip_bt.base.files import Closing
from grip_bt.base.operation import Operation

from ..environment import require, sweep
from ..watchdog import Watchdog, shared

if TYPE_CHECKING:
    from .base import Client

T = TypeVar("T")
PERIOD = 0.02
"""How often what is under way is looked at [s]; nothing is looked at while there is nothing."""
LETTING_GO = 1.0
"""How long closing waits for action servers to hear that their goals are canceled [s]."""

_log = logging.getLogger("grip.ros")


class Connection(Closing):
    """A ROS node with its thread.

    Args:
        domain_id: the DDS domain; ROS_DOMAIN_ID, else 0, by default.
        watched: whether goals that it sends, which may move something, are ended when this process has died.

    Attributes:
        timeout: how long a call or a goal may take in all, where nothing else is said [s].
        wait: how long to wait for a server, a message or subscribers, where nothing else is said [s].
    """

    timeout, wait = 30.0, 5.0

    def __init__(self, name: str = "grip", domain_id: int | None = None, watched: bool = False):
        require()
        self._watched, self._watchdogs = watched, ExitStack()
        self._watchdog: Watchdog | None = None
        sweep()
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain_id, signal_handler_options=SignalHandlerOptions.NO)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a parser that a node loads
            self.node = Node(name, context=self._context, start_parameter_services=False, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._posted: set[Operation[Any]] = set()
        self._queue: deque[Callable[[], None]] = deque()
        self._closing, self._stopped = False, False
        self._ended_all = threading.Event()
        self._lock = threading.Lock()
        self._process = os.getpid()
        self._timer = self.node.create_timer(PERIOD, self._poll)
        self._timer.cancel()
        self._thread = threading.Thread(target=self._spin, name=f"ros-{name}", daemon=True)
        self._thread.start()
        closing = weakref.WeakMethod(self.close)
        self._at_exit = lambda: (close := closing()) and close()  # doesn't keep the connection alive until then
        atexit.register(self._at_exit)

    # --- for everybody ---

    @property
    def domain_id(self) -> int:
        return int(self._context.get_domain_id())

    @property
    def watchdog(self) -> Watchdog | None:
        """What is told of all that is under way and may move something; it is started when it is first asked for."""
        if self._watched and self._watchdog is None:
            with self._lock:
                if self._watchdog is None and not self._closing:
                    self._watchdog = self._watchdogs.enter_context(shared(self.domain_id))
        return self._watchdog

    def post(self, work: Callable[[], T]) -> Operation[T]:
        """Run `work` on the connection's thread, in the order of the calls; at once when called from there."""
        operation: Operation[T] = Operation()

        def run() -> None:
            self._posted.discard(operation)
            if operation.done():
                return
            try:
                operation.succeed(work())
            except BaseException as error:  # noqa: BLE001 - handed to whoever posted it
                operation.fail(error)

        if threading.current_thread() is self._thread:
            run()
            return operation
        with self._lock:
            if not self._closing:
                self._posted.add(operation)
                self._queue.append(run)
                self._executor.create_task(lambda: self._queue.popleft()())  # it takes its newest task first
                return operation
        operation.fail(CanceledError("the connection to ROS was closed"))
        return operation

    def start(self, operation: Operation[Any], work: Callable[[], None]) -> None:
        """Post what starts an operation, which ends with the error that this raises."""
        posted = self.post(work)

        def pass_error() -> None:
            try:
                posted.result()
            except BaseException as error:  # noqa: BLE001 - handed to the owner of the operation
                operation.fail(error)

        posted.add_done_callback(pass_error)

    def ask(self, work: Callable[[], T], within: float | None = None) -> T:
        """Post work, wait for it, at most `within` [s], and return its result or raise its error.

        Raises:
            CanceledError: the connection is closed.
            RuntimeError: it took longer.
        """
        posted = self.post(work)
        posted.wait(within)
        return posted.result()

    def close(self, timeout: float = 5.0) -> None:
        """End all calls, join the thread, leave the ROS graph. Harmless when repeated, and in a forked child."""
        with self._lock:
            if self._closing or os.getpid() != self._process:
                return
            self._closing = True
        self._executor.create_task(self._end_all)
        self._executor.wake()
        self._let_goals_go()
        self._stopped = True
        self._executor.create_task(lambda: None)  # a wake without work doesn't end a spin before its time
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout)
        self._end_all()
        for operation in list(self._posted):  # handed over, but the thread stopped before its turn
            operation.fail(CanceledError("the connection to ROS was closed"))
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
        self._watchdogs.close()
        atexit.unregister(self._at_exit)

    @property
    def closed(self) -> bool:
        return self._closing

    # --- on its thread ---

    def watch(self) -> None:
        """Have what is under way looked at from now on; a client asks for it when it has something."""
        if self._timer.is_canceled():
            self._timer.reset()

    def _polled(self) -> list[Client[Any]]:
        return []

    def _poll(self) -> None:
        if not any([client.poll() for client in self._polled()]):
            self._timer.cancel()

    def _end_all(self) -> None:
        for client in self._polled():
            client.end(CanceledError("the connection to ROS was closed"))
        self._ended_all.set()

    def _let_goals_go(self) -> None:
        """Wait, not long, until servers know that nobody waits for their goals any more."""
        if threading.current_thread() is self._thread or not self._thread.is_alive():
            return
        deadline = time.monotonic() + LETTING_GO
        self._ended_all.wait(LETTING_GO)
        while time.monotonic() < deadline and any(client.busy for client in self._polled()):
            time.sleep(0.005)

    def _spin(self) -> None:
        while not self._stopped and self._context.ok():
            try:
                self._executor.spin_once(timeout_sec=1.0)
            except ExternalShutdownException:
                return
            except Exception:  # noqa: BLE001 - a callback that raises must not end the connection for everybody else
                _log.exception("a callback on the ROS thread raised")


_WAIT = 0.1
"""How long [s] a callback is waited for before it is looked whether the node is to be closed."""


class TreeNode:
    """A ROS node for somebody's own tree, in rclpy's own context: spun beside the ticks, and never during one.

    Entered by whoever keeps its callbacks out for a while.
    """

    def __init__(self, name: str = "grip_tree"):
        self._own = not ok()
        if self._own:
            rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self.node: Node = rclpy.create_node(name)
        self._lock, self._closing = threading.RLock(), threading.Event()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name="grip_tree_node", daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        try:
            while not self._closing.is_set():
                try:
                    handler, _, _ = self._executor.wait_for_ready_callbacks(timeout_sec=_WAIT)
                except TimeoutException:
                    continue
                with self._lock:
                    handler()
        except ExternalShutdownException:
            pass
        except Exception as error:  # noqa: BLE001 - somebody's callback may do anything
            if not self._closing.is_set():
                self.node.get_logger().error(f"a callback raised {type(error).__name__}: {error}")

    def close(self) -> None:
        """Spin no more, and close what was opened."""
        self._closing.set()
        self._executor.wake()
        self._thread.join(5 * _WAIT)
        self.node.destroy_node()
        if self._own and ok():
            rclpy.shutdown()

    def __enter__(self) -> TreeNode:
        self._lock.acquire()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._lock.release()
