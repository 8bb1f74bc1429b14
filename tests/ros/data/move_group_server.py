"""A stand-in for MoveIt's move_group: `move_group_server.py ROBOT [NAMESPACE]`.

It keeps a scene as MoveIt does (differences, attached objects, a matrix of allowed collisions that begins with what the
robot declares), plans in it with our own planner, and moves the joints that it publishes. It understands what is sent
from the messages alone. A planner id of `fail:CODE` is answered with that code, `hang` with nothing until it is
cancelled; a trajectory that ends with its first joint beyond 2.5 rad is given up half-way.
"""

import sys
import threading
import time
from pathlib import Path

import numpy as np
import rclpy
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import AllowedCollisionEntry, AttachedCollisionObject, MoveItErrorCodes
from moveit_msgs.srv import ApplyPlanningScene, GetCartesianPath, GetMotionPlan, GetPlanningScene, GetPositionIK
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from sensor_msgs.msg import JointState as JointStateMessage

from grip_bt.base.failures import (
    CanceledError,
    ConstraintBrokenError,
    ExpectedError,
    GoalInCollisionError,
    NoIkError,
    StartInCollisionError,
)
from grip_bt.base.values import JointState, PathConstraint, Pose
from grip_bt.base.values.solids import Box, Cylinder, Mesh, Sphere
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.answer import plan_to
from grip_bt.commanders.planning.checks import chain_and_checker, goals_of
from grip_bt.commanders.planning.requests import PlanStraight, PlanTo, Situation
from grip_bt.commanders.planning.straight import plan_straight
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.ros.convert_values import pose_from_message, trajectory_to_message

BRAKING = 4.0
moving = []
namespace = sys.argv[2] if len(sys.argv) > 2 else ""
description = load_robot(sys.argv[1], Path.cwd())
model, thinking, telling = RobotModel(description), threading.Lock(), threading.Lock()
frame = description.grasp_frame
links = sorted({name for pair in description.disabled_pairs for name in pair})
state = {**dict.fromkeys(description.joints, 0.0), **description.at_rest}
world, attached = {}, {}
matrix = {"names": list(links), "allowed": set(description.disabled_pairs)}


def code(value, words=""):
    return MoveItErrorCodes(val=value, message=words)


# --- the scene ---


def change(message):
    if message.operation == b"\x01":
        world.pop(message.id, None)
    else:
        world[message.id] = message


def hold(message):
    if message.object.operation == b"\x01":
        held = attached.pop(message.object.id, None)
        if held is not None:  # as MoveIt does: what is detached stays in the world, where it is
            at = pose_from_message(held.object.pose, "link")
            held.object.header.frame_id = description.base_link
            grasp = model.grasp_pose(JointState.from_mapping(state))
            where = grasp @ frame.pose.inverse() @ at
            held.object.pose.position.x, held.object.pose.position.y, held.object.pose.position.z = where.position
            world[held.object.id] = held.object
    else:
        world.pop(message.object.id, None)
        attached[message.object.id] = message


def apply(request, response):
    scene = request.scene
    assert scene.is_diff
    assert scene.robot_state.is_diff
    for message in scene.robot_state.attached_collision_objects:
        hold(message)
    for message in scene.world.collision_objects:
        change(message)
    new = scene.allowed_collision_matrix
    if new.entry_names:
        matrix["names"] = list(new.entry_names)
        matrix["allowed"] = {
            tuple(sorted((one, other)))
            for one, row in zip(new.entry_names, new.entry_values, strict=True)
            for other, may in zip(new.entry_names, row.enabled, strict=True)
            if may
        }
    response.success = "refused" not in world
    return response


def tell(request, response):
    names = response.scene.allowed_collision_matrix.entry_names = matrix["names"]
    response.scene.allowed_collision_matrix.entry_values = [
        AllowedCollisionEntry(enabled=[tuple(sorted((a, b))) in matrix["allowed"] for b in names]) for a in names
    ]
    response.scene.world.collision_objects = list(world.values())
    response.scene.robot_state.attached_collision_objects = list(attached.values())
    return response


def solid(message):
    if message.meshes:
        mesh = message.meshes[0]
        points = np.array([(p.x, p.y, p.z) for p in mesh.vertices])
        return Mesh(points, np.array([t.vertex_indices for t in mesh.triangles], np.int32))
    size = list(message.primitives[0].dimensions)
    return {1: lambda: Box(size), 2: lambda: Sphere(size[0]), 3: lambda: Cylinder(size[1], size[0])}[
        message.primitives[0].type
    ]()


