"""`MonitorState`: watches a topic until a condition on its messages doesn't hold."""

from __future__ import annotations

import queue
from collections.abc import Callable
from typing import Any

from grip_bt.smach_compat._settings import hooks
from grip_bt.smach_compat.state import State
from grip_bt.smach_compat.user_data import NOTHING

from ._connection import ros, with_optional_node
from .ros_state import RosState

__all__ = ["MonitorState"]

_WAKE = object()


class MonitorState(RosState):
    """Watches until a condition doesn't hold.

    Ends with `invalid` at the first message for which `cond_cb(userdata, message)` isn't true or raises, with `valid`
    at message number `max_checks`, or with `preempted`.

    Args:
        cond_cb: the condition. It is called on the thread that executes the state, so it may take its time.
        max_checks: -1: never `valid`.
    """

    @with_optional_node
    def __init__(
        self,
        topic: str,
        msg_type: Any,
        cond_cb: Callable[[Any, Any], Any],
        max_checks: int = -1,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
    ):
        State.__init__(self, ["valid", "invalid", "preempted"], input_keys, output_keys)
        self._topic, self._msg_type, self._cond_cb, self._max_checks = topic, msg_type, cond_cb, max_checks
        self._messages: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def execute(self, ud: Any) -> str:
        """Subscribe, judge messages until it is decided, unsubscribe."""
        if not self.preempt_requested():
            self._messages = queue.SimpleQueue()
            subscription = ros().subscribe(self._full_name(self._topic), self._msg_type, self._messages.put)
            try:
                outcome = self._judge(ud)
            finally:
                subscription.close()
        if self.preempt_requested():
            self.service_preempt()
            return "preempted"
        return outcome

    def _judge(self, ud: object) -> str:
        number = 0
        while not self.preempt_requested():
            message = self._messages.get()
            if message is _WAKE:
                continue
            number += 1
            if 0 < self._max_checks <= number:
                return "valid"
            try:
                holds = self._cond_cb(ud, message)
            except Exception as error:  # noqa: BLE001 - upstream: a condition that raises doesn't hold
                hooks.logerr(f"The condition {self._cond_cb} on {self._topic} raised: {error!r}")
                holds = False
            if not holds:
                return "invalid"
        return "preempted"

    def request_preempt(self) -> None:
        """Ask it to stop waiting."""
        super().request_preempt()
        self._messages.put(_WAKE)
