"""A robot for the tests: two arm joints and a gripper, moved as controllers of ros2_control are asked to.

A trajectory that ends beyond 3 rad is given up half-way; one of other joints is rejected. The gripper meets something
at 0.02. The topic /stream/commands moves the arm at once, or, with `slow`, at 0.5 rad/s. `none` as an argument
publishes no joint states; a JSON object {server: {joint: position}} has other joints than these, each under a
trajectory action `/<server>/...`.
"""

import json
import math
import sys
import threading
import time

import rclpy
from control_msgs.action import FollowJointTrajectory, GripperCommand
from controller_manager_msgs.msg import ControllerState
from controller_manager_msgs.srv import ListControllers, SwitchController
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import MultiThreadedExecutor
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

NAMES = ["joint_a", "joint_b"]
OBJECT = 0.02
others = {} if len(sys.argv) < 2 or sys.argv[1] in ("none", "slow") else json.loads(sys.argv[1])
positions = {"joint_a": 0.0, "joint_b": 0.0, "finger": 0.08}
targets = {}
for joints in others.values():
    positions.update(joints)
states = {"arm_controller": "inactive", "stream_controller": "active", "broken_controller": "inactive"}
lock = threading.Lock()


def seconds(duration):
    return duration.sec + duration.nanosec * 1e-9


def follow(handle):
    """Move along the way-points in time; obey a cancel; give up half-way what ends beyond 3 rad."""
    trajectory, result = handle.request.trajectory, FollowJointTrajectory.Result()
    times = [seconds(p.time_from_start) for p in trajectory.points]
    hopeless = max(abs(p) for p in trajectory.points[-1].positions) > 3
    began = time.monotonic()
    while (now := time.monotonic() - began) < times[-1]:
        if handle.is_cancel_requested:
            handle.canceled()
            return result
        if hopeless and now > times[-1] / 2:
            result.error_code, result.error_string = result.PATH_TOLERANCE_VIOLATED, "joint_a is blocked"
            handle.abort()
            return result
        k = max(i for i, t in enumerate(times) if t <= now)
        part = (now - times[k]) / (times[k + 1] - times[k])
        with lock:
            for i, name in enumerate(trajectory.joint_names):
                a, b = trajectory.points[k].positions[i], trajectory.points[k + 1].positions[i]
                positions[name] = a + part * (b - a)
        time.sleep(0.005)
    with lock:
        positions.update(zip(trajectory.joint_names, trajectory.points[-1].positions, strict=True))
    handle.succeed()
    return result


def grip(handle):
    """Move the fingers; closing ends at the object, or, as some grippers do, gives the goal up there."""
    wanted, result = handle.request.command.position, GripperCommand.Result()
    with lock:
        positions["finger"] = max(wanted, OBJECT)
    result.position = positions["finger"]
    result.stalled, result.reached_goal = wanted < OBJECT, wanted >= OBJECT
    result.effort = handle.request.command.max_effort if result.stalled else 0.0
    if result.stalled and handle.request.command.max_effort == 0.0:
        handle.abort()
    else:
        handle.succeed()
    return result


def accepts(goal):
    return GoalResponse.ACCEPT if set(goal.trajectory.joint_names) == set(NAMES) else GoalResponse.REJECT


def listed(request, response):
    response.controller = [ControllerState(name=name, state=state) for name, state in states.items()]
    return response


def switched(request, response):
    if "broken_controller" in request.activate_controllers:
        response.ok, response.message = False, "no hardware"
    else:
        states.update(dict.fromkeys(request.activate_controllers, "active"))
        states.update(dict.fromkeys(request.deactivate_controllers, "inactive"))
        response.ok = True
    return response


def streamed(message):
    with lock:
        (targets if "slow" in sys.argv else positions).update(zip(NAMES, message.data, strict=True))


rclpy.init()
node = rclpy.create_node("robot")
cancel = {"cancel_callback": lambda _: CancelResponse.ACCEPT}
actions = [
    ActionServer(node, FollowJointTrajectory, "/arm/follow_joint_trajectory", follow, goal_callback=accepts, **cancel),
    ActionServer(node, GripperCommand, "/gripper/gripper_cmd", grip, **cancel),
]
actions += [
    ActionServer(node, FollowJointTrajectory, f"/{server}/follow_joint_trajectory", follow, **cancel)
    for server in others
]
node.create_service(ListControllers, "/controller_manager/list_controllers", listed)
node.create_service(SwitchController, "/controller_manager/switch_controller", switched)
node.create_subscription(Float64MultiArray, "/stream/commands", streamed, 10)
publisher = node.create_publisher(JointState, "/joint_states", 10)


def publish():
    with lock:
        for name, target in targets.items():
            step = target - positions[name]
            positions[name] += math.copysign(min(abs(step), 0.005), step)
        message = JointState(name=list(positions), position=list(positions.values()))
    message.velocity = [0.0] * len(message.name)
    now = time.time()
    message.header.stamp.sec, message.header.stamp.nanosec = int(now), int(math.modf(now)[0] * 1e9)
    publisher.publish(message)


if "none" not in sys.argv:
    node.create_timer(0.01, publish)
sys.stdout.write("serving\n")
sys.stdout.flush()
executor = MultiThreadedExecutor(4)
executor.add_node(node)
executor.spin()
