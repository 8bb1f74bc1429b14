"""What clients have in common: requests that wait, with deadlines; of services and actions also the server's check."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from rclpy.topic_endpoint_info import TopicEndpointInfo

from grip_bt.base.failures import CanceledError, IncompatibleServerError, ServerLostError, ServerTimeOutError
from grip_bt.base.operation import Operation
from grip_bt.task.catalog.component_file import Qos

from .connection import Connection
from .graph import SETTLE, STALE, TRUST, check_servers, endpoints_of, gids_of, instead
from .types import InterfaceType, Message, type_name

IN_FLIGHT = 8
"""Requests sent and not yet answered at once: a server keeps the last 10, and drops others silently."""


@dataclass(eq=False)
class Request:
    """What somebody waits for.

    Attributes:
        message: what is to be sent; None where somebody only waits for the other end.
        began: when it was asked for [s].
        deadline: until when it may take in all [s].
        wait_until: until when a server may appear [s].
        limit: who limits the time, in words behind those of a time-out.
        servers: who it was sent to; empty until then.
    """

    message: Message | None
    began: float
    deadline: float
    wait_until: float = 0.0
    limit: str = ""
    servers: frozenset[bytes] = frozenset()
    operation: Operation[Any] = field(init=False)


R = TypeVar("R", bound=Request)


class Client(ABC, Generic[R]):
    """A client of one name, of whose requests each ends; made by `Bus`."""

    _made: Any = None
    """What rclpy gave for it, when it is connected."""
    qos = Qos()
    """Of a topic: what is asked for."""

    def __init__(self, bus: Connection, type_: InterfaceType, name: str):
        self.type, self.name, self._bus = type_, name, bus
        self._requests: list[R] = []

    @property
    def idle(self) -> bool:
        """Whether it was never connected and nobody waits for that; such a client may be replaced."""
        return self._made is None and not self._requests

    @property
    def busy(self) -> bool:
        """Whether a server has to hear something before the connection may be closed."""
        return False

    def _begin(self, request: R) -> Operation[Any]:
        def cancel() -> None:
            self._bus.post(lambda: self._cancel(request))

        operation = request.operation = Operation(on_cancel=cancel)
        self._bus.start(operation, lambda: self._submit(request))
        return operation

    # --- on the bus's thread ---

    @abstractmethod
    def poll(self) -> bool:
        """Look at the requests under way; False when there are none."""

    @abstractmethod
    def _submit(self, request: R) -> None:
        """Begin a request."""

    def _cancel(self, request: R) -> None:
        self._finish(request, CanceledError("canceled"))

    def end(self, error: Exception) -> None:
        for request in list(self._requests):
            self._finish(request, error)

    def _finish(self, request: R, error: Exception | None = None) -> None:
        """End a request that got no answer: with an error, or because what it waited for is there."""
        if request in self._requests:
            self._requests.remove(request)
            if error is None:
                request.operation.succeed(None)
            else:
                request.operation.fail(error)


class ServedClient(Client[R]):
    """A client of what one server serves: a service, an action."""

    _new: Callable[..., R]

    def __init__(self, bus: Connection, type_: InterfaceType, name: str):
        super().__init__(bus, type_, name)
        self._found: frozenset[bytes] = frozenset()  # who serves it, while that is trusted
        self._checked = -math.inf
        self._settled: tuple[frozenset[bytes], float] = (frozenset(), 0.0)
        self._server_ended: str | None = None
        self._supervised = False
        self._gone: frozenset[bytes] = frozenset()

    # --- from any thread ---

    def _times(self, timeout: float | None, wait: float | None) -> tuple[float, float, float]:
        """Return now, and until when a request may take and a server may appear [s]; the bus's own times for None."""
        now = time.monotonic()
        timeout = self._bus.timeout if timeout is None else timeout
        return now, now + timeout, now + (self._bus.wait if wait is None else wait)

    def wait_ready(self, timeout: float) -> Operation[None]:
        """End when there is a server that fits; with ServerLostError after `timeout` [s]."""
        return self._begin(self._new(None, *self._times(timeout + 1.0, timeout)))

    def server_ended(self, reason: str, again: bool = False) -> Operation[None]:
        """Say that the server's process is known to have ended: all fails at once, now and until it is back.

        Args:
            again: it is being started again: only what it was sent fails; what isn't sent yet waits for it.
        """

        def end() -> None:
            self._server_ended = None if again else reason
            self._gone |= gids_of(self._look())  # DDS knows a dead server until its lease is over
            self._found = frozenset()
            for request in list(self._requests):
                if request.servers:
                    self._server_of_ended(request, reason)
                elif not again:
                    self._finish(request, self._lost(reason))

        return self._bus.post(end)

    def server_started(self) -> None:
        """Say that the server's process was started by us, so that `server_ended` will tell its end."""

        def start() -> None:
            self._server_ended, self._supervised = None, True

        self._bus.post(start)

    # --- on the bus's thread ---

    def _submit(self, request: R) -> None:
        if self._bus.closed:
            request.operation.fail(CanceledError("the connection to ROS was closed"))
        elif self._server_ended is not None:
            request.operation.fail(self._lost(self._server_ended))
        else:
            self._requests.append(request)
            self._bus.watch()
            self._advance(time.monotonic())

    def poll(self) -> bool:
        """Look at the requests under way; False when there are none."""
        now = time.monotonic()
        sent = [request for request in self._requests if request.servers]
        if sent:
            present = self._present()
            for request in sent:
                self._look_after(request, bool(request.servers & present), now)
        self._advance(now)
        for request in [r for r in self._requests if not r.servers and now > r.deadline]:
            self._finish(request, self._timed_out(request, "not sent"))
        return bool(self._requests)

    def _cancel(self, request: R) -> None:
        if request.servers:
            self._cancel_sent(request)
        else:
            self._finish(request, CanceledError(f"{self.name}: canceled before it was sent", server=self.name))

    def _advance(self, now: float) -> None:
        waiting = [request for request in self._requests if not request.servers]
        if not waiting:
            return
        try:
            ready = self._fits(now)
        except IncompatibleServerError as error:
            stale_possible = len(self._look()) > 1  # a dead one counts until its lease is over
            for request in waiting:
                if not stale_possible or now > min(request.wait_until, request.began + STALE):
                    self._finish(request, error)
            return
        for request in waiting:
            if not ready:
                self._absent(request, now)
            elif request.message is None:
                self._finish(request)
            elif sum(bool(each.servers) for each in self._requests) < IN_FLIGHT:
                servers = self._found
                self._send(request, now)
                request.servers = servers

    def _absent(self, request: R, now: float) -> None:
        if now > request.wait_until:
            waited = request.wait_until - request.began
            there = instead(self._bus.node, self.name, type_name(self.type), "served")
            self._finish(request, self._lost(f"no server within {waited:.1f} s{there}", waited=waited))

    def _fits(self, now: float) -> bool:
        """Tell whether there is one fitting server that our client is connected to.

        Raises:
            IncompatibleServerError: who is there doesn't fit.
        """
        if self._found and now - self._checked < TRUST:
            return self._connected()
        self._found = frozenset()
        servers = self._look()
        if not servers:
            return False
        check_servers(self._bus.node, self.type, self.name, servers)
        if not self._connected():
            return False
        present = gids_of(servers)
        if present != self._settled[0]:
            self._settled = (present, now)
        if now < self._settled[1] + SETTLE:
            return False
        self._found, self._checked = present, now
        return True

    def _present(self) -> frozenset[bytes]:
        """Return who is there now; when these are others than before, the next question is looked at anew."""
        present = gids_of(self._look())
        if present != self._found:
            self._found = frozenset()
        return present

    def _look(self) -> list[TopicEndpointInfo]:
        taking = f"{self.name}/_action/send_goal" if hasattr(self.type, "Impl") else self.name
        return [end for end in endpoints_of(self._bus.node, taking) if bytes(end.endpoint_gid) not in self._gone]

    @abstractmethod
    def _connected(self) -> bool:
        """Make our client, if there is none yet, and tell whether it is connected.

        It isn't called before a server was found to fit: a client of the wrong type would spoil the name here.
        """

    @abstractmethod
    def _send(self, request: R, now: float) -> None:
        """Send a request to the server that was found."""

    @abstractmethod
    def _look_after(self, request: R, there: bool, now: float) -> None:
        """Look at a request that was sent; `there`: whether the server is that has it."""

    @abstractmethod
    def _cancel_sent(self, request: R) -> None:
        """Cancel a request that was sent."""

    @abstractmethod
    def _server_of_ended(self, request: R, reason: str) -> None:
        """End a request that was sent: its server's process has ended."""

    def _lost(self, reason: str, **data: float) -> ServerLostError:
        return ServerLostError(f"{self.name}: {reason}", server=self.name, **data)

    def _timed_out(self, request: R, what: str) -> ServerTimeOutError:
        said = f"{self.name}: {what} after {request.deadline - request.began:.1f} s{request.limit}"
        return ServerTimeOutError(said, server=self.name)
