"""`python -m grip_bt.ros.watchdog_process DOMAIN LIMIT`: has a robot hold whose run's process has died.

It leads a session of its own and is told on its standard input, a JSON object a line, what the run has under way:
goals of actions, by name and id, and which joints to look at. When the input ends while there is something, it cancels
those goals, by their ids, again until the server answers; measures that all joints stand still, or, where no joints
tell, hears from the server that the goal has ended; and writes what came of it to the file descriptor in `REPORT`,
where there is one. It ends by itself, at most LIMIT [s] later. ROS is loaded, and servers are found, before there is a
need. Joints that follow a stream of set-points stand still when that ends.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from contextlib import suppress
from typing import Any

from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.client import Client
from rclpy.qos import qos_profile_action_status_default
from rclpy.task import Future

from .client.bus import Bus
from .client.types import Message
from .controllers.joint_states import JointStates
from .controllers.motion import rest_of_joints
from .watchdog import REPORT

AGAIN = 0.1
"""After which time without an answer, or with one that doesn't know the goal, a cancel is sent again [s]."""
UNKNOWN = 3.0
"""For how long a server must say that it doesn't know a goal until it is believed [s]: it may be on its way."""


class _Goal:
    """A goal of the run that died."""

    def __init__(self, action: str, goal_id: bytes):
        self.action, self.goal_id = action, goal_id
        self.asked, self.over = -AGAIN, ""
        self.ended = False


class WatchdogProcess:
    """What was told, and what is done about it.

    Args:
        limit: how long it goes on after the end of the run's process [s]: half for goals to end, half for rest.
    """

    def __init__(self, domain: int, limit: float):
        self._patience = limit / 2
        self._goals: dict[str, _Goal] = {}
        self._parts: dict[str, tuple[str, tuple[str, ...]]] = {}
        self._moved: set[str] = set()
        self._clients: dict[str, Client] = {}
        self._bus = Bus("grip_watchdog", domain)

    def take(self, line: dict[str, Any]) -> None:
        """Take note of a line of the run."""
        self._bus.ask(lambda: self._take(line))

    def stop_all(self) -> dict[str, str]:
        """Have everything hold; return part or action -> why that couldn't be confirmed, empty where it is at rest.

        Of actions that joints of a part don't tell about, only those are named that can't be confirmed to have ended.
        """
        if not self._goals:
            return {}
        began = time.monotonic()
        self._bus.ask(lambda: self._cancel_all(began))
        states = {topic: JointStates(self._bus, topic) for topic in {topic for topic, _ in self._parts.values()}}
        deadline = began + self._patience  # a server that isn't seen may be one that a busy machine keeps silent
        while (left := [g for g in self._goals.values() if self._waits(g)]) and time.monotonic() < deadline:
            self._bus.ask(lambda: self._cancel_all(began))
            time.sleep(0.02)
        for goal in left:
            if goal.over:
                goal.over = "the server accepted the cancel request, but the goal did not end"
            elif self._clients[goal.action].service_is_ready():
                goal.over = "nobody has answered the request to cancel"
            else:
                goal.over = "its server is not there"
            goal.over += f" within {self._patience:g} s"
        failed = {goal.action: goal.over for goal in self._goals.values() if goal.over != "canceled"}
        rests = {part: rest_of_joints(states[t], names, self._patience) for part, (t, names) in self._parts.items()}
        for rest in rests.values():
            rest.wait()
        return {**failed, **{part: rest.result() for part, rest in rests.items()}}

    def _waits(self, goal: _Goal) -> bool:
        return not goal.over or (goal.over == "canceled" and not goal.ended and goal.action not in self._moved)

    # --- on the bus's thread ---

    def _take(self, line: dict[str, Any]) -> None:
        match line:
            case {"goal_sent": [action, goal]}:
                self._goals[goal] = _Goal(action, bytes.fromhex(goal))
                self._client(action)
            case {"expect_server": action}:
                self._client(action)
            case {"goal_ended": goal}:
                self._goals.pop(goal, None)
            case {"watch_joints": [part, topic, names, actions]}:
                self._parts[part] = (topic, tuple(names))
                self._moved.update(actions)
                for action in actions:
                    self._client(action)

    def _client(self, action: str) -> Client:
        if action not in self._clients:
            node, topic = self._bus.node, f"{action}/_action/status"
            self._clients[action] = node.create_client(CancelGoal, f"{action}/_action/cancel_goal")
            node.create_subscription(GoalStatusArray, topic, self._told, qos_profile_action_status_default)
        return self._clients[action]

    def _told(self, message: Message) -> None:
        for status in message.status_list:
            goal = self._goals.get(bytes(status.goal_info.goal_id.uuid).hex())
            if goal is not None and status.status >= GoalStatus.STATUS_SUCCEEDED:
                goal.over, goal.ended = "canceled", True

    def _cancel_all(self, began: float) -> None:
        for goal in self._goals.values():
            if not goal.over:
                self._cancel(goal, began)

    def _cancel(self, goal: _Goal, began: float) -> None:
        client, now = self._client(goal.action), time.monotonic()
        if now < goal.asked + AGAIN or not client.service_is_ready():
            return
        goal.asked = now
        request = CancelGoal.Request()
        request.goal_info.goal_id.uuid = list(goal.goal_id)

        def answered(future: Future) -> None:
            codes, answer = CancelGoal.Response, future.result()
            if goal.over:
                return  # an earlier request was answered, or the goal has ended
            if answer.goals_canceling or answer.return_code == codes.ERROR_GOAL_TERMINATED:
                goal.over = "canceled"
            elif answer.return_code != codes.ERROR_UNKNOWN_GOAL_ID:
                goal.over = "the server refused to stop"
            elif time.monotonic() > began + UNKNOWN:
                goal.over, goal.ended = "canceled", True  # it never came

        client.call_async(request).add_done_callback(answered)


def main() -> int:
    """Listen until the input ends, then see to what is left."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    watchdog = WatchdogProcess(int(sys.argv[1]), float(sys.argv[2]))
    with suppress(OSError):
        os.write(1, b"1")  # ready
    for line in sys.stdin:
        watchdog.take(json.loads(line))
    report = watchdog.stop_all()
    if report and (descriptor := os.environ.get(REPORT)):
        os.write(int(descriptor), json.dumps(report).encode() + b"\n")
    return 0


if __name__ == "__main__":
    status = main()
    os._exit(status)  # the run is dead, and nothing of ROS is to keep this one
