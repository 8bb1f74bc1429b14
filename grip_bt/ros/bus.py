"""The one door to ROS of a process: one context, one executor, one thread that is joined, for the life of the process.

Every rclpy entity is created, used and destroyed on that thread, because rclpy's clients aren't safe elsewhere; one
exception, calls of a service whose server was seen a moment ago, is in `client`.
rclpy itself never says that a server died or that a type was wrong, and never gives up; so each call has a deadline, is
checked before it is sent, and is watched while it is under way (`grip_bt.ros.client`). Nothing else creates a client.

The thread is a daemon *and* joined by `close`, which also runs at exit: a daemon thread that is still inside rcl_wait
when the interpreter ends aborts it, and one that isn't a daemon keeps it alive after an uncaught error. A forked child
must leave the bus alone and end by `os._exit`, as multiprocessing's does: DDS would join threads that aren't there.
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
from typing import Any, TypeVar, cast

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from grip_bt.base.errors import GripError
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation

from .action import ActionClient
from .client import ServiceClient
from .environment import require
from .reaping import Guard, shared
from .shared_memory import sweep
from .topic import TopicReader, TopicWriter
from .types import check_name, load_type, type_name

T = TypeVar("T")
C = TypeVar("C", ServiceClient, ActionClient, TopicReader, TopicWriter)
POLL = 0.05
"""How often calls under way are looked at [s]; nothing is looked at while there are none."""

HURRY = 0.01
"""The same while somebody waits for a server to appear [s]: it is found sooner."""
LETTING_GO = 1.0
"""How long closing waits for action servers to hear that their goals are canceled [s]."""

_log = logging.getLogger("grip.ros")


class Bus:
    """A ROS node with its thread, and the clients that live on it.

    Args:
        name: the node's name.
        domain_id: the DDS domain; ROS_DOMAIN_ID, else 0, by default.
        guarded: whether goals that it sends, which may move something, are ended when this process has died.
    """

    def __init__(self, name: str = "grip", domain_id: int | None = None, guarded: bool = False):
        require()
        self._guarded, self._guards = guarded, ExitStack()
        self._guard: Guard | None = None
        sweep()
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain_id, signal_handler_options=SignalHandlerOptions.NO)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a parser that a node loads
            self.node = Node(name, context=self._context, start_parameter_services=False, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[tuple[type, str], ServiceClient | ActionClient | TopicReader | TopicWriter] = {}
        self._posted: set[Operation[Any]] = set()
        self._queue: deque[Callable[[], None]] = deque()
        self._closing, self._stopped = False, False
        self._ended_all = threading.Event()
        self._lock = threading.Lock()
        self._process = os.getpid()
        self._timer = self.node.create_timer(POLL, self._poll)
        self._timer.cancel()
        self._thread = threading.Thread(target=self._spin, name=f"ros-{name}", daemon=True)
        self._thread.start()
        self._at_exit = _closer(weakref.ref(self))
        atexit.register(self._at_exit)

    # --- for everybody ---

    def service(self, interface: str | Any, name: str, timeout: float = 30.0, wait: float = 5.0) -> ServiceClient:
        """Return the client of a service; there is one per name.

        Args:
            interface: the service's type, or its name.
            name: the service's full name, such as `/propose_grasps`.
            timeout: how long a call may take in all [s].
            wait: how long a call waits for the server to appear [s].

        Raises:
            UnknownNameError, MissingPartError: there is no such type.
            GripError: a client of the name exists with another type, or ROS knows no such names.
        """
        return self._client(ServiceClient, interface, name, timeout, wait)

    def action(self, interface: str | Any, name: str, timeout: float = 30.0, wait: float = 5.0) -> ActionClient:
        """Return the client of an action; there is one per name.

        Args:
            interface: the action's type, or its name.
            name: the action's full name, such as `/plan_grasp`.
            timeout: how long a goal may take in all [s]; `math.inf` for ever.
            wait: how long a goal waits for the server to appear [s].

        Raises:
            UnknownNameError, MissingPartError: there is no such type.
            GripError: a client of the name exists with another type, or ROS knows no such names.
        """
        return self._client(ActionClient, interface, name, timeout, wait)

    def reader(self, interface: str | Any, name: str, timeout: float = 5.0) -> TopicReader:
        """Return the subscription of a topic, likewise; `next` waits `timeout` [s] where nothing else is said.

        Without an interface (empty) it is heard as what it is published as.
        """
        return self._client(TopicReader, interface, name, timeout, 0.0)

    def writer(self, interface: str | Any, name: str, timeout: float = 5.0) -> TopicWriter:
        """Return the publisher of a topic, likewise; `timeout` is how long it waits for subscribers [s]."""
        return self._client(TopicWriter, interface, name, timeout, 0.0)

    def _client(self, kind: type[C], interface: str | Any, name: str, timeout: float, wait: float) -> C:
        check_name(name)
        type_ = load_type(interface) if isinstance(interface, str) and interface else interface or None
        with self._lock:
            client = self._clients.get((kind, name))
            other = client is not None and type_ is not None and client.type is not type_
            if client is not None and client.type is None:
                client.type = type_
            elif client is None or (other and client.idle):
                client = self._clients[kind, name] = kind(self, type_, name, timeout, wait)
            elif other:
                raise GripError(f"{name} is used as {type_name(client.type)} already, not as {type_name(type_)}")
        return cast(C, client)

    @property
    def guard(self) -> Guard | None:
        """What is told of all that is under way and may move something; it is started when it is first asked for."""
        if self._guarded and self._guard is None:
            with self._lock:
                if self._guard is None and not self._closing:
                    self._guard = self._guards.enter_context(shared(self._context.get_domain_id()))
        return self._guard

    def post(self, work: Callable[[], T]) -> Operation[T]:
        """Run `work` on the bus's thread, in the order of the calls; at once when called from there."""
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
        else:
            self._hand_over(operation, run)
        return operation

    def _hand_over(self, operation: Operation[Any], run: Callable[[], None]) -> None:
        with self._lock:
            if not self._closing:
                self._posted.add(operation)
                self._queue.append(run)
                self._executor.create_task(self._run_next)  # the executor takes its newest task first
                return
        operation.fail(CanceledError("the connection to ROS was closed"))

    def _run_next(self) -> None:
        self._queue.popleft()()

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
        self._guards.close()
        atexit.unregister(self._at_exit)

    def __enter__(self) -> Bus:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._closing

    # --- on the bus's thread ---

    def watch(self) -> None:
        """Have the calls under way looked at from now on; a client asks for it when it has some."""
        self._hurry(True)
        if self._timer.is_canceled():
            self._timer.reset()

    def watch_soon(self) -> None:
        """Have a call looked at that is among the sent ones already; from any thread."""
        if self._timer.is_canceled():
            self.post(self.watch)

    def _poll(self) -> None:
        with self._lock:
            clients = list(self._clients.values())
        if not any([client.poll() for client in clients]):
            self._timer.cancel()
            if any(isinstance(client, ServiceClient) and client.in_flight for client in clients):
                # sent meanwhile, when the timer still seemed to run
                self._timer.reset()
        self._hurry(any(client.waiting for client in clients))

    def _hurry(self, wanted: bool) -> None:
        period = int((HURRY if wanted else POLL) * 1e9)
        if self._timer.timer_period_ns != period:
            self._timer.timer_period_ns = period

    def _end_all(self) -> None:
        for client in list(self._clients.values()):
            client.end(CanceledError("the connection to ROS was closed"))
        self._ended_all.set()

    def _let_goals_go(self) -> None:
        """Wait, not long, until servers know that nobody waits for their goals any more."""
        if threading.current_thread() is self._thread or not self._thread.is_alive():
            return
        deadline = time.monotonic() + LETTING_GO
        self._ended_all.wait(LETTING_GO)
        while time.monotonic() < deadline and any(client.busy for client in list(self._clients.values())):
            time.sleep(0.005)

    def _spin(self) -> None:
        while not self._stopped and self._context.ok():
            try:
                self._executor.spin_once(timeout_sec=1.0)
            except ExternalShutdownException:
                return
            except Exception:  # noqa: BLE001 - a callback that raises must not end the bus for everybody else
                _log.exception("a callback on the ROS thread raised")


def _closer(reference: weakref.ref[Bus]) -> Callable[[], None]:
    """Return what closes the bus at exit, without keeping it alive until then."""

    def close() -> None:
        bus = reference()
        if bus is not None:
            bus.close()

    return close
