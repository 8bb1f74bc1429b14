"""Goals, path constraints and solids as MoveIt's messages, and how an arm of the project is called there."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from geometry_msgs.msg import Point, Vector3
from geometry_msgs.msg import Pose as PoseMessage
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from shape_msgs.msg import Mesh as MeshMessage
from shape_msgs.msg import MeshTriangle, SolidPrimitive

from grip_bt.base.failures import GoalRejectedError
from grip_bt.base.values import JointState, Pose
from grip_bt.base.values.goals import PathConstraint
from grip_bt.base.values.pose import quaternion_of
from grip_bt.base.values.solids import Box, CellMap, Cylinder, Mesh, Solid, Sphere
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.kinematics.shapes import surface_of

from ..client.types import Message, load_type
from ..convert_values import header, pose_to_message

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


def at_joints(goal: JointState) -> Message:
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


def at_pose(pose: Pose, free: str, mount: ArmMapping, frame: str) -> list[Message]:
    """Return the constraints of a grasp frame's pose; any of them is the goal.

    A free turn about an axis of the grasp frame is a tolerance where that is an axis of the link too; MoveIt knows no
    other axes, so otherwise several turned poses stand for it.

    Args:
        pose: of the grasp frame, in world.
        free: what of it doesn't matter: `none`, `x`, `y`, `z` or `orientation`.
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
    turns = (Pose(np.zeros(3), quaternion_of(*np.eye(3)["xyz".index(free)] * angle)) for angle in angles)
    return [_posed(pose @ turn, (TURN, TURN, TURN), mount, frame) for turn in turns]


def on_the_way(constraint: PathConstraint, mount: ArmMapping, frame: str) -> Message:
    """Return the path constraints of a `PathConstraint`, about the link that carries the grasp frame.

    Raises:
        GoalRejectedError: its tolerances are about axes that MoveIt can't express: those of the world while the
            orientation that is kept is turned against it, with different tolerances.
    """
    positions, orientations = [], []
    if constraint.orientation is not None:
        orientations.append(_kept_orientation(constraint, mount, frame))
    if constraint.box is not None:
        box = SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(map(float, constraint.size)))
        positions.append(_within(box, constraint.box, mount, frame))
    return _constraints(positions, orientations)


def _kept_orientation(constraint: PathConstraint, mount: ArmMapping, frame: str) -> Message:
    """Return the constraint of an orientation: tolerances are turned to the link's axes where that is exact."""
    assert constraint.orientation is not None
    to_link = mount.frame.rotation()
    if constraint.axes == "world":
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


def _posed(pose: Pose, tolerance: tuple[float, float, float], mount: ArmMapping, frame: str) -> Message:
    oriented = _oriented(mount.link_pose(pose), tolerance, mount, frame)
    return _constraints([_at_point(pose, mount, frame)], [oriented])


def _at_point(pose: Pose, mount: ArmMapping, frame: str) -> Message:
    """Return the constraint that the grasp frame's origin is where it is in `pose`."""
    ball = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[REACH])
    return _within(ball, pose, mount, frame)


def _within(shape: SolidPrimitive, pose: Pose, mount: ArmMapping, frame: str) -> Message:
    x, y, z = map(float, mount.frame.position)
    region = load_type("moveit_msgs/msg/BoundingVolume")(primitives=[shape], primitive_poses=[pose_to_message(pose)])
    return load_type("moveit_msgs/msg/PositionConstraint")(
        header=header(frame),
        link_name=mount.link,
        target_point_offset=Vector3(x=x, y=y, z=z),
        constraint_region=region,
        weight=1.0,
    )


def _oriented(link: Pose, tolerance: tuple[float, float, float], mount: ArmMapping, frame: str) -> Message:
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


def _constraints(positions: list[Message], orientations: list[Message]) -> Message:
    kind = load_type("moveit_msgs/msg/Constraints")
    return kind(position_constraints=positions, orientation_constraints=orientations)


@dataclass(frozen=True)
class ArmMapping:
    """One arm with its hand.

    Attributes:
        group: MoveIt's group of the arm's joints.
        link: the link that the grasp frame is fixed to.
        frame: the grasp frame in that link.
        hand_links: links of the hand, which may touch what it holds.
    """

    group: str
    joints: tuple[str, ...]
    link: str
    frame: Pose
    hand_links: tuple[str, ...]

    @classmethod
    def of(cls, robot: RobotDescription, group: str, hand_group: str = "", moveit_group: str = "") -> ArmMapping:
        """Return the mount of a group of the robot.

        Args:
            hand_group: group of the hand that it carries; empty for none.
            moveit_group: MoveIt's name of the arm's group; the same as ours by default.

        Raises:
            UnknownNameError: the robot has no such group.
        """
        frame = robot.grasp_frames.get(group, robot.grasp_frame)
        links = robot.hands.get(hand_group, robot.hand_links) if hand_group else ()
        return cls(moveit_group or group, robot.group(group), frame.link, frame.pose, tuple(links))

    def link_pose(self, grasp: Pose) -> Pose:
        """Return where the link is when the grasp frame is at `grasp`."""
        return grasp @ self.frame.inverse()


ADD, REMOVE = b"\x00", b"\x01"


def collision_object(name: str, solid: Solid, pose: Pose, frame: str) -> Message:
    """Return the message that adds or replaces an object.

    Args:
        solid: its shape; hulls become triangles, maps of cells their cells.
        pose: where its own axes are in `frame`.
        frame: a link or another frame that MoveIt knows.
    """
    message = load_type("moveit_msgs/msg/CollisionObject")(
        header=header(frame), id=name, pose=pose_to_message(pose), operation=ADD
    )
    match solid:
        case Box():
            message.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(solid.size))]
        case Cylinder():
            size = [solid.height, solid.radius]
            message.primitives = [SolidPrimitive(type=SolidPrimitive.CYLINDER, dimensions=size)]
        case Sphere():
            message.primitives = [SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[solid.radius])]
        case Mesh():
            message.meshes = [_mesh(*surface_of(solid))]
        case CellMap():
            message.meshes = [_mesh(*_cubes(solid))]
    message.primitive_poses = [PoseMessage() for _ in message.primitives]
    message.mesh_poses = [PoseMessage() for _ in message.meshes]
    return message


def removed(name: str) -> Message:
    """Return the message that removes an object."""
    return load_type("moveit_msgs/msg/CollisionObject")(id=name, operation=REMOVE)


def _cubes(cells: CellMap) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return points and triangles of the occupied cells, each a cube."""
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    points = (cells.cells[:, None, :] + corners) * cells.resolution
    triangles = 8 * np.arange(len(points))[:, None, None] + ConvexHull(corners).simplices
    return points.reshape(-1, 3), triangles.reshape(-1, 3).astype(np.int32)


def _mesh(points: NDArray[np.float64], triangles: Iterable[NDArray[np.int32]]) -> MeshMessage:
    return MeshMessage(
        vertices=[Point(x=x, y=y, z=z) for x, y, z in points.tolist()],
        triangles=[MeshTriangle(vertex_indices=np.asarray(t, np.uint32)) for t in triangles],
    )
