"""Solids as the shapes of MoveIt's collision objects."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from geometry_msgs.msg import Point
from geometry_msgs.msg import Pose as PoseMessage
from numpy.typing import NDArray
from shape_msgs.msg import Mesh as MeshMessage
from shape_msgs.msg import MeshTriangle, SolidPrimitive

from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box, CellMap, Cylinder, Mesh, Solid, Sphere

from ..convert_geometry import header, pose_to_message
from ..types import load_type

ADD, REMOVE = b"\x00", b"\x01"


def collision_object(name: str, solid: Solid, pose: Pose, frame: str) -> Any:
    """Return the message that adds or replaces an object.

    Args:
        name: of the object.
        solid: its shape; hulls become triangles, maps of cells the surface of their cells.
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
            message.meshes = [_mesh(*_surface(solid))]
        case CellMap():
            message.meshes = [_mesh(*_faces(solid))]
    message.primitive_poses = [PoseMessage() for _ in message.primitives]
    message.mesh_poses = [PoseMessage() for _ in message.meshes]
    return message


def removed(name: str) -> Any:
    """Return the message that removes an object."""
    return load_type("moveit_msgs/msg/CollisionObject")(id=name, operation=REMOVE)


def _surface(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return points and triangles of a mesh; those of its hull, thickened by its margin, where it is solid."""
    if mesh.hollow:
        return mesh.points, mesh.triangles
    from scipy.spatial import ConvexHull

    hull = ConvexHull(mesh.points)
    if mesh.margin == 0:
        return mesh.points, hull.simplices.astype(np.int32)
    # Each point moved out along every axis and both ways: a hull that holds the true thickened one.
    steps = mesh.margin * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    points = (mesh.points[hull.vertices][:, None, :] + steps).reshape(-1, 3)
    return points, ConvexHull(points).simplices.astype(np.int32)


def _faces(cells: CellMap) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return points and triangles of the faces that separate occupied cells from others."""
    taken = {tuple(cell) for cell in cells.cells.tolist()}
    corners: list[NDArray[np.float64]] = []
    for axis in range(3):
        for side in (0, 1):
            step = np.zeros(3, int)
            step[axis] = 2 * side - 1
            outer = np.array([c for c in cells.cells.tolist() if tuple(np.add(c, step).tolist()) not in taken])
            if len(outer):
                corners.append((outer[:, None, :] + _square(axis, side)) * cells.resolution)
    squares = np.concatenate(corners).reshape(-1, 3)
    points, index = np.unique(squares.round(9), axis=0, return_inverse=True)
    quads = index.reshape(-1, 4)
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)


def _square(axis: int, side: int) -> NDArray[np.float64]:
    """Return the corners of a unit cell's face, shape (4, 3), in order around it."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    corners = np.zeros((4, 3))
    corners[:, axis] = side
    corners[[1, 2], one] = 1
    corners[[2, 3], other] = 1
    return corners


def _mesh(points: NDArray[np.float64], triangles: Iterable[Any]) -> MeshMessage:
    return MeshMessage(
        vertices=[Point(x=x, y=y, z=z) for x, y, z in points.tolist()],
        triangles=[MeshTriangle(vertex_indices=np.asarray(t, np.uint32)) for t in triangles],
    )
