"""Calls of one service: checked before they are sent, watched until they end, and named when they fail.

A call waits until there is one server that fits, is sent, and ends with the answer or with `ServerLostError` (nobody
came, or who had the request is gone), `IncompatibleServerError` (see `server_check`) or `ServerTimeOutError`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future

from grip_bt.base.failures import ServerTimeOutError
from grip_bt.base.operation import Operation

from .base import Request, ServedClient
from .connection import Connection
from .graph import GRACE, explained
from .types import InterfaceType, Message

SERVICE_QOS = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=100,
)


@dataclass(eq=False)
class _Call(Request):
    abandon: bool = True
    limit: str = ""
    future: Future | None = None  # of the answer, when it is sent
    servers: frozenset[bytes] = field(default_factory=frozenset)
    gone_since: float | None = None


class ServiceClient(ServedClient[_Call]):
    """The client of one service; made by `Bus.service`."""

    def __init__(self, bus: Connection, type_: InterfaceType, name: str):
        super().__init__(bus, type_, name)
        self._client: Any = None  # rclpy's, when a server was found

    @property
    def idle(self) -> bool:
        """Whether it was never connected to a server and nobody waits for one; such a client may be replaced."""
        return self._client is None and not self._requests

    @property
    def in_flight(self) -> bool:
        """Whether a call is under way."""
        return self._sent() > 0

    @property
    def servers(self) -> frozenset[bytes]:
        """Who the last call went to, by DDS's own names; others after the server was started anew."""
        return self._settled[0]

    def call(
        self,
        request: Message | None,
        timeout: float | None = None,
        wait: float | None = None,
        abandon: bool = True,
        limit: str = "",
    ) -> Operation[Message]:
        """Send a request; the result is the response. A service can't be told to stop.

        Args:
            timeout: how long it may take in all [s].
            wait: how long to wait for the server to appear [s].
            abandon: whether cancelling ends the operation at once, with the server at work for nobody; else it ends
                when the server has answered, is gone, or the time is over. What isn't sent yet is dropped.
            limit: who limits the time, in words behind those of a time-out.
        """
        now = time.monotonic()
        timeout = self._bus.timeout if timeout is None else timeout
        wait = self._bus.wait if wait is None else wait
        return self._begin(_Call(request, now, now + timeout, now + wait, abandon, limit))

    def wait_ready(self, timeout: float) -> Operation[None]:
        """End when there is a server that fits; with ServerLostError after `timeout` [s]."""
        return self.call(None, timeout + 1.0, timeout).then(lambda _: Operation.finished(None))

    # --- on the bus's thread ---

    def poll(self) -> bool:
        """Look at the calls under way; False when there are none."""
        now = time.monotonic()
        if self.in_flight:
            present = self._present()
            for call in [c for c in self._requests if c.future is not None and not c.servers & present]:
                call.gone_since = call.gone_since or now
                if not self._supervised or now > call.gone_since + GRACE:
                    self._finish(call, self._lost("the server disappeared while it had the request"))
        for call in [c for c in self._requests if now > c.deadline]:
            self._finish(call, self._timed_out(call))
        self._advance(now)
        return bool(self._requests)

    def _waiting(self) -> list[_Call]:
        return [call for call in self._requests if call.future is None]

    def _sent(self) -> int:
        return sum(call.future is not None for call in list(self._requests))

    def _connected(self) -> bool:
        if self._client is None:
            self._client = self._bus.node.create_client(self.type, self.name, qos_profile=SERVICE_QOS)
        return bool(self._client.service_is_ready())

    def _send(self, request: _Call, now: float) -> None:
        request.servers = self._found
        try:
            request.future = self._client.call_async(request.message)
        except Exception as error:  # noqa: BLE001 - rclpy's own errors and TypeErrors of a wrong request
            self._finish(request, error)
            return
        request.future.add_done_callback(lambda future: self._answered(request, future))

    def _answered(self, call: _Call, future: Future) -> None:
        if call not in self._requests:
            return
        self._requests.remove(call)
        error = future.exception()
        if error is not None:
            call.operation.fail(error)
        else:
            call.operation.succeed(future.result())
        self._advance(time.monotonic())

    def _cancel(self, request: _Call) -> None:
        if request.abandon or request.future is None:
            super()._cancel(request)

    def _finish(self, request: _Call, error: Exception | None = None) -> None:
        """End a call that got no answer; a request under way is forgotten, else rclpy keeps it for ever."""
        if request in self._requests and request.future is not None:
            self._client.remove_pending_request(request.future)
        super()._finish(request, error)

    def _absent(self, request: _Call, now: float) -> None:
        if now > request.wait_until:
            waited = request.wait_until - request.began
            absent = self._lost(f"no server within {waited:.1f} s", waited=waited)
            self._finish(request, explained(absent, self._bus.node, self.type))

    def _all_lost(self, reason: str) -> None:
        self.end(self._lost(reason))

    def _timed_out(self, call: _Call) -> ServerTimeOutError:
        state = "no response" if call.future is not None else "not sent"
        said = f"{self.name}: {state} after {call.deadline - call.began:.1f} s{call.limit}"
        return ServerTimeOutError(said, server=self.name)
