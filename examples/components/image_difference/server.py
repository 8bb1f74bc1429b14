"""Serve the image difference as a ROS 2 service. Plain rclpy; nothing here knows who calls."""

import numpy as np
import rclpy
from difference import compare, shown
from grasp_check_interfaces.srv import CompareFrames
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

FORMATS = {"rgb8": ("u1", 3), "bgr8": ("u1", 3), "32FC1": ("f4", 1)}


def pixels_of(message):
    """Return an Image as an array of shape (height, width) or (height, width, 3).

    Raises:
        ValueError: it has an encoding that isn't read here.
    """
    if message.encoding not in FORMATS:
        raise ValueError(f"encoding {message.encoding!r} isn't read here, {', '.join(FORMATS)} are")
    kind, channels = FORMATS[message.encoding]
    order = ">" if message.is_bigendian else "<"
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    used = message.width * channels * np.dtype(kind).itemsize
    values = np.ascontiguousarray(rows[:, :used]).view(order + kind)
    return values.reshape((message.height, message.width, 3) if channels == 3 else (message.height, message.width))


class Comparer(Node):
    """The node; one request at a time."""

    def __init__(self):
        super().__init__("image_difference")
        self.create_service(CompareFrames, "/compare_frames", self.answer)

    def answer(self, request, response):
        """Compare the frames of a request; frames without pixels show no difference, and nothing in the hand."""
        if request.before.image.data and request.after.image.data:
            parts = (request.before.image, request.before.depth, request.after.image, request.after.depth)
            found = compare(*map(pixels_of, parts))
            response.vacated, response.appeared = found.vacated, found.appeared
            hand = (request.hand_before.image, request.hand_after.image)
            if all(picture.data for picture in hand):
                response.shown = shown(found.colour, *map(pixels_of, hand))
        counts = f"{response.vacated} vacated, {response.appeared} appeared, {response.shown} in the hand"
        self.get_logger().info(f"pixels: {counts}")
        return response


def main():
    """Serve until somebody stops us."""
    rclpy.init()
    node = Comparer()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
