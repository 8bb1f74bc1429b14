"""Serves the algorithm as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import numpy as np
import rclpy
from algorithm import find
from component_name_interfaces.srv import ComponentName
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

FOUND, NONE = 0, 1  # the outcomes, as component.yaml names them


def points_of(cloud):
    """Return the points of a PointCloud2 with float32 x, y, z, as an array of shape (n, 3)."""
    if not cloud.data:
        return np.zeros((0, 3))
    offsets = [next(f.offset for f in cloud.fields if f.name == axis) for axis in "xyz"]
    rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    columns = [rows[:, offset : offset + 4].copy().view("<f4") for offset in offsets]
    points = np.hstack(columns).astype(float)
    return points[np.isfinite(points).all(axis=1)]


class Server(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("component_name")
        self.create_service(ComponentName, "/component_name", self.answer)

    def answer(self, request, response):
        """Answer one request."""
        found = find(points_of(request.input))
        response.outcome = NONE if found is None else FOUND
        if found is not None:
            response.returned_object.header = request.input.header
            p = response.returned_object.pose.position
            p.x, p.y, p.z = map(float, found)
            response.returned_object.pose.orientation.w = 1.0
        return response


if __name__ == "__main__":
    rclpy.init()
    try:
        rclpy.spin(Server())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
