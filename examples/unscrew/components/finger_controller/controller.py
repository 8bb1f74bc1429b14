"""A low-level controller of an Allegro hand, which turns a cap with index finger, middle finger and thumb.

Each call of `/finger_controller/control` is a cycle: measured joints come in, joint targets go out. Plain rclpy;
nothing here knows who calls.
"""

import numpy as np
import rclpy
from finger_interfaces.srv import Control
from gait import FINGERS, Gait
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

GOING, DONE, OUT_OF_REACH = 0, 1, 2  # the outcomes, as component.yaml names them
JOINTS = {f"joint_{finger.first + k}.0": (finger, k) for finger in FINGERS for k in range(4)}


class FingerController(Node):
    """The node; one cycle at a time."""

    def __init__(self):
        super().__init__("finger_controller")
        given = {"cap_radius": 0.02, "stroke": 48.0, "force": 8.0, "stiffness": 6.0}
        any_number = ParameterDescriptor(dynamic_typing=True)  # 48 is as good as 48.0
        declared = [self.declare_parameter(name, value, any_number).value for name, value in given.items()]
        radius, stroke, force, stiffness = map(float, declared)
        self.gait = Gait(radius, np.radians(stroke), force, stiffness)
        self.create_service(Control, "/finger_controller/control", self.cycle)

    def cycle(self, request, response):
        """Answer a request: go on with the command, or begin it."""
        names, measured = joints_of(request.input)
        if request.command != self.gait.doing:
            self.gait.begin(request.command, measured)
            self.get_logger().info(request.command)
        going = self.gait.advance(request.period)
        response.returned_object.name = [name for finger in FINGERS for name in names[finger]]
        response.returned_object.position = [float(q) for finger in FINGERS for q in self.gait.targets[finger]]
        response.turned = self.gait.turned(measured)
        response.outcome = GOING if going else DONE if self.gait.reached else OUT_OF_REACH
        if not going:
            self.gait.doing = ""
        return response


def joints_of(state):
    """Return the names and the measured positions of the joints of each finger, whatever the names begin with."""
    names, measured = {f: [""] * 4 for f in FINGERS}, {f: np.zeros(4) for f in FINGERS}
    for name, position in zip(state.name, state.position, strict=True):
        finger, k = JOINTS.get(name[name.rfind("joint_") :], (None, 0))
        if finger is not None:
            names[finger][k], measured[finger][k] = name, position
    return names, measured


def main():
    """Control until somebody stops us."""
    rclpy.init()
    node = FingerController()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
