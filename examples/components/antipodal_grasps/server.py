"""Serve the grasp proposer as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import numpy as np
import rclpy
from antipodal_interfaces.msg import GraspCandidate
from antipodal_interfaces.srv import ProposeGrasps
from geometry_msgs.msg import PoseStamped
from proposer import propose
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

ONE, SEVERAL, NONE = 0, 1, 2  # the outcomes, as component.yaml names them


def points_of(cloud):
    """Return the points of a PointCloud2 with float32 x, y, z, as an array of shape (n, 3)."""
    if not cloud.data:
        return np.zeros((0, 3))
    offsets = [next(f.offset for f in cloud.fields if f.name == axis) for axis in "xyz"]
    rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    columns = [rows[:, offset : offset + 4].copy().view("<f4") for offset in offsets]
    points = np.hstack(columns).astype(float)
    return points[np.isfinite(points).all(axis=1)]


def stamped(header, frame):
    """Return one of the proposer's frames as a PoseStamped in the frame of `header`."""
    message = PoseStamped(header=header)
    p, q = message.pose.position, message.pose.orientation
    p.x, p.y, p.z = map(float, frame.position)
    q.x, q.y, q.z, q.w = map(float, frame.quaternion)
    return message


class Proposer(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("antipodal_grasps")
        self.create_service(ProposeGrasps, "/propose_grasps", self.answer)

    def answer(self, request, response):
        """Propose grasps for the cloud of a request."""
        points = points_of(request.input)
        header = request.input.header
        for candidate in propose(points):
            response.returned_object.append(
                GraspCandidate(
                    pose=stamped(header, candidate.pose),
                    pre_grasp=stamped(header, candidate.pre_grasp),
                    post_grasp=stamped(header, candidate.post_grasp),
                    width=float(candidate.width),
                    quality=float(candidate.quality),
                )
            )
        found = len(response.returned_object)
        response.outcome = NONE if found == 0 else ONE if found == 1 else SEVERAL
        self.get_logger().info(f"{len(points)} points, {found} grasps")
        return response


def main():
    """Serve until somebody stops us."""
    rclpy.init()
    node = Proposer()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
