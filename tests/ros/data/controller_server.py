"""A robot for the tests: two arm joints and a gripper, moved as controllers of ros2_control are asked to.

Trajectories are followed as `trajectory_controller.py` says, under `/arm`, and under `/untopical` by one without a
topic. The gripper meets something at 0.02. The topic /stream/commands moves the arm at
once, or, with `slow`, at 0.5 rad/s. `none` as an argument publishes no joint states; a JSON object
{server: {joint: position}} has other joints than these, each under a trajectory action `/<server>/...`.

A second gripper, `/claw/gripper_cmd`, opens at 1 and closes at 0, in a second; the fingers of `/fingers` open at 0 and
close at 1. What is said to the topic `/thing` is whether something is half-way between them, 0 or 1, and to
`/claw_speed` how fast the second gripper is; both are told back as positions of joints of these names.
"""

import json
import math
import sys
import threading
import time

import rclpy
from control_msgs.action import GripperCommand
from controller_manager_msgs.msg import ControllerState
from controller_manager_msgs.srv import ListControllers, SwitchController
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import MultiThreadedExecutor
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray
from trajectory_controller import BRAKING, TrajectoryController

NAMES = ["joint_a", "joint_b"]
OBJECT = 0.02
others = {} if len(sys.argv) < 2 or sys.argv[1] in ("none", "slow") else json.loads(sys.argv[1])
positions = {
    "joint_a": 0.0,
    "joint_b": 0.0,
    "finger": 0.08,
    "claw": 1.0,
    "thing": 0.0,
    "claw_speed": 1.0,
    "finger_1": 0.0,
    "finger_2": 0.0,
}
targets = {}
for joints in others.values():
    positions.update(joints)
states = {"arm_controller": "inactive", "stream_controller": "active", "broken_controller": "inactive"}
lock = threading.Lock()


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


def coast(speed):
    """Let the second gripper come to rest evenly after a cancel."""
    with lock:
        start = positions["claw"]
    takes, began = abs(speed) / BRAKING, time.monotonic()
    while (now := min(time.monotonic() - began, takes)) < takes:
        with lock:
            place = start + speed * (now - now**2 / (2 * takes))
            positions["claw"] = min(1.0, max(place, 0.5 if positions["thing"] else 0.0))
        time.sleep(0.005)


def claw(handle):
    """Open or close evenly, as far as what is between the fingers, until that is cancelled."""
    wanted, result, began = handle.request.command.position, GripperCommand.Result(), time.monotonic()
    with lock:
        start = positions["claw"]
        speed = positions["claw_speed"]
    way = wanted - start
    while (passed := speed * (time.monotonic() - began)) < abs(way):
        if handle.is_cancel_requested:
            handle.canceled()
            threading.Thread(target=coast, args=(math.copysign(speed, way),), daemon=True).start()
            return result
        with lock:
            positions["claw"] = max(start + math.copysign(passed, way), 0.5 if positions["thing"] else 0.0)
        time.sleep(0.005)
    with lock:
        positions["claw"] = result.position = max(wanted, 0.5 if positions["thing"] else 0.0)
    result.stalled, result.reached_goal = result.position > wanted, result.position <= wanted
    result.effort = handle.request.command.max_effort if result.stalled else 0.0
    handle.succeed()
    return result


def offered(message):
    fingers.blocked = 0.5 if message.data else None
    with lock:
        positions["thing"] = message.data


def hurried(message):
    with lock:
        positions["claw_speed"] = message.data


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
accepted = {"cancel_callback": lambda _: CancelResponse.ACCEPT}
fingers = TrajectoryController(node, "/fingers", ["finger_1", "finger_2"], positions, lock)
actions = [
    fingers,
    TrajectoryController(node, "/arm", NAMES, positions, lock),
    TrajectoryController(node, "/untopical", NAMES, positions, lock, heard=False),
    ActionServer(node, GripperCommand, "/gripper/gripper_cmd", grip, **accepted),
    ActionServer(node, GripperCommand, "/claw/gripper_cmd", claw, **accepted),
    *(TrajectoryController(node, f"/{server}", list(joints), positions, lock) for server, joints in others.items()),
]
node.create_service(ListControllers, "/controller_manager/list_controllers", listed)
node.create_service(SwitchController, "/controller_manager/switch_controller", switched)
node.create_subscription(Float64MultiArray, "/stream/commands", streamed, 10)
node.create_subscription(Float64, "/thing", offered, 10)
node.create_subscription(Float64, "/claw_speed", hurried, 10)
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


def publish_always():
    """A timer would wake the executor a hundred times a second, which looks at all servers each time."""
    while True:
        publish()
        time.sleep(0.01)


if "none" not in sys.argv:
    threading.Thread(target=publish_always, daemon=True).start()
sys.stdout.write("serving\n")
sys.stdout.flush()
executor = MultiThreadedExecutor(6)
executor.add_node(node)
executor.spin()
