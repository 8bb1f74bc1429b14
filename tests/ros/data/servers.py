"""Servers for the tests: `servers.py TYPE NAME [TYPE NAME ...]`; what they do is asked for in the request.

std_srvs/SetBool: true hangs. std_srvs/Trigger answers at once. A QoS of `best_effort` may follow a name, after a colon.
"""

import sys
import time
from importlib import import_module

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.utilities import remove_ros_args


def answer(request, response):
    """Answer, or hang when the request's `data` is true."""
    if getattr(request, "data", False):
        time.sleep(600)
    if hasattr(response, "success"):
        response.success = True
    return response


rclpy.init()
node = Node("test_server")
words = remove_ros_args(sys.argv)[1:]
for type_name, name in zip(words[::2], words[1::2], strict=True):
    package, cls = type_name.split("/")
    name, _, qos = name.partition(":")
    profile = QoSProfile(depth=10)
    if qos == "best_effort":
        profile.reliability = ReliabilityPolicy.BEST_EFFORT
    node.create_service(getattr(import_module(f"{package}.srv"), cls), name, answer, qos_profile=profile)
sys.stdout.write("serving\n")
sys.stdout.flush()
rclpy.spin(node)
