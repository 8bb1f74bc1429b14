"""Asks a project's task server as any ROS 2 software would, written with rclpy alone; prints what it saw as JSON."""

import json
import sys
import time

import rclpy
from grip_msgs.action import RunTask
from grip_msgs.msg import TaskStatus
from grip_msgs.srv import ListTasks
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger

PATIENCE = 240.0
rclpy.init()
node = rclpy.create_node("plain_task_client")
states, feedback = [], []
node.create_subscription(
    TaskStatus,
    "/grip/status",
    lambda told: states.append(told.state),
    QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL),
)
runner = ActionClient(node, RunTask, "/grip/run_task")
assert runner.wait_for_server(PATIENCE)


def called(kind, name, **fields):
    client = node.create_client(kind, f"/grip/{name}")
    assert client.wait_for_service(PATIENCE)
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
    return future.result()


def change(transition):
    return called(ChangeState, "change_state", transition=Transition(id=transition)).success


def asked(**goal):
    future = runner.send_goal_async(RunTask.Goal(**goal), lambda told: feedback.append(told.feedback))
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
    return future.result()


def ended(handle):
    future = handle.get_result_async()
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
    result = future.result().result
    return {"goal": future.result().status, **{n: getattr(result, n) for n in ("status", "outcome", "code", "message")}}


def until(is_true):
    deadline = time.monotonic() + PATIENCE
    while not is_true():
        assert time.monotonic() < deadline, (states, feedback)
        rclpy.spin_once(node, timeout_sec=0.1)


seen = {"before": asked(task="count").accepted}
seen["managed"] = [change(Transition.TRANSITION_CONFIGURE), change(Transition.TRANSITION_ACTIVATE)]
listed = called(ListTasks, "list_tasks")
seen["listed"] = {n: told for n, *told in zip(listed.names, listed.files, listed.docs, strict=True)}
seen["count"] = ended(asked(task="count", inputs='{"n": 5}'))
until(lambda: "success" in states)
seen["feedback"] = [[told.node, told.event, told.code] for told in feedback]
seen["failing"] = ended(asked(task="tasks/failing.yaml", form="sm"))
seen["unknown"] = ended(asked(task="coutn"))
seen["no_json"] = ended(asked(task="count", inputs="n: 5"))
endless = asked(task="endless")
until(lambda: states and states[-1] == "running")
seen["second"] = asked(task="count").accepted
seen["pause"] = called(Trigger, "pause").success
until(lambda: states[-1] == "paused")
cancel = endless.cancel_goal_async()
rclpy.spin_until_future_complete(node, cancel, timeout_sec=PATIENCE)
seen["cancelled"] = ended(endless)
seen["nothing"] = called(Trigger, "stop").success
endless = asked(task="endless")
until(lambda: states[-1] == "running")
seen["deactivated"] = change(Transition.TRANSITION_DEACTIVATE)
seen["stopped"] = ended(endless)
seen["after"] = asked(task="count").accepted
sys.stdout.write(json.dumps(seen) + "\n")
node.destroy_node()
rclpy.shutdown()
sys.exit(0)
