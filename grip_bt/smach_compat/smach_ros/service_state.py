"""`ServiceState`: calls a service."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from grip_bt.smach_compat._settings import hooks
from grip_bt.smach_compat.user_data import NOTHING

from ._connection import ros, with_optional_node
from ._port import ServiceFailedError
from .ros_state import AskingState, BadAnswerError

__all__ = ["ServiceState"]

SLICE = 1.0
"""How long to wait for the server before looking at requests to stop [s]."""


class ServiceState(AskingState):
    """Calls a service: `succeeded`, `aborted` or `preempted`, or what the response's callback returns.

    The request is `request`, or what is under `request_key`; then its fields `request_slots` are taken from userdata;
    then `request_cb(userdata, request, ...)` may change it or return another. The response goes to
    `response_cb(userdata, response, ...)`, then under `response_key`, then its fields `response_slots` to userdata.
    A request to stop is seen while it waits for the server and not during the call.
    """

    @with_optional_node
    def __init__(
        self,
        service_name: str,
        service_spec: Any,
        request: Any = None,
        request_cb: Callable[..., object] | None = None,
        request_cb_args: Any = NOTHING,
        request_cb_kwargs: Mapping[str, Any] | None = None,
        request_key: str | None = None,
        request_slots: list[str] = NOTHING,
        response_cb: Callable[..., object] | None = None,
        response_cb_args: Any = NOTHING,
        response_cb_kwargs: Mapping[str, Any] | None = None,
        response_key: str | None = None,
        response_slots: list[str] = NOTHING,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
        outcomes: list[str] = NOTHING,
    ):
        self._take(
            ("request callback", "response callback"),
            (request_key, request_slots, request_cb, request_cb_args, request_cb_kwargs),
            (response_key, response_slots, response_cb, response_cb_args, response_cb_kwargs),
            (input_keys, output_keys),
            outcomes,
        )
        self._service_name, self._service_spec = service_name, service_spec
        self._request = service_spec.Request() if request is None else request
        self._proxy: Any = None

    def execute(self, ud: Any) -> str:
        early = self._connect()
        if early is not None:
            return early
        try:
            self._request = self._made(ud, self._request)
            response = self._proxy.call(self._request)
            what = f"response callback of {self._service_name!r}"
            return self._hand_over(what, ud, response, response) or "succeeded"
        except (BadAnswerError, KeyError, ServiceFailedError) as error:
            hooks.logerr(f"Calling service {self._service_name!r} failed: {error!r}")
            return "aborted"

    def _connect(self) -> str | None:
        """Wait for the server, in slices; return the outcome when there is none to be called."""
        if self._stopped("before sending a request to"):
            return "preempted"
        connection = ros()
        while self._proxy is None:
            if connection.is_shutdown():
                return "aborted"
            if self._stopped("while waiting for"):
                return "preempted"
            proxy = connection.service(self._full_name(self._service_name), self._service_spec)
            if proxy.wait(SLICE):
                self._proxy = proxy
            else:
                hooks.logwarn(f"Still waiting for service {self._service_name!r}...")
        return None

    def _stopped(self, when: str) -> bool:
        if not self.preempt_requested():
            return False
        hooks.loginfo(f"Preempted {when} service {self._service_name!r}.")
        self.service_preempt()
        return True
