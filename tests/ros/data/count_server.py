"""Servers in another process: the action `/count`, the service `/answer`.

The goal 1 succeeds with ten times the goal, 2 aborts, 3 is rejected, 4 lasts until it is canceled, 5 lasts for ever.
"""

import sys
import time

import rclpy
from counting_interfaces.action import Count
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool


def execute(handle):
    number = handle.request.goal
    handle.publish_feedback(Count.Feedback(feedback=number))
    while number in (4, 5):
        time.sleep(0.01)
        if handle.is_cancel_requested and number == 4:
            handle.canceled()
            return Count.Result(result=-1)
    if number == 2:
        handle.abort()
    else:
        handle.succeed()
    return Count.Result(result=10 * number)


def answer(request, response):
    response.success = request.data
    return response


rclpy.init()
node = Node("counting")
group = ReentrantCallbackGroup()
server = ActionServer(
    node,
    Count,
    "/count",
    execute,
    goal_callback=lambda goal: GoalResponse.REJECT if goal.goal == 3 else GoalResponse.ACCEPT,
    cancel_callback=lambda handle: CancelResponse.ACCEPT,
    callback_group=group,
)
node.create_service(SetBool, "/answer", answer)
executor = MultiThreadedExecutor(4)
executor.add_node(node)
sys.stdout.write("serving\n")
sys.stdout.flush()
executor.spin()
