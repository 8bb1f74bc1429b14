"""Calls of one service: checked before they are sent, watched until they end, and named when they fail.

A call waits until there is one server that fits, is sent, and ends with the answer or with `ServerLostError` (nobody
came, or who had the request is gone), `IncompatibleServerError` (see `server_check`) or `ServerTimeOutError`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation

from .base import Request, ServedClient
from .graph import GRACE
from .types import Message

SERVICE_QOS = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=100,
)


@dataclass(eq=False)
class _Call(Request):
    abandon: bool = True
    future: Future | None = None  # of the answer, when it is sent
    gone_since: float | None = None


class ServiceClient(ServedClient[_Call]):
    """The client of one service; made by `Bus.service`."""

    _new = _Call
    _forsaken = False

    @property
    def settled(self) -> bool:
        """Whether every call that was sent has been answered: no server can be at work for us."""
        return not self._requests and not self._forsaken

    @property
    def in_flight(self) -> bool:
        return any(call.servers for call in list(self._requests))

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
        return self._begin(_Call(request, *self._times(timeout, wait), limit, abandon=abandon))

    # --- on the bus's thread ---

    def _connected(self) -> bool:
        if self._made is None:
            self._made = self._bus.node.create_client(self.type, self.name, qos_profile=SERVICE_QOS)
        return bool(self._made.service_is_ready())

    def _send(self, request: _Call, now: float) -> None:
        try:
            request.future = self._made.call_async(request.message)
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

    def _look_after(self, request: _Call, there: bool, now: float) -> None:
        if now > request.deadline:
            self._finish(request, self._timed_out(request, "no response"))
        elif not there:
            request.gone_since = request.gone_since or now
            if not self._supervised or now > request.gone_since + GRACE:
                self._finish(request, self._lost("the server disappeared while it had the request"))

    def _cancel_sent(self, request: _Call) -> None:
        if request.abandon:
            self._finish(request, CanceledError("canceled"))

    def _server_of_ended(self, request: _Call, reason: str) -> None:
        self._finish(request, self._lost(reason))

    def _finish(self, request: _Call, error: Exception | None = None) -> None:
        """End a call that got no answer; a request under way is forgotten, else rclpy keeps it for ever."""
        if request in self._requests and request.future is not None:
            self._made.remove_pending_request(request.future)
            self._forsaken = True
        super()._finish(request, error)
