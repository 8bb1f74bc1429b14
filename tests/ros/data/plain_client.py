"""A client of action servers that move joints, written with rclpy alone: `plain_client.py ACTION TYPE JOINT...`.

It reads commands as JSON lines and answers each with one. `{"points": [[time, positions, velocities]...], "after": s,
"how": h}` sends a goal and, s seconds after it was accepted, does h: `cancel` (this goal), `all` (every goal of the
server), `early` (as soon as it is accepted, whatever s), `replace` (the goal once more, and a cancel of the first one),
or nothing; the answer tells what the server said, and all that was measured until 0.4 s after the result. TYPE is
`trajectory`, `moveit` or `gripper`.
"""

import json
import sys
import time

import rclpy
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

AFTER = 0.4
action, kind, names = sys.argv[1], sys.argv[2], sys.argv[3:]
rclpy.init()
node = rclpy.create_node("somebody_else")
if kind == "trajectory":
    from control_msgs.action import FollowJointTrajectory as Type
elif kind == "moveit":
    from moveit_msgs.action import ExecuteTrajectory as Type
else:
    from control_msgs.action import GripperCommand as Type
client = ActionClient(node, Type, action)
cancel_all = node.create_client(CancelGoal, f"{action}/_action/cancel_goal")
samples, feedback = [], []


def measured(message):
    row = [message.name.index(name) for name in names if name in message.name]
    if len(row) == len(names):
        stamp = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        velocity = [message.velocity[k] for k in row] if message.velocity else None
        samples.append([time.time(), stamp, [message.position[k] for k in row], velocity])


node.create_subscription(JointState, "/joint_states", measured, QoSProfile(depth=200))


def goal_of(points):
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    goal = Type.Goal()
    if kind == "gripper":
        goal.command.position = points[-1][1][0]
        return goal
    trajectory = JointTrajectory(joint_names=names)
    for at, positions, velocities in points:
        point = JointTrajectoryPoint(positions=positions, velocities=velocities or [])
        point.time_from_start.sec, point.time_from_start.nanosec = int(at), int(at % 1 * 1e9)
        trajectory.points.append(point)
    if kind == "moveit":
        goal.trajectory.joint_trajectory = trajectory
    else:
        goal.trajectory = trajectory
    return goal


def wait(future):
    while not future.done():
        rclpy.spin_once(node, timeout_sec=0.05)
    return future.result()


def spin(seconds):
    until = time.monotonic() + seconds
    while (left := until - time.monotonic()) > 0:
        rclpy.spin_once(node, timeout_sec=left)


def moved(command):
    samples.clear()
    feedback.clear()
    goal = goal_of(command["points"])
    handle = wait(client.send_goal_async(goal, feedback_callback=lambda told: feedback.append(told)))
    if not handle.accepted:
        return {"status": "rejected"}
    begun, result, answer, asked = time.time(), handle.get_result_async(), None, None
    how = command.get("how")
    sys.stdout.write('{"accepted": true}\n')
    sys.stdout.flush()
    if how not in (None, "early"):
        spin(command["after"])
    second = None
    if how == "replace":
        second = wait(client.send_goal_async(goal))
        spin(0.1)
    if how is not None:
        asked = time.time()
        if how == "all":
            answer = wait(cancel_all.call_async(CancelGoal.Request()))
        else:
            answer = wait(handle.cancel_goal_async())
    ended = wait(result)
    at = time.time()
    spin(AFTER)
    said = {
        "status": ended.status,
        "error_code": getattr(ended.result, "error_code", None) if kind == "trajectory" else None,
        "begun": begun,
        "asked": asked,
        "ended": at,
        "feedback": len(feedback),
        "samples": list(samples),
    }
    if answer is not None:
        said |= {"return_code": answer.return_code, "canceling": len(answer.goals_canceling)}
    if second is not None:
        said["second"] = wait(second.get_result_async()).status
    return said


assert client.wait_for_server(60.0)
assert cancel_all.wait_for_service(60.0)
while not samples:
    rclpy.spin_once(node, timeout_sec=0.1)
sys.stdout.write(json.dumps({"ready": samples[-1]}) + "\n")
sys.stdout.flush()
for line in sys.stdin:
    sys.stdout.write(json.dumps(moved(json.loads(line))) + "\n")
    sys.stdout.flush()