def snapshot():
    objects = {name: SceneObject(name, solid(o), pose_from_message(o.pose)) for name, o in world.items()}
    for name, held in attached.items():
        assert isinstance(held, AttachedCollisionObject)
        assert held.link_name == frame.link
        at = frame.pose.inverse() @ pose_from_message(held.object.pose, "link")
        objects[name] = SceneObject(name, solid(held.object), Pose(at.position, at.quaternion), "hand")
    return SceneSnapshot(objects, frozenset(matrix["allowed"] - set(description.disabled_pairs)))


# --- planning ---


def situation(group, start, request=None, scene=None):
    known = {**state, **dict(zip(start.joint_state.name, start.joint_state.position, strict=True))}
    settings = PlanningSettings(
        speed=request.max_velocity_scaling_factor if request else 0.5,
        acceleration=request.max_acceleration_scaling_factor if request else 0.5,
        planning_time=request.allowed_planning_time if request else 5.0,
        margin=0.0,
    )
    return Situation(group, JointState.from_mapping(known), snapshot() if scene is None else scene, "hand", settings)


def grasp(link):
    """Return the pose of the grasp frame that a pose of its link means."""
    return Pose.from_matrix(link.matrix() @ frame.pose.matrix())


def goal_of(constraints):
    joints = constraints.joint_constraints
    if joints:
        return JointState(tuple(j.joint_name for j in joints), np.array([j.position for j in joints])), "none"
    (position,), orientations = constraints.position_constraints, constraints.orientation_constraints
    point = pose_from_message(position.constraint_region.primitive_poses[0])
    offset = position.target_point_offset
    assert np.allclose([offset.x, offset.y, offset.z], frame.pose.position)
    assert position.link_name == frame.link
    assert position.header.frame_id == description.base_link
    if not orientations:
        return point, "orientation"
    q = orientations[0].orientation
    turned = Pose(np.zeros(3), np.array([q.w, q.x, q.y, q.z])) @ Pose(np.zeros(3), frame.pose.quaternion)
    return Pose(point.position, turned.quaternion), "none"


def kept_by(constraints):
    """Return what a path keeps to, about the grasp frame; tolerances as they are, whatever its axes in the link."""
    fields = {}
    for orientation in constraints.orientation_constraints:
        q = orientation.orientation
        turned = Pose(np.zeros(3), np.array([q.w, q.x, q.y, q.z])) @ Pose(np.zeros(3), frame.pose.quaternion)
        names = [f"absolute_{axis}_axis_tolerance" for axis in "xyz"]
        fields |= {"orientation": turned, "axes": "own", "tolerance": tuple(getattr(orientation, n) for n in names)}
    for position in constraints.position_constraints:
        region = position.constraint_region
        size = tuple(region.primitives[0].dimensions)
        fields |= {"box": pose_from_message(region.primitive_poses[0]), "size": size}
    return PathConstraint(**fields) if fields else None


def search(request, canceled):
    """Return code, trajectory."""
    if request.planner_id.startswith("fail:"):
        return code(int(request.planner_id[5:]), "so it was asked"), None
    while request.planner_id == "hang":
        if canceled():
            return code(MoveItErrorCodes.PREEMPTED), None
        time.sleep(0.01)
    if request.group_name not in description.groups:
        return code(MoveItErrorCodes.INVALID_GROUP_NAME), None
    goal, free = goal_of(request.goal_constraints[0])
    kept = kept_by(request.path_constraints)
    asked = PlanTo(situation(request.group_name, request.start_state, request), goal, (), free, kept)
    try:
        with thinking:
            return code(MoveItErrorCodes.SUCCESS), plan_to(model, asked, canceled)
    except StartInCollisionError:
        return code(MoveItErrorCodes.START_STATE_IN_COLLISION), None
    except CanceledError:
        return code(MoveItErrorCodes.PREEMPTED), None
    except ConstraintBrokenError as error:
        codes = MoveItErrorCodes
        broken = codes.GOAL_VIOLATES_PATH_CONSTRAINTS, codes.START_STATE_VIOLATES_PATH_CONSTRAINTS
        return code(broken["start" in error.message], error.message), None
    except ExpectedError as error:
        return code(MoveItErrorCodes.PLANNING_FAILED, error.message), None


def move(handle):
    assert handle.request.planning_options.plan_only
    result = MoveGroup.Result()
    result.error_code, found = search(handle.request.request, lambda: handle.is_cancel_requested)
    if found is not None:
        result.planned_trajectory.joint_trajectory = trajectory_to_message(found)
        handle.succeed()
    elif result.error_code.val == MoveItErrorCodes.PREEMPTED:
        handle.canceled()
    else:
        handle.abort()
    return result


def plan(request, response):
    response.motion_plan_response.error_code, found = search(request.motion_plan_request, lambda: False)
    if found is not None:
        response.motion_plan_response.trajectory.joint_trajectory = trajectory_to_message(found)
    return response


