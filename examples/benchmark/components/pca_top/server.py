"""Serve the planner as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import numpy as np
import rclpy
from geometry_msgs.msg import Point, Pose, Quaternion
from pca_interfaces.msg import TopGrasp
from pca_interfaces.srv import PlanTopGrasps
from planner import plan, quaternion
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


def points_of(cloud):
    """Return the points of a PointCloud2 with float32 x, y, z, as an array of shape (n, 3)."""
    if not cloud.data:
        return np.zeros((0, 3))
    offsets = [next(f.offset for f in cloud.fields if f.name == axis) for axis in "xyz"]
    rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    return np.hstack([rows[:, k : k + 4].copy().view("<f4") for k in offsets]).astype(float)


class Planner(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("pca_top")
        self.create_service(PlanTopGrasps, "/plan_top_grasps", self.answer)

    def answer(self, request, response):
        """Plan for the cloud of a request."""
        for grasp in plan(points_of(request.cloud)):
            x, y, z = map(float, grasp.position)
            qx, qy, qz, qw = map(float, quaternion(grasp.closing))
            pose = Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))
            response.grasps.append(TopGrasp(pose=pose, width_mm=1000 * grasp.width, score=grasp.score))
        self.get_logger().info(f"{len(response.grasps)} grasps")
        return response


def main():
    """Serve until somebody stops us."""
    rclpy.init()
    node = Planner()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
