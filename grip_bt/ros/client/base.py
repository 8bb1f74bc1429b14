"""What clients have in common: requests that wait, with deadlines; of services and actions also the server's check."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from rclpy.topic_endpoint_info import TopicEndpointInfo

from grip_bt.base.failures import CanceledError, IncompatibleServerError, ServerLostError
from grip_bt.base.operation import Operation

from .connection import Connection
from .graph import SETTLE, STALE, TRUST, check_servers, gids_of, servers_of
from .types import InterfaceType, Message

IN_FLIGHT = 8
"""Requests sent and not yet answered at once: a server keeps the last 10, and drops others without a word."""


@dataclass(eq=False)
class Request:
    """What somebody waits for.

    Attributes:
        message: what is to be sent; None where somebody only waits for the other end.
        began: when it was asked for [s].
        deadline: until when it may take in all [s].
        wait_until: until when a server may appear [s].
    """

    message: Message | None
    began: float
    deadline: float
    wait_until: float = 0.0
    operation: Operation[Any] = field(init=False)


R = TypeVar("R", bound=Request)


class Client(ABC, Generic[R]):
    """A client of one name, of whose requests each ends; made by `Bus`."""

    def __init__(self, bus: Connection, type_: InterfaceType, name: str):
        self.type, self.name, self._bus = type_, name, bus
        self._requests: list[R] = []

    @property
    @abstractmethod
    def idle(self) -> bool:
        """Whether it was never connected and nobody waits for that; such a client may be replaced."""

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
        """End every request with an error."""
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

    def __init__(self, bus: Connection, type_: InterfaceType, name: str):
        super().__init__(bus, type_, name)
        self._found: frozenset[bytes] = frozenset()  # who serves it, while that is trusted
        self._checked = -math.inf
        self._settled: tuple[frozenset[bytes], float] = (frozenset(), 0.0)
        self._server_ended: str | None = None
        self._supervised = False

    # --- from any thread ---

    def server_ended(self, reason: str) -> None:
        """Say that the server's process is known to have ended: all fails at once, now and until it is back."""

        def end() -> None:
            self._server_ended = reason
            self._found = frozenset()
            self._all_lost(reason)

        self._bus.post(end)

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

    def _advance(self, now: float) -> None:
        waiting = self._waiting()
        if not waiting:
            return
        try:
            ready = self._fits(now)
        except IncompatibleServerError as error:
            stale_possible = len(self._look()) > 1  # a dead one counts until its lease is over
            for request in waiting:
                if not stale_possible or now > min(request.wait_until, request.began + STALE):
                    self._unfit(request, error)
            return
        for request in waiting:
            if not ready:
                self._absent(request, now)
            elif request.message is None:
                self._finish(request)
            elif self._sent() < IN_FLIGHT:
                self._send(request, now)

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
        return servers_of(self._bus.node, self.type, self.name)

    @abstractmethod
    def _connected(self) -> bool:
        """Make our client, if there is none yet, and tell whether it is connected.

        It isn't called before a server was found to fit: a client of the wrong type would spoil the name here.
        """

    @abstractmethod
    def _waiting(self) -> list[R]:
        """Return the requests that aren't sent."""

    @abstractmethod
    def _sent(self) -> int:
        """Return how many requests the server hasn't answered."""

    @abstractmethod
    def _send(self, request: R, now: float) -> None:
        """Send a request to the server that was found."""

    def _unfit(self, request: R, error: IncompatibleServerError) -> None:
        self._finish(request, error)

    def _absent(self, request: R, now: float) -> None:
        """See to a request for which no server is there."""

    @abstractmethod
    def _all_lost(self, reason: str) -> None:
        """End every request: the server's process has ended."""

    def _lost(self, reason: str, **data: float) -> ServerLostError:
        return ServerLostError(f"{self.name}: {reason}", server=self.name, **data)
