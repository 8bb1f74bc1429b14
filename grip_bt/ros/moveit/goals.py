"""Goals and path constraints in MoveIt's words."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Pose as PoseMessage
from geometry_msgs.msg import Vector3
from shape_msgs.msg import SolidPrimitive

from grip_bt.base.failures import GoalRejectedError
from grip_bt.base.values import JointState, Pose

from ..convert_geometry import header, pose_to_message
from ..types import load_type
from .mount import Mount

JOINT_TOLERANCE = 1e-4
"""How near to a goal a joint has to come [rad or m]."""
REACH = 1e-3
"""How near to a goal the grasp frame has to come [m]; MoveIt's kinematics aims at the middle."""
TURN = 1e-2
"""The same of its orientation, about each axis [rad]."""
ANY = np.pi
"""A tolerance that leaves an axis free [rad]."""
TURNS = 12
"""Goals for a free turn about an axis that isn't one of the link's: as many, evenly spread."""
_ROTATION_VECTOR = 1


def at_joints(goal: JointState) -> Any:
    """Return the constraints of joint positions."""
    constraint = load_type("moveit_msgs/msg/JointConstraint")
    return load_type("moveit_msgs/msg/Constraints")(
        joint_constraints=[
            constraint(
                joint_name=name,
                position=float(position),
                tolerance_above=JOINT_TOLERANCE,
                tolerance_below=JOINT_TOLERANCE,
                weight=1.0,
            )
            for name, position in zip(goal.names, goal.position, strict=True)
        ]
    )


def at_pose(pose: Pose, free: str, mount: Mount, frame: str) -> list[Any]:
    """Return the constraints of a grasp frame's pose; any of them is the goal.

    A free turn about an axis of the grasp frame is a tolerance where that is an axis of the link too; MoveIt knows no
    other axes, so otherwise several turned poses stand for it.

    Args:
        pose: of the grasp frame, in world.
        free: what of it doesn't matter: `none`, `x`, `y`, `z` or `orientation`.
        mount: the arm.
        frame: MoveIt's name of world.
    """
    if free == "orientation":
        return [_constraints([_at_point(pose, mount, frame)], [])]
    if free == "none":
        return [_posed(pose, (TURN, TURN, TURN), mount, frame)]
    axis = mount.frame.rotation()[:, "xyz".index(free)]
    along = int(np.abs(axis).argmax())
    if abs(axis[along]) > 1 - 1e-6:
        tolerance = [TURN, TURN, TURN]
        tolerance[along] = ANY
        return [_posed(pose, (tolerance[0], tolerance[1], tolerance[2]), mount, frame)]
    angles = np.arange(TURNS) * 2 * np.pi / TURNS
    turned = (pose @ _turn(free, angle) for angle in angles)
    return [_posed(one, (TURN, TURN, TURN), mount, frame) for one in turned]


def on_the_way(constraint: Any, mount: Mount, frame: str) -> Any:
    """Return the path constraints of a `PathConstraint`, about the link that carries the grasp frame.

    Raises:
        GoalRejectedError: its tolerances are about axes that MoveIt can't express: those of the world while the
            orientation that is kept is turned against it, with different tolerances.
    """
    positions, orientations = [], []
    if constraint.orientation is not None:
        orientations.append(_kept_orientation(constraint, mount, frame))
    if constraint.box is not None:
        positions.append(_in_box(constraint.box, constraint.size, mount, frame))
    return _constraints(positions, orientations)


def _kept_orientation(constraint: Any, mount: Mount, frame: str) -> Any:
    """Return the constraint of an orientation: tolerances are turned to the link's axes where that is exact."""
    to_link = mount.frame.rotation()
    if getattr(constraint, "axes", "own") == "world":
        to_link = to_link @ constraint.orientation.rotation().T
    tolerance = np.minimum(np.array(constraint.tolerance, dtype=float), ANY)
    places = np.abs(to_link)
    if np.ptp(tolerance) > 1e-9:
        if (np.abs(places.max(axis=1) - 1) > 1e-6).any():
            raise GoalRejectedError(
                "move_group keeps tolerances only about the axes of the link that carries the hand; "
                "give the same tolerance about all three axes, or plan with one of our own planners"
            )
        tolerance = tolerance[places.argmax(axis=1)]
    link = mount.link_pose(Pose(np.zeros(3), constraint.orientation.quaternion))
    return _oriented(link, (float(tolerance[0]), float(tolerance[1]), float(tolerance[2])), mount, frame)


def _posed(pose: Pose, tolerance: tuple[float, float, float], mount: Mount, frame: str) -> Any:
    oriented = _oriented(mount.link_pose(pose), tolerance, mount, frame)
    return _constraints([_at_point(pose, mount, frame)], [oriented])


def _at_point(pose: Pose, mount: Mount, frame: str) -> Any:
    """Return the constraint that the grasp frame's origin is where it is in `pose`."""
    ball = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[REACH])
    return _within(ball, pose, mount, frame)


def _in_box(pose: Pose, size: tuple[float, float, float], mount: Mount, frame: str) -> Any:
    return _within(SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(map(float, size))), pose, mount, frame)


def _within(shape: SolidPrimitive, pose: Pose, mount: Mount, frame: str) -> Any:
    x, y, z = map(float, mount.frame.position)
    region = load_type("moveit_msgs/msg/BoundingVolume")(primitives=[shape], primitive_poses=[pose_to_message(pose)])
    return load_type("moveit_msgs/msg/PositionConstraint")(
        header=header(frame),
        link_name=mount.link,
        target_point_offset=Vector3(x=x, y=y, z=z),
        constraint_region=region,
        weight=1.0,
    )


def _oriented(link: Pose, tolerance: tuple[float, float, float], mount: Mount, frame: str) -> Any:
    message: PoseMessage = pose_to_message(link)
    x, y, z = tolerance
    return load_type("moveit_msgs/msg/OrientationConstraint")(
        header=header(frame),
        orientation=message.orientation,
        link_name=mount.link,
        absolute_x_axis_tolerance=x,
        absolute_y_axis_tolerance=y,
        absolute_z_axis_tolerance=z,
        parameterization=_ROTATION_VECTOR,
        weight=1.0,
    )


def _constraints(positions: list[Any], orientations: list[Any]) -> Any:
    kind = load_type("moveit_msgs/msg/Constraints")
    return kind(position_constraints=positions, orientation_constraints=orientations)


def _turn(axis: str, angle: float) -> Pose:
    quaternion = np.zeros(4)
    quaternion[0], quaternion[1 + "xyz".index(axis)] = np.cos(angle / 2), np.sin(angle / 2)
    return Pose(np.zeros(3), quaternion)
