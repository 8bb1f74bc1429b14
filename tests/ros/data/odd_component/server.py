"""A component that breaks its contract in the way that the frame of the cloud asks for."""

import os
import sys
import time

import rclpy
from antipodal_interfaces.msg import GraspCandidate
from antipodal_interfaces.srv import ProposeGrasps
from rclpy.node import Node


def answer(request, response):
    """Misbehave."""
    wish = request.input.header.frame_id
    if wish == "die":
        sys.stderr.write("that was too much\n")
        os._exit(7)
    if wish == "hang":
        time.sleep(60)
    if wish.startswith("outcome"):
        response.outcome = int(wish.removeprefix("outcome"))
    if wish in ("two_frames", "outcome2"):
        response.returned_object = [GraspCandidate()]
        response.returned_object[0].pose.header.frame_id = "left"
        response.returned_object[0].pre_grasp.header.frame_id = "right"
    return response


rclpy.init()
node = Node("odd")
node.create_service(ProposeGrasps, "/odd", answer)
rclpy.spin(node)
