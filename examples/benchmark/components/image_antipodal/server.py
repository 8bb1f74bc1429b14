"""Serve the rectangles as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rectangle_interfaces.msg import GraspRectangle
from rectangle_interfaces.srv import FindRectangles
from rectangles import find

FORMATS = {"32FC1": ("<f4", 1.0), "16UC1": ("<u2", 0.001)}


def depth_of(image):
    """Return a depth image as an array of shape (height, width) [m]."""
    if image.encoding not in FORMATS:
        raise ValueError(f"encoding {image.encoding!r} isn't read here, {', '.join(FORMATS)} are")
    kind, unit = FORMATS[image.encoding]
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
    used = image.width * np.dtype(kind).itemsize
    return np.ascontiguousarray(rows[:, :used]).view(kind).astype(np.float32) * np.float32(unit)


class Finder(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("image_antipodal")
        self.create_service(FindRectangles, "/find_rectangles", self.answer)

    def answer(self, request, response):
        """Find rectangles in the image of a request; one without pixels has none."""
        for found in find(depth_of(request.depth_image)) if request.depth_image.data else []:
            row, column = found.middle
            response.rectangles.append(
                GraspRectangle(
                    row=row,
                    column=column,
                    angle=float(np.degrees(found.angle)),
                    width=found.width,
                    depth=found.depth,
                    quality=found.quality,
                )
            )
        self.get_logger().info(f"{len(response.rectangles)} rectangles")
        return response


def main():
    """Serve until somebody stops us."""
    rclpy.init()
    node = Finder()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
