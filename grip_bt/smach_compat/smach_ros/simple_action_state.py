"""`SimpleActionState`: sends a goal to an action server and waits for its end."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from grip_bt.smach_compat._settings import hooks, settings
from grip_bt.smach_compat.exceptions import InvalidStateError
from grip_bt.smach_compat.user_data import NOTHING

from ._connection import fields, ros, seconds, stands_in, status_of, with_optional_node
from .ros_state import AskingState, BadAnswerError, user_code

__all__ = ["SimpleActionState"]

SLICE = 1.0
"""How long to wait for the server before saying so [s]."""
WATCH = 0.1
"""How often time-outs are looked at [s]."""


class SimpleActionState(AskingState):
    """Sends one goal: `succeeded`, `aborted`, `preempted`, or what the result's callback returns.

    The goal is `goal` (kept, and changed by what follows) or what is under `goal_key`; then its fields `goal_slots` are
    taken from userdata; then `goal_cb(userdata, goal, ...)` may change it or return another. The result goes to
    `result_cb(userdata, status, result)`, then under `result_key`, then its fields `result_slots` to userdata.
    Times are durations or [s]; noetic waits for ever for the end of a goal that was canceled, so that `preempt_timeout`
    needs the setting `honour_preempt_timeout`.
    """

    WAITING_FOR_SERVER, INACTIVE, ACTIVE, PREEMPTING, COMPLETED = range(5)

    @with_optional_node
    def __init__(
        self,
        action_name: str,
        action_spec: Any,
        goal: Any = None,
        goal_key: str | None = None,
        goal_slots: list[str] = NOTHING,
        goal_cb: Callable[..., object] | None = None,
        goal_cb_args: Any = NOTHING,
        goal_cb_kwargs: Mapping[str, Any] | None = None,
        result_key: str | None = None,
        result_slots: list[str] = NOTHING,
        result_cb: Callable[..., object] | None = None,
        result_cb_args: Any = NOTHING,
        result_cb_kwargs: Mapping[str, Any] | None = None,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
        outcomes: list[str] = NOTHING,
        exec_timeout: Any = None,
        preempt_timeout: Any = 60.0,
        server_wait_timeout: Any = 60.0,
        feedback_cb: Callable[..., object] | None = None,
        feedback_cb_args: Any = NOTHING,
        feedback_cb_kwargs: Mapping[str, Any] | None = None,
    ):
        if goal is not None and callable(goal) and not stands_in(goal):
            raise InvalidStateError(f"The goal of {action_name!r} is a function; give it as goal_cb")
        _check_slots("goal", goal_slots, action_spec.Goal())
        _check_slots("result", result_slots, action_spec.Result())
        self._action_name, self._action_spec = action_name, action_spec
        self._goal = action_spec.Goal() if goal is None else goal
        keys = (input_keys, output_keys)
        self._take(
            ("goal callback", "result callback"),
            (goal_key, goal_slots, goal_cb, goal_cb_args, goal_cb_kwargs),
            (result_key, result_slots, result_cb, (), {}),
            keys,
            outcomes,
        )
        self._feedback_cb = user_code(
            self, "feedback callback", feedback_cb, feedback_cb_args, feedback_cb_kwargs or {}, keys
        )
        self._exec_timeout = exec_timeout
        self._preempt_timeout = preempt_timeout
        self._server_wait_timeout = server_wait_timeout
        self._status = self.WAITING_FOR_SERVER
        self._goal_status: int = 0
        self._goal_result: Any = None
        self._ending = ""
        self._feedback: list[Any] = []
        self._done_cond = threading.Condition()
        self._action_client = ros().action_client(self._full_name(action_name), action_spec)
        # noetic looks for the server from here on, in a thread: its time runs from the construction.
        self._server_deadline = ros().now() + seconds(server_wait_timeout)

    def execute(self, ud: Any) -> str:
        ready = self._wait_for_server()
        if self.preempt_requested():
            hooks.loginfo(f"Preempted before sending a goal to {self._action_name!r}.")
            self.service_preempt()
            return "preempted"
        if not ready:
            hooks.logerr(f"There is no server of the action {self._action_name!r}.")
            return "aborted"
        self._status = self.INACTIVE
        try:
            self._goal = self._made(ud, self._goal)
        except BadAnswerError as error:
            hooks.logerr(f"No goal for the action {self._action_name!r}: {error}")
            return "aborted"
        self._run_goal(ud)
        return self._conclude(ud)

    def _wait_for_server(self) -> bool:
        clock = ros()
        begin, limit = clock.now(), seconds(self._server_wait_timeout)
        deadline = begin + limit
        if not settings.ros2 and self._status == self.WAITING_FOR_SERVER and begin < self._server_deadline:
            deadline = self._server_deadline
        while not self.preempt_requested() and not clock.is_shutdown():
            if self._action_client.wait(min(WATCH, max(0.0, deadline - clock.now()))):
                return True
            if clock.now() >= deadline:
                return False
            if clock.now() - begin > SLICE:
                hooks.logwarn(f"Still waiting for the action server {self._action_name!r}; is it running?")
                begin = clock.now()
        return False

    def _run_goal(self, ud: object) -> None:
        clock = ros()
        activated, canceled = clock.now(), None
        self._ending, self._goal_result, self._feedback = "", None, []
        self._status = self.ACTIVE
        self._action_client.send(self._goal, self._goal_done_cb, self._goal_feedback_cb)
        if self.preempt_requested():  # it came between the last look and the sending
            self._action_client.cancel()
        while not self._ending:
            with self._done_cond:
                if not self._ending and not self._feedback:
                    watched = self._exec_timeout is not None or (self._gives_up and self.preempt_requested())
                    self._done_cond.wait(WATCH if watched else None)
                feedback, self._feedback = self._feedback, []
            for message in feedback:  # on this thread, so that the callback may take its time
                self._feedback_cb(ud, message)
            if not self._ending:
                if self.preempt_requested() and canceled is None:
                    canceled = clock.now()
                now = clock.now()
                if self._exec_timeout is not None and now - activated > seconds(self._exec_timeout):
                    hooks.logwarn(f"Action {self._action_name!r} timed out after {seconds(self._exec_timeout)} s.")
                    self._action_client.cancel()
                if self._gives_up and canceled is not None and now - canceled > seconds(self._preempt_timeout):
                    hooks.logwarn(
                        f"Action {self._action_name!r} didn't stop within {seconds(self._preempt_timeout)} s."
                    )
                    self._ending = "lost"
        self._status = self.INACTIVE

    @property
    def _gives_up(self) -> bool:
        """Whether it stops waiting for a server that doesn't obey."""
        return settings.ros2 or settings.honour_preempt_timeout

    def _goal_done_cb(self, ending: str, status: int, result: object) -> None:
        with self._done_cond:
            if self._status == self.ACTIVE:
                self._ending, self._goal_status, self._goal_result = ending, status_of(ending, status), result
                self._done_cond.notify_all()

    def _goal_feedback_cb(self, message: object) -> None:
        if self._feedback_cb.cb is not None:
            with self._done_cond:
                self._feedback.append(message)
                self._done_cond.notify_all()

    def request_preempt(self) -> None:
        """Cancel the goal; the state ends when the server has."""
        hooks.loginfo(f"Preempt requested on action {self._action_name!r}")
        super().request_preempt()
        if self._status == self.ACTIVE:
            self._action_client.cancel()
            if self._gives_up:
                with self._done_cond:
                    self._done_cond.notify_all()  # from now on there is a time to be looked at

    def _conclude(self, ud: Any) -> str:
        try:
            what = f"result callback of {self._action_name!r}"
            chosen = self._hand_over(what, ud, self._goal_result, self._goal_status, self._goal_result)
        except BadAnswerError as error:
            hooks.logerr(str(error))
            return "aborted"
        outcome = self._outcome()
        return outcome if chosen is None else chosen

    def _outcome(self) -> str:
        """Return the outcome by the goal's end alone, and answer a request to stop that it has obeyed."""
        if settings.ros2:
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
            return {"succeeded": "succeeded", "aborted": "preempted"}.get(self._ending, "aborted")
        if self._ending == "succeeded":
            return "succeeded"
        if self._ending == "preempted" and self.preempt_requested():
            self.service_preempt()
            return "preempted"
        return "aborted"


def _check_slots(what: str, slots: list[str], message: object) -> None:
    unknown = [slot for slot in slots if not stands_in(message) and slot not in fields(message)]
    if unknown:
        raise InvalidStateError(f"{what}_slots has {unknown}, but the {what} has {list(fields(message))}")
