"""`python -m grip_bt.ros.watchdog_process DOMAIN`: has a robot hold whose run's process has died, however suddenly.

It leads a session of its own and is told on its standard input, a JSON object a line, what the run has under way:
goals of actions, by name and id, trajectories on topics, and which joints to look at. When the input ends while there
is something, it cancels those goals, by their ids, again until the server answers; has joints that follow a topic come
to rest; measures that all stand still, or, where no joints tell, hears from the server that the goal has ended; and
writes what came of it to the file descriptor in `REPORT`, where there is one. It ends by itself, at most `LIMIT` later.
ROS is loaded, and servers are found, before there is a need.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from contextlib import suppress
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.client import Client
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.publisher import Publisher
from rclpy.qos import qos_profile_action_status_default
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from .client.types import Message
from .watchdog import REPORT

LIMIT = 10.0
"""How long it goes on after the end of the run's process [s]."""
AGAIN = 0.1
"""After which time without an answer, or with one that doesn't know the goal, a cancel is sent again [s]."""
UNKNOWN = 3.0
"""For how long a server must say that it doesn't know a goal until it is believed [s]: it may be on its way."""
FOUND = 2.0
"""How long to look for whoever follows a topic, and for a measurement of its joints [s]."""
BRAKE = 0.3
"""How long joints that follow a topic take to come to rest [s]."""
GONE = 1.0
"""For how long a server that was there must be away until it is taken for gone [s]."""
APART, STILL, MEASURED = 0.1, 2e-3, 5.0
"""Joints stand still that are measured so far apart [s] at the same place [rad or m]; how long that may take [s]."""


class _Goal:
    """A goal of the run that died."""

    def __init__(self, action: str, goal_id: bytes):
        self.action, self.goal_id = action, goal_id
        self.asked, self.over = -AGAIN, ""
        self.ended = False


