"""`ServiceState`: calls a service."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from typing import Any

from grip_bt.smach_compat._settings import hooks
from grip_bt.smach_compat.state import State
from grip_bt.smach_compat.user_data import NOTHING
from grip_bt.smach_compat.util import has_smach_interface

from ._connection import new_request, ros, with_optional_node
from ._port import ServiceFailedError
from ._user_code import BadAnswerError, answer_of, user_code
from .ros_state import RosState

__all__ = ["ServiceState"]

SLICE = 1.0
"""How long to wait for the server before looking at requests to stop [s]."""


class ServiceState(RosState):
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
        State.__init__(self, outcomes=["succeeded", "aborted", "preempted"])
        self._service_name, self._service_spec = service_name, service_spec
        self._request = new_request(service_spec) if request is None else request
        self._request_key, self._request_slots = request_key, request_slots
        self._response_key, self._response_slots = response_key, response_slots
        self._response: Any = None
        self._proxy: Any = None

        keys = (input_keys, output_keys)
        self._request_cb = user_code(
            self, "request callback", request_cb, request_cb_args, request_cb_kwargs or {}, keys
        )
        self._response_cb = user_code(
            self, "response callback", response_cb, response_cb_args, response_cb_kwargs or {}, keys
        )
        if has_smach_interface(response_cb):
            self.register_outcomes(response_cb.get_registered_outcomes())  # type: ignore[union-attr]
        self.register_input_keys([*([request_key] if request_key is not None else []), *request_slots, *input_keys])
        self.register_output_keys(
            [*output_keys, *([response_key] if response_key is not None else []), *response_slots]
        )
        self.register_outcomes(outcomes)

    def execute(self, ud: Any) -> str:
        """Wait for the server, call, hand over the response."""
        early = self._connect()
        if early is not None:
            return early
        try:
            self._fill_request(ud)
        except _NoRequest as error:
            hooks.logerr(f"No request for service {self._service_name!r}: {error}")
            return "aborted"
        try:
            self._response = self._proxy.call(self._request)
        except ServiceFailedError as error:
            hooks.logerr(f"Calling service {self._service_name!r} failed: {error}")
            return "aborted"
        return self._hand_over(ud)

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

    def _fill_request(self, ud: object) -> None:
        if self._request_key is not None:
            self._request = _present(ud, self._request_key)
        for key in self._request_slots:
            setattr(self._request, key, _present(ud, key))
        try:
            changed = self._request_cb(ud, self._request)
        except Exception:  # noqa: BLE001 - upstream: the state ends as aborted
            raise _NoRequest(f"its callback raised: {traceback.format_exc()}") from None
        if changed is not None:
            self._request = changed
        if self._request is None:
            raise _NoRequest("it is None")

    def _hand_over(self, ud: Any) -> str:
        try:
            what = f"response callback of {self._service_name!r}"
            outcome = answer_of(self, what, self._response_cb, ud, self._response)
        except BadAnswerError as error:
            hooks.logerr(str(error))
            return "aborted"
        if self._response_key is not None:
            ud[self._response_key] = self._response
        for key in self._response_slots:
            ud[key] = getattr(self._response, key)
        return "succeeded" if outcome is None else outcome


class _NoRequest(Exception):
    """There is nothing to send, and why."""


def _present(ud: Any, key: str) -> Any:
    if key not in ud:
        raise _NoRequest(f"userdata has no {key!r}; it has {ud.keys()}")
    return ud[key]