def straight(request, response):
    poses = tuple(grasp(pose_from_message(p)) for p in request.waypoints)
    scene = None if request.avoid_collisions else SceneSnapshot()
    asked = PlanStraight(situation(request.group_name, request.start_state, scene=scene), poses)
    response.error_code = code(MoveItErrorCodes.SUCCESS)
    try:
        with thinking:
            found = plan_straight(model, asked)
        response.solution.joint_trajectory, response.fraction = trajectory_to_message(found), 1.0
    except ExpectedError as error:
        response.fraction = float(error.data.get("fraction", 0.5))
    return response


def inverse(request, response):
    asked = request.ik_request
    scene = None if asked.avoid_collisions else SceneSnapshot()
    where = situation(asked.group_name, asked.robot_state, scene=scene)
    pose = grasp(pose_from_message(asked.pose_stamped.pose))
    try:
        with thinking:
            chain, checker = chain_and_checker(model, where)
            start = where.start.ordered(chain.joints)
            found = goals_of(chain, checker, PlanTo(where, pose), start)[0]
    except (NoIkError, GoalInCollisionError):
        response.error_code = code(MoveItErrorCodes.NO_IK_SOLUTION)
        return response
    known = {**where.start.as_mapping(), **dict(zip(chain.joints, found, strict=True))}
    response.solution.joint_state.name = list(known)
    response.solution.joint_state.position = [float(q) for q in known.values()]
    response.error_code = code(MoveItErrorCodes.SUCCESS)
    return response


# --- moving ---


def brake(handle, names, start, speeds):
    """Come to rest evenly, as the controllers do that move_group has cancelled; a newer goal takes over."""
    takes, began, now = float(np.abs(speeds).max()) / BRAKING, time.monotonic(), 0.0
    while moving[-1] is handle and now < takes:
        now = min(time.monotonic() - began, takes)
        with telling:
            state.update(zip(names, (start + speeds * (now - now**2 / (2 * takes))).tolist(), strict=True))
        time.sleep(0.005)


def execute(handle):
    moving.append(handle)
    trajectory, result = handle.request.trajectory.joint_trajectory, ExecuteTrajectory.Result()
    times = np.array([p.time_from_start.sec + p.time_from_start.nanosec * 1e-9 for p in trajectory.points])
    rows = np.array([p.positions for p in trajectory.points])
    hopeless, began = rows[-1, 0] > 2.5, time.monotonic()
    while (now := time.monotonic() - began) < times[-1]:
        if handle.is_cancel_requested or (hopeless and now > times[-1] / 2):
            stopped = handle.is_cancel_requested
            result.error_code = code(
                MoveItErrorCodes.PREEMPTED if stopped else MoveItErrorCodes.CONTROL_FAILED, "blocked"
            )
            (handle.canceled if stopped else handle.abort)()
            before = np.array([np.interp(max(now - 0.01, 0.0), times, column) for column in rows.T])
            here = np.array([np.interp(now, times, column) for column in rows.T])
            braking = (handle, trajectory.joint_names, here, (here - before) / 0.01)
            threading.Thread(target=brake, args=braking, daemon=True).start()
            return result
        state.update({n: float(np.interp(now, times, rows[:, i])) for i, n in enumerate(trajectory.joint_names)})
        time.sleep(0.005)
    with telling:
        state.update(zip(trajectory.joint_names, rows[-1].tolist(), strict=True))
    result.error_code = code(MoveItErrorCodes.SUCCESS)
    handle.succeed()
    return result


rclpy.init()
node = rclpy.create_node("move_group", namespace=namespace or "/")
group = ReentrantCallbackGroup()
for type_, name, function in (
    (ApplyPlanningScene, "apply_planning_scene", apply),
    (GetPlanningScene, "get_planning_scene", tell),
    (GetMotionPlan, "plan_kinematic_path", plan),
    (GetCartesianPath, "compute_cartesian_path", straight),
    (GetPositionIK, "compute_ik", inverse),
):
    node.create_service(type_, name, function, callback_group=group)
servers = [
    ActionServer(node, t, name, function, cancel_callback=lambda _: CancelResponse.ACCEPT, callback_group=group)
    for t, name, function in ((MoveGroup, "move_action", move), (ExecuteTrajectory, "execute_trajectory", execute))
]
publisher = node.create_publisher(JointStateMessage, "joint_states", 10)  # in its own namespace


def publish():
    with telling:  # so that nothing stale is published after the end of a motion
        message = JointStateMessage(name=list(state), position=[float(q) for q in state.values()])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)


def publish_always():
    """A timer would wake the executor fifty times a second, which looks at all servers each time."""
    while True:
        publish()
        time.sleep(0.02)


threading.Thread(target=publish_always, daemon=True).start()
executor = MultiThreadedExecutor(4)
executor.add_node(node)
sys.stdout.write("serving\n")
sys.stdout.flush()
executor.spin()