class WatchdogProcess:
    """What was told, and what is done about it.

    Args:
        domain: the DDS domain.
    """

    def __init__(self, domain: int):
        self._goals: dict[str, _Goal] = {}
        self._topics: dict[str, tuple[str, ...]] = {}
        self._parts: dict[str, tuple[str, tuple[str, ...]]] = {}
        self._moved: set[str] = set()
        self._clients: dict[str, Client] = {}
        self._there: dict[str, float] = {}
        self._subscribed: set[str] = set()
        self._writers: dict[str, Publisher] = {}
        self._heard: dict[str, tuple[float, float, float]] = {}
        context = Context()
        rclpy.init(args=[], context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node("grip_watchdog", context=context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)

    def take(self, line: dict[str, Any]) -> None:
        """Take note of a line of the run."""
        match line:
            case {"goal_sent": [action, goal]}:
                self._goals[goal] = _Goal(action, bytes.fromhex(goal))
                self._client(action)
                self._hear(action)
            case {"expect_server": action}:
                self._client(action)
            case {"goal_ended": goal}:
                self._goals.pop(goal, None)
            case {"trajectory_sent": [topic, names]}:
                self._topics[topic] = tuple(names)
                self._writer(topic)
                self._listen()
            case {"trajectory_ended": topic}:
                self._topics.pop(topic, None)
            case {"watch_joints": [part, topic, names, actions]}:
                self._parts[part] = (topic, tuple(names))
                self._moved.update(actions)
                for action in actions:
                    self._client(action)
        self._look()

    def spin(self, seconds: float) -> None:
        """Let ROS work."""
        self._executor.spin_once(timeout_sec=seconds)

    def wake(self) -> None:
        """Have `spin` return at once; from any thread."""
        self._executor.create_task(lambda: None)

    def stop_all(self) -> dict[str, str]:
        """Have everything hold; return part or action -> why that couldn't be confirmed, empty where it is at rest.

        Of actions that joints of a part don't tell about, only those are named that can't be confirmed to have ended.
        """
        if not self._goals and not self._topics:
            return {}
        began = time.monotonic()
        self._look()  # nobody has looked since the last line came
        for goal in self._goals.values():
            self._cancel(goal, began)
        self._listen()
        held = {topic: self._hold(topic, names) for topic, names in self._topics.items()}
        while (left := [g for g in self._goals.values() if self._waits(g)]) and time.monotonic() < began + LIMIT / 2:
            self._look()
            for goal in left:
                if not goal.over:
                    self._cancel(goal, began)
            self.spin(0.02)
        for goal in left:
            said = "the server accepted the cancel request, but the goal did not end"
            goal.over = f"{said if goal.over else 'nobody has answered the request to cancel'} within {LIMIT / 2:g} s"
        failed = {topic: why for topic, why in held.items() if why}
        failed.update((goal.action, goal.over) for goal in self._goals.values() if goal.over != "canceled")
        return {**failed, **{part: self._rest(*where) for part, where in self._parts.items()}}

    def _waits(self, goal: _Goal) -> bool:
        return not goal.over or (goal.over == "canceled" and not goal.ended and goal.action not in self._moved)

    def _look(self) -> None:
        now = time.monotonic()
        self._there.update((action, now) for action, client in self._clients.items() if client.service_is_ready())

    def _hear(self, action: str) -> None:
        def told(message: Message) -> None:
            for status in message.status_list:
                goal = self._goals.get(bytes(status.goal_info.goal_id.uuid).hex())
                if goal is not None and status.status >= GoalStatus.STATUS_SUCCEEDED:
                    goal.over, goal.ended = "canceled", True

        if action not in self._moved and action not in self._subscribed:
            self._subscribed.add(action)
            topic = f"{action}/_action/status"
            self._node.create_subscription(GoalStatusArray, topic, told, qos_profile_action_status_default)

    def _client(self, action: str) -> Client:
        if action not in self._clients:
            self._clients[action] = self._node.create_client(CancelGoal, f"{action}/_action/cancel_goal")
        return self._clients[action]

    def _writer(self, topic: str) -> Publisher:
        if topic not in self._writers:
            self._writers[topic] = self._node.create_publisher(JointTrajectory, topic, 10)
        return self._writers[topic]

    def _listen(self) -> None:
        for topic in {topic for topic, _ in self._parts.values()}:
            if topic not in self._subscribed:
                self._subscribed.add(topic)
                self._node.create_subscription(JointState, topic, self._measured, 50)

    def _measured(self, message: Message) -> None:
        now = time.monotonic()
        for i, (name, position) in enumerate(zip(message.name, message.position, strict=False)):
            self._heard[name] = (now, position, message.velocity[i] if i < len(message.velocity) else 0.0)

    def _cancel(self, goal: _Goal, began: float) -> None:
        client, now = self._client(goal.action), time.monotonic()
        if now > self._there.get(goal.action, now) + GONE:
            goal.over = "its server has gone, too"
        if goal.over or now < goal.asked + AGAIN or not client.service_is_ready():
            return
        goal.asked = now
        request = CancelGoal.Request()
        request.goal_info.goal_id.uuid = list(goal.goal_id)

        def answered(future: Future) -> None:
            codes, answer = CancelGoal.Response, future.result()
            if answer.goals_canceling or answer.return_code == codes.ERROR_GOAL_TERMINATED:
                goal.over = "canceled"
            elif answer.return_code != codes.ERROR_UNKNOWN_GOAL_ID:
                goal.over = "the server refused to stop"
            elif time.monotonic() > began + UNKNOWN:
                goal.over, goal.ended = "canceled", True  # it never came

        client.call_async(request).add_done_callback(answered)

    def _hold(self, topic: str, names: tuple[str, ...]) -> str:
        """Publish where joints come to rest evenly from where they were measured; return why that can't be."""
        writer, deadline = self._writer(topic), time.monotonic() + FOUND
        while not writer.get_subscription_count() and time.monotonic() < deadline:
            self.spin(0.02)
        if not writer.get_subscription_count():
            return "it has no subscribers"
        since = time.monotonic() - APART
        while any(self._heard.get(n, (0.0,))[0] < since for n in names) and time.monotonic() < deadline:
            self.spin(0.02)
        if any(name not in self._heard for name in names):
            return "nothing was heard of its joints"
        rest = [self._heard[n][1] + self._heard[n][2] * BRAKE / 2 for n in names]
        point = JointTrajectoryPoint(positions=rest, velocities=[0.0] * len(names))
        point.time_from_start.nanosec = int(BRAKE * 1e9)
        writer.publish(JointTrajectory(joint_names=list(names), points=[point]))
        return ""

    def _rest(self, topic: str, names: tuple[str, ...]) -> str:
        """Measure joints until they stand still; return why that isn't known."""
        deadline, before = time.monotonic() + MEASURED, None
        while time.monotonic() < deadline:
            since = time.monotonic()
            while any(self._heard.get(n, (0.0,))[0] < since for n in names) and time.monotonic() < deadline:
                self.spin(0.02)
            heard = [self._heard.get(n, (0.0, 0.0, 0.0)) for n in names]
            if any(time_ < since for time_, _, _ in heard):
                break
            now = [position for _, position, _ in heard]
            if before is not None and max(abs(a - b) for a, b in zip(now, before, strict=True)) <= STILL:
                return ""
            before, until = now, since + APART
            while time.monotonic() < until:
                self.spin(0.02)
        else:
            return f"its joints still moved after {MEASURED:g} s"
        return f"{topic}: nothing was heard of its joints"


def main() -> int:
    """Listen until the input ends, then see to what is left."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    watchdog, lines, over = WatchdogProcess(int(sys.argv[1])), [], threading.Event()

    def read() -> None:
        with os.fdopen(0) as stream:
            for line in stream:
                lines.append(line)
                watchdog.wake()
        over.set()
        watchdog.wake()

    threading.Thread(target=read, daemon=True).start()
    with suppress(OSError):
        os.write(1, b"1")  # ready
    while not over.is_set() or lines:
        while lines:
            watchdog.take(json.loads(lines.pop(0)))
        watchdog.spin(0.05)
    report = watchdog.stop_all()
    if report and (descriptor := os.environ.get(REPORT)):
        os.write(int(descriptor), json.dumps(report).encode() + b"\n")
    return 0


if __name__ == "__main__":
    status = main()
    os._exit(status)  # the run is dead, and nothing of ROS is to keep this one
