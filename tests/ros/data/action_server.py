"""An action server that does as each goal tells it, and counts: `action_server.py NAME [KEPT]`.

Goals that have ended are remembered for KEPT seconds, 5 by default.

A goal `slow_accept FILE` is taken when that file is there, and nothing else is heard before.

Goals `unanswered` and `unseen` are taken without a word, as by a server that doesn't know the client's ear yet; of
`unseen` ones no status is published either.
"""

import json
import os
import signal
import sys
import time

import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger
from trial_interfaces.action import Work


class Wire:
    """The server's end of the wire, which loses what the goals say."""

    def __init__(self, wire):
        self.wire, self.silent, self.hidden = wire, False, False

    def __getattr__(self, name):
        return getattr(self.wire, name)

    def send_goal_response(self, header, response):
        if not self.silent:
            self.wire.send_goal_response(header, response)

    def publish_status(self):
        if not self.hidden:
            self.wire.publish_status()


class Server(Node):
    def __init__(self, name, kept=5.0):
        super().__init__("trial_" + name.strip("/").replace("/", "_"))
        self.counts = {"active": 0, "accepted": 0, "succeeded": 0, "canceled": 0, "aborted": 0, "rejected": 0}
        self.sleepers = []
        self.create_timer(0.002, self._wake)
        self.create_service(Trigger, f"{name}/counts", self._tell)
        self.server = ActionServer(
            self,
            Work,
            name,
            execute_callback=self._execute,
            goal_callback=self._goal,
            cancel_callback=self._cancel,
            result_timeout=kept,
        )
        self.server._handle = self.wire = Wire(self.server._handle)

    def _goal(self, goal):
        self.wire.silent = goal.input in ("unanswered", "unseen")
        self.wire.hidden = goal.input == "unseen"
        if goal.input.startswith("slow_accept "):
            while not os.path.exists(goal.input.removeprefix("slow_accept ")):
                time.sleep(0.01)
        if goal.input == "reject":
            self.counts["rejected"] += 1
            return GoalResponse.REJECT
        if goal.input == "die_before":
            os.kill(os.getpid(), signal.SIGKILL)
        self.counts["accepted"] += 1
        self.counts["active"] += 1
        return GoalResponse.ACCEPT

    def _cancel(self, handle):
        return CancelResponse.REJECT if handle.request.input == "stubborn" else CancelResponse.ACCEPT

    async def _execute(self, handle):
        goal, result = handle.request, Work.Result()
        until = time.monotonic() + goal.seconds
        while time.monotonic() < until or goal.input == "hang":
            if handle.is_cancel_requested and goal.input != "hang":
                handle.canceled()
                return self._end("canceled", result)
            handle.publish_feedback(Work.Feedback(progress=1.0 - max(0.0, until - time.monotonic()) / goal.seconds))
            await self._sleep(0.01)
        if goal.input == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if goal.input == "abort":
            result.returned_object = "too heavy"
            handle.abort()
            return self._end("aborted", result)
        handle.succeed()
        result.outcome = int(goal.input) if goal.input.lstrip("-").isdigit() else 0
        result.returned_object = f"did {goal.input}"
        return self._end("succeeded", result)

    def _end(self, how, result):
        self.counts[how] += 1
        self.counts["active"] -= 1
        return result

    def _sleep(self, seconds):
        future = Future(executor=self.executor)
        self.sleepers.append((time.monotonic() + seconds, future))
        return future

    def _wake(self):
        now = time.monotonic()
        due = [f for t, f in self.sleepers if t <= now]
        self.sleepers = [(t, f) for t, f in self.sleepers if t > now]
        for future in due:
            future.set_result(None)

    def _tell(self, request, response):
        response.success, response.message = True, json.dumps(self.counts)
        return response


def main():
    rclpy.init(args=[])
    node = Server(sys.argv[1], *map(float, sys.argv[2:]))
    sys.stdout.write("serving\n")
    sys.stdout.flush()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


main()
