"""`ConditionState`: checks a condition some times."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any

from grip_bt.smach_compat._settings import errors_of_user_code, settings
from grip_bt.smach_compat.exceptions import InvalidUserCodeError
from grip_bt.smach_compat.state import State
from grip_bt.smach_compat.user_data import NOTHING

from ._connection import ros, seconds, with_optional_node
from .ros_state import RosState

__all__ = ["ConditionState"]

PERIOD = 0.05
"""How long to wait between two checks when nothing else was asked for [s]."""


class ConditionState(RosState):
    """Ends with `true` as soon as `cond_cb(userdata)` holds, with `false` after the checks, or `preempted`.

    Args:
        cond_cb: the condition.
        input_keys: userdata that it reads.
        poll_rate: the time between two checks (a duration or [s]); in profile `ros2`, checks per second.
        timeout: how long to check at most (a duration or [s]).
        max_checks: how often to check; noetic checks once more. -1: for ever.
    """

    @with_optional_node
    def __init__(
        self,
        cond_cb: Callable[[Any], Any],
        input_keys: list[str] = NOTHING,
        poll_rate: Any = None,
        timeout: Any = None,
        max_checks: int = 1,
    ):
        State.__init__(self, outcomes=["true", "false", "preempted"], input_keys=input_keys)
        self._cond_cb = cond_cb
        if hasattr(cond_cb, "get_registered_input_keys") and hasattr(cond_cb, "get_registered_output_keys"):
            self.register_input_keys(cond_cb.get_registered_input_keys())
            self.register_output_keys(cond_cb.get_registered_output_keys())
        self._poll_rate, self._timeout, self._max_checks = poll_rate, timeout, max_checks

    def execute(self, ud: Any) -> str:
        """Check until it holds, the checks or the time are over, or it is preempted.

        Raises:
            InvalidUserCodeError: the condition raised.
        """
        clock = ros()
        limit = None if self._timeout is None else clock.now() + seconds(self._timeout)
        allowed = self._max_checks + (0 if settings.ros2 else 1)
        checks = 0
        while self._max_checks == -1 or checks < allowed:
            if limit is not None and clock.now() > limit:
                break
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
            try:
                if self._cond_cb(ud):
                    return "true"
            except errors_of_user_code() as error:
                raise InvalidUserCodeError(f"The condition {self._cond_cb} raised: {traceback.format_exc()}") from error
            checks += 1
            clock.sleep(self._period())
        return "false"

    def _period(self) -> float:
        if self._poll_rate is None:
            return PERIOD
        given = seconds(self._poll_rate)
        is_rate = settings.ros2 and isinstance(self._poll_rate, (int, float))
        return 1.0 / given if is_rate else given
