"""`actionlib` over ROS 2's actions: simple clients and servers, and the numbers of goals' states."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from grip_bt.smach_compat.smach_ros._connection import ros, seconds
from grip_bt.smach_compat.smach_ros._port import STATUS

from .rospy import resolve_name, waited


class GoalStatus:
    """How goals stand, in ROS 1's numbers."""

    PENDING, ACTIVE, PREEMPTED, SUCCEEDED, ABORTED, REJECTED, PREEMPTING, RECALLING, RECALLED, LOST = range(10)

    @classmethod
    def to_string(cls, status: int) -> str:
        return next((name for name, value in vars(cls).items() if value == status), f"UNKNOWN STATUS {status}")


class SimpleGoalState:
    """How the goal of a simple client stands."""

    PENDING, ACTIVE, DONE = range(3)


class SimpleActionClient:
    """Sends goals, one at a time."""

    def __init__(self, ns: str, ActionSpec: Any, *_: object):
        self.name, self._type = resolve_name(ns), ActionSpec
        self._client = ros().action_client(self.name, ActionSpec)
        self._over = threading.Event()
        self._status, self._goal = GoalStatus.LOST, 0
        self._result: Any = None

    def wait_for_server(self, timeout: Any = 0) -> bool:
        """Tell whether there is a server in time; 0: wait for ever."""
        return waited(self._client.wait, seconds(timeout) or float("inf"))

    def send_goal(
        self, goal: Any, done_cb: Any = None, active_cb: Any = None, feedback_cb: Callable[[Any], None] | None = None
    ) -> None:
        self._over = over = threading.Event()
        self._status, self._result = GoalStatus.ACTIVE, None
        self._goal += 1
        number = self._goal

        def done(ending: str, status: int, result: object) -> None:
            status = STATUS[ending]
            if number == self._goal:
                self._status, self._result = status, self._type.Result() if result is None else result
            over.set()
            if done_cb is not None and number == self._goal:
                done_cb(status, self._result)

        self._client.send(goal, done, feedback_cb or (lambda message: None))
        if active_cb is not None:
            active_cb()

    def wait_for_result(self, timeout: Any = 0) -> bool:
        """Tell whether the goal ends in time; 0: wait for ever."""
        return waited(self._over.wait, seconds(timeout) or float("inf"))

    def send_goal_and_wait(self, goal: Any, execute_timeout: Any = 0, preempt_timeout: Any = 0) -> int:
        """Send a goal, cancel it when it takes too long, and return how it stands."""
        self.send_goal(goal)
        if not self.wait_for_result(execute_timeout):
            self.cancel_goal()
            self.wait_for_result(preempt_timeout)
        return self.get_state()

    def get_result(self) -> Any:
        return self._result

    def get_state(self) -> int:
        """Return how the goal stands, one of GoalStatus; LOST where none was sent."""
        return self._status

    def cancel_goal(self) -> None:
        self._client.cancel()

    cancel_all_goals = cancel_goal

    def stop_tracking_goal(self) -> None:
        self._goal += 1


class SimpleActionServer:
    """Serves goals, one at a time: by a function, or by whoever asks for the next one."""

    def __init__(self, name: str, ActionSpec: Any, execute_cb: Any = None, auto_start: bool = True):
        self._type, self._execute_cb = ActionSpec, execute_cb
        self._goal_cb: Callable[[], object] = lambda: None
        self._preempt_cb: Callable[[], object] = lambda: None
        self._next: Any = None
        self._asked, self._over, self._active = False, threading.Event(), False
        self._server = ros().action_server(resolve_name(name), ActionSpec, self._execute, self._preempt)
        if auto_start:
            self.start()

    def start(self) -> None:
        self._server.start()

    def register_goal_callback(self, cb: Callable[[], object]) -> None:
        """Have a function called when there is a goal, which accepts it."""
        self._goal_cb = cb

    def register_preempt_callback(self, cb: Callable[[], object]) -> None:
        self._preempt_cb = cb

    def _execute(self, goal: Any) -> None:
        self._over, self._next = threading.Event(), goal
        if self._execute_cb is not None:
            self._execute_cb(self.accept_new_goal())
            self.set_aborted()  # nothing where it was ended, as it should be
        else:
            self._goal_cb()
        self._over.wait()
        self._asked = False

    def _preempt(self) -> None:
        self._asked = True
        self._preempt_cb()

    def accept_new_goal(self) -> Any:
        """Return the goal, which is active from now on."""
        goal, self._next, self._active = self._next, None, True
        return goal

    def is_new_goal_available(self) -> bool:
        return self._next is not None

    def is_active(self) -> bool:
        return self._active

    def is_preempt_requested(self) -> bool:
        return self._asked

    def publish_feedback(self, feedback: Any) -> None:
        self._server.feedback(feedback)

    def _end(self, ending: str, result: Any) -> None:
        if not self._over.is_set():
            self._active = False
            self._server.end(ending, self._type.Result() if result is None else result)
            self._over.set()

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        self._end("succeeded", result)

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        self._end("aborted", result)

    def set_preempted(self, result: Any = None, text: str = "") -> None:
        self._end("preempted", result)


__all__ = ["GoalStatus", "SimpleActionClient", "SimpleActionServer", "SimpleGoalState", "threading"]
