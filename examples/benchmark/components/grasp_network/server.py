"""Serve the network as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import numpy as np
import rclpy
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from grasp_network_interfaces.msg import PredictedGrasp
from grasp_network_interfaces.srv import Predict
from network import load, predict
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

FORMATS = {"32FC1": ("<f4", 1.0), "16UC1": ("<u2", 0.001)}


def depth_of(image):
    """Return a depth image as an array of shape (height, width) [m]."""
    if image.encoding not in FORMATS:
        raise ValueError(f"encoding {image.encoding!r} isn't read here, {', '.join(FORMATS)} are")
    kind, unit = FORMATS[image.encoding]
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
    used = image.width * np.dtype(kind).itemsize
    return np.ascontiguousarray(rows[:, :used]).view(kind).astype(np.float32) * np.float32(unit)


def pose_of(peak, k):
    """Return a peak as a pose in the optical frame, z forward, x along the closing line; k: the intrinsic matrix."""
    row, column = peak.middle
    x, y = (column - k[2]) / k[0] * peak.depth, (row - k[5]) / k[4] * peak.depth
    half = peak.angle / 2
    turned = Quaternion(x=0.0, y=0.0, z=float(np.sin(half)), w=float(np.cos(half)))
    return Pose(position=Point(x=float(x), y=float(y), z=peak.depth), orientation=turned)


class Predictor(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("grasp_network")
        self._weights = load()
        self.create_service(Predict, "/predict_grasps", self.answer)

    def answer(self, request, response):
        """Predict grasps in the image of a request; one without pixels has none."""
        peaks = predict(self._weights, depth_of(request.depth), request.peaks) if request.depth.data else []
        for peak in peaks:
            grasp = PoseStamped(header=request.depth.header, pose=pose_of(peak, request.camera_info.k))
            response.predictions.append(PredictedGrasp(grasp=grasp, width=peak.width, quality=peak.quality))
        response.success = bool(peaks)
        self.get_logger().info(f"{len(peaks)} grasps")
        return response


def main():
    """Serve until somebody stops us."""
    rclpy.init()
    node = Predictor()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
