"""Serve the registration of clouds as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import sys

import numpy as np
import rclpy
from geometry_msgs.msg import Pose
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from registration_interfaces.srv import RegisterClouds
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import PointCloud2, PointField

try:
    from registration import applied, merged, register
except ImportError as error:
    sys.exit(f"{error}. The registration needs small_gicp: pip install 'grip-bt[registration]'")

REGISTERED, POOR = 0, 1  # the outcomes, as component.yaml names them
WORST = 0.005  # neighbouring points that are farther apart than this, on average, don't fit [m]


def points_of(cloud):
    """Return the points of a PointCloud2 with float32 x, y, z, as an array of shape (n, 3)."""
    offsets = [next(f.offset for f in cloud.fields if f.name == axis) for axis in "xyz"]
    rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    points = np.hstack([rows[:, offset : offset + 4].copy().view("<f4") for offset in offsets]).astype(float)
    return points[np.isfinite(points).all(axis=1)]


def cloud_of(header, points):
    """Return points as a PointCloud2."""
    fields = [PointField(name=n, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, n in enumerate("xyz")]
    size = {"height": 1, "width": len(points), "point_step": 12, "row_step": 12 * len(points), "is_dense": True}
    return PointCloud2(header=header, fields=fields, data=points.astype("<f4").tobytes(), **size)


def pose_of(matrix):
    """Return a matrix of shape (4, 4) as a Pose."""
    message = Pose()
    p, q = message.position, message.orientation
    p.x, p.y, p.z = map(float, matrix[:3, 3])
    q.x, q.y, q.z, q.w = map(float, Rotation.from_matrix(matrix[:3, :3]).as_quat())
    return message


class Registration(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("registration")
        self.create_service(RegisterClouds, "/register_clouds", self.answer)

    def answer(self, request, response):
        """Register the clouds of a request; without any there is nothing to return."""
        clouds = [points_of(cloud) for cloud in request.input if cloud.data]
        response.outcome = POOR
        if len(clouds) != len(request.input) or not clouds:
            return response
        moved, response.residual = register(clouds, request.cell, request.reach, request.table)
        whole = merged([applied(m, cloud) for m, cloud in zip(moved, clouds, strict=True)], request.cell)
        response.returned_object = cloud_of(request.input[0].header, whole)
        response.corrections = [pose_of(m) for m in moved]
        response.outcome = REGISTERED if response.residual < WORST else POOR
        self.get_logger().info(f"{len(clouds)} clouds, {1000 * response.residual:.2f} mm between neighbours")
        return response


def main():
    """Serve until somebody stops us."""
    rclpy.init()
    node = Registration()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
