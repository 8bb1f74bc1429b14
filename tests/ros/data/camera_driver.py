"""A camera's driver: `camera_driver.py [colour|depth|info ...]` publishes these, 20 times a second, stamped alike."""

import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image

rclpy.init()
node = Node("camera_driver")
parts = sys.argv[1:] or ["colour", "depth", "info"]
kinds = {"colour": Image, "depth": Image, "info": CameraInfo}
publishers = {p: node.create_publisher(kinds[p], f"/cam/{p}", qos_profile_sensor_data) for p in parts}


def publish():
    stamp = node.get_clock().now().to_msg()
    for part, publisher in publishers.items():
        message = kinds[part](height=2, width=3)
        message.header.stamp, message.header.frame_id = stamp, "cam_optical"
        if part == "colour":
            message.encoding, message.step, message.data = "rgb8", 9, bytes(18)
        elif part == "depth":
            message.encoding, message.step = "16UC1", 6
            message.data = (500).to_bytes(2, "little") * 6
        else:
            message.k = [2.0, 0.0, 1.0, 0.0, 2.0, 0.5, 0.0, 0.0, 1.0]
        publisher.publish(message)


sys.stdout.write("serving\n")
sys.stdout.flush()
while rclpy.ok():
    publish()
    rclpy.spin_once(node, timeout_sec=0.0)
    time.sleep(0.05)
