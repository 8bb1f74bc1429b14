"""Serve the search as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import numpy as np
import rclpy
from geometry_msgs.msg import Point, Vector3
from hand_search_interfaces.msg import GraspConfig
from hand_search_interfaces.srv import DetectGrasps
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from search import search


def points_of(cloud):
    """Return the points of a PointCloud2 with float32 x, y, z, as an array of shape (n, 3)."""
    if not cloud.data:
        return np.zeros((0, 3))
    offsets = [next(f.offset for f in cloud.fields if f.name == axis) for axis in "xyz"]
    rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    return np.hstack([rows[:, k : k + 4].copy().view("<f4") for k in offsets]).astype(float)


def xyz(kind, numbers):
    """Return a message with x, y, z."""
    return kind(**dict(zip("xyz", map(float, numbers), strict=True)))


class Detector(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("cloud_antipodal")
        self.create_service(DetectGrasps, "/detect_grasps", self.answer)

    def answer(self, request, response):
        """Detect grasps in the cloud of a request."""
        response.configs.header = request.cloud.header
        for hand in search(points_of(request.cloud), request.samples):
            response.configs.grasps.append(
                GraspConfig(
                    bottom=xyz(Point, 100 * hand.bottom),
                    approach=xyz(Vector3, hand.approach),
                    binormal=xyz(Vector3, hand.binormal),
                    width=100 * hand.width,
                    score=hand.score,
                )
            )
        self.get_logger().info(f"{len(response.configs.grasps)} grasps")
        return response


def main():
    """Serve until somebody stops us."""
    rclpy.init()
    node = Detector()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
