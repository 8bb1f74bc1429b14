"""Calls of one service: checked before they are sent, watched until they end, and named when they fail.

A call waits until there is one server that fits, is sent, and ends with the answer or with `ServerLostError` (nobody
came, or who had the request is gone), `UnfitServerError` (see `preflight`) or `ServerTimeOutError`.

A call to a server that was checked a moment ago is sent from the caller's thread, which saves it the way to the bus's:
rclpy's service clients, unlike its action clients, allow that. Everything else happens on the bus's thread.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from grip_bt.base.failures import CanceledError, ServerLostError, ServerTimeOutError, UnfitServerError
from grip_bt.base.operation import Operation

from .futures import give_way, when_done
from .others import explained
from .preflight import check_servers, servers_of
from .server_check import GRACE, STALE, ServerCheck

if TYPE_CHECKING:
    from .bus import Bus

IN_FLIGHT = 8
"""Requests under way at once: a server keeps the last 10, and what it drops is lost without a word."""
SERVICE_QOS = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=100,
)


@dataclass(eq=False)
class _Call:
    """One call; `request` is None for somebody who only waits for the server."""

    operation: Operation[Any]
    request: Any
    started: float
    wait_until: float
    deadline: float
    future: Any = None
    servers: frozenset[bytes] = field(default_factory=frozenset)
    gone_since: float | None = None


class ServiceClient:
    """The client of one service; made by `Bus.service`.

    Attributes:
        type: the service's class.
        name: its full name.
        limit: who limits the time of a call, in words behind those of a time-out.
    """

    limit = ""

    def __init__(self, bus: Bus, type_: Any, name: str, timeout: float, wait: float):
        self.type, self.name = type_, name
        self._bus, self._timeout, self._wait = bus, timeout, wait
        self._client: Any = None
        self._waiting: list[_Call] = []
        self._sent: list[_Call] = []
        self._handed_over = 0  # calls on their way to the bus's thread, which no later one may overtake
        self._lock = threading.Lock()  # of `_handed_over` and `_sent`, and of what a call is sent on
        self._check = ServerCheck(
            lambda: servers_of(bus.node, name),
            lambda servers: check_servers(bus.node, type_, name, servers),
            self._connected,
        )
        self._server_ended: str | None = None
        self._supervised = False

    @property
    def idle(self) -> bool:
        """Whether it was never connected to a server and nobody waits for one; such a client may be replaced."""
        return self._client is None and not self._waiting

    @property
    def waiting(self) -> bool:
        """Whether somebody waits for the server to appear."""
        return bool(self._waiting)

    @property
    def in_flight(self) -> bool:
        """Whether a call is under way."""
        return bool(self._sent)

    @property
    def servers(self) -> frozenset[bytes]:
        """Who the last call went to, by DDS's own names; others after the server was started anew."""
        return self._check.last

    @property
    def busy(self) -> bool:
        """Whether a server has to hear something before the connection may be closed: never, of a service."""
        return False

    # --- from any thread ---

    def call(
        self, request: Any, timeout: float | None = None, wait: float | None = None, abandon: bool = True
    ) -> Operation[Any]:
        """Send a request; the result is the response. A service can't be told to stop.

        Args:
            request: a message of `type.Request`.
            timeout: how long it may take in all [s].
            wait: how long to wait for the server to appear [s].
            abandon: whether cancelling ends the operation at once, with the server at work for nobody; else it ends
                when the server has answered, is gone, or the time is over. What isn't sent yet is dropped.
        """
        return self._begin(request, timeout or self._timeout, self._wait if wait is None else wait, abandon)

    def wait_ready(self, timeout: float) -> Operation[None]:
        """End when there is a server that fits; with ServerLostError after `timeout` [s]."""
        return self._begin(None, timeout + 1.0, timeout)

    def server_ended(self, reason: str) -> None:
        """Say that the server's process is known to have ended: every call fails at once, now and until it is back."""

        def end() -> None:
            with self._lock:
                self._server_ended = reason
                self._check.forget()
            self.end(self._lost(reason))

        self._bus.post(end)

    def server_started(self) -> None:
        """Say that the server's process was started by us, so that `server_ended` will tell its end."""

        def start() -> None:
            self._server_ended, self._supervised = None, True

        self._bus.post(start)

    def _begin(self, request: Any, timeout: float, wait: float, abandon: bool = True) -> Operation[Any]:
        def cancel() -> None:
            if abandon or call not in self._sent:
                self._finish(call, CanceledError("canceled"))

        def ask() -> None:
            self._bus.post(cancel)

        operation: Operation[Any] = Operation(on_cancel=ask)
        now = time.monotonic()
        call = _Call(operation, request, now, now + wait, now + timeout)
        if request is not None and self._sent_at_once(call):
            return operation
        with self._lock:
            self._handed_over += 1
        posted = self._bus.post(lambda: self._submit(call))
        posted.add_done_callback(lambda: pass_error(posted, operation))
        return operation

    def _sent_at_once(self, call: _Call) -> bool:
        """Send a call from the caller's thread, if nothing has to be waited for or looked at first."""
        with self._lock:
            servers, trusted = self._check.servers, self._check.trusted(time.monotonic())
            free = not self._waiting and not self._handed_over and len(self._sent) < IN_FLIGHT
            if not (trusted and free) or self._server_ended is not None or self._bus.closed:
                return False
            if not self._client.service_is_ready():
                return False
            call.servers = servers
            self._sent.append(call)
            self._bus.watch_soon()
        self._request(call)
        return True

    # --- on the bus's thread ---

    def poll(self) -> bool:
        """Look at the calls under way; False when there are none."""
        now = time.monotonic()
        if self._sent:
            present = self._check.present()
            for call in [c for c in self._sent if not c.servers & present]:
                call.gone_since = call.gone_since or now
                if not self._supervised or now > call.gone_since + GRACE:
                    self._finish(call, self._lost("the server that had the request is gone"))
        for call in [c for c in (*self._sent, *self._waiting) if now > c.deadline]:
            self._finish(call, self._timed_out(call))
        if self._waiting:
            self._advance(now)
        return bool(self._sent or self._waiting)

    def end(self, error: Exception) -> None:
        """End every call with an error."""
        with self._lock:  # whoever sends a call after this sees why it mustn't
            calls = (*self._sent, *self._waiting)
        for call in calls:
            self._finish(call, error)

    def _submit(self, call: _Call) -> None:
        with self._lock:
            self._handed_over -= 1
        if call.operation.done():
            return
        if self._bus.closed:
            call.operation.fail(CanceledError("the connection to ROS was closed"))
        elif self._server_ended is not None:
            call.operation.fail(self._lost(self._server_ended))
        else:
            self._waiting.append(call)
            self._bus.watch()
            self._advance(time.monotonic())

    def _advance(self, now: float) -> None:
        """Send what can be sent; give up what has waited too long for a server."""
        try:
            ready = self._check.fits(now)
        except UnfitServerError as error:
            stale_possible = self._check.several()
            for call in list(self._waiting):
                if not stale_possible or now > min(call.wait_until, call.started + STALE):
                    self._finish(call, error)
            return
        for call in list(self._waiting):
            if ready and call.request is None:
                self._finish(call, None)
            elif ready and len(self._sent) < IN_FLIGHT:
                self._send(call)
            elif not ready and now > call.wait_until:
                waited = call.wait_until - call.started
                absent = self._lost(f"no server within {waited:.1f} s", waited=waited)
                self._finish(call, explained(absent, self._bus.node, self.type))

    def _connected(self) -> bool:
        if self._client is None:
            self._client = self._bus.node.create_client(self.type, self.name, qos_profile=SERVICE_QOS)
        return bool(self._client.service_is_ready())

    def _send(self, call: _Call) -> None:
        call.servers = self._check.servers
        with self._lock:
            self._waiting.remove(call)
            self._sent.append(call)
        self._request(call)

    def _request(self, call: _Call) -> None:
        """Put a call that is among the sent ones on the wire; from any thread."""
        try:
            call.future = self._client.call_async(call.request)
        except Exception as error:  # noqa: BLE001 - rclpy's own errors and TypeErrors of a wrong request
            self._take_out(call)
            call.operation.fail(error)
            return
        when_done(call.future, lambda future: self._answered(call, future))
        if call.operation.done():  # it was ended from the bus's thread before there was a request to forget
            self._client.remove_pending_request(call.future)

    def _take_out(self, call: _Call) -> bool:
        """Take a call out of those that are under way; False when it wasn't among them."""
        with self._lock:
            if call not in self._sent:
                return False
            self._sent.remove(call)
            return True

    def _answered(self, call: _Call, future: Any) -> None:
        if not self._take_out(call):
            return
        error = future.exception()
        if error is not None:
            call.operation.fail(error)
        else:
            call.operation.succeed(future.result())
        if self._waiting:
            self._advance(time.monotonic())
        elif not self._sent:  # with more under way, their answers come first
            give_way()

    def _finish(self, call: _Call, error: Exception | None) -> None:
        """End a call that got no answer; a request under way is forgotten, else rclpy keeps it for ever."""
        if self._take_out(call) and call.future is not None:
            self._client.remove_pending_request(call.future)
        if call in self._waiting:
            self._waiting.remove(call)
        if error is None:
            call.operation.succeed(None)
        else:
            call.operation.fail(error)

    def _lost(self, reason: str, **data: float) -> ServerLostError:
        return ServerLostError(f"{self.name}: {reason}", server=self.name, **data)

    def _timed_out(self, call: _Call) -> ServerTimeOutError:
        state = "no answer" if call.future is not None else "not sent"
        said = f"{self.name}: {state} after {call.deadline - call.started:.1f} s{self.limit}"
        return ServerTimeOutError(said, server=self.name)


def pass_error(posted: Operation[None], operation: Operation[Any]) -> None:
    """End an operation whose start raised."""
    try:
        posted.result()
    except BaseException as error:  # noqa: BLE001 - handed to the owner of the operation
        operation.fail(error)
