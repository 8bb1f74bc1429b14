"""A low-level controller of an Allegro hand, which turns a cap with index finger, middle finger and thumb.

Each call of `/finger_controller/control` is a cycle: measured joints come in, joint targets go out. The fingertips stand
on a circle around the cap; they aim inside its rim where they press, so that the stiffness of their joints does. Plain
rclpy; nothing here knows who calls.
"""

import numpy as np
import rclpy
from finger_interfaces.srv import Control
from kinematics import INDEX, MIDDLE, THUMB
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

GOING, DONE, OUT_OF_REACH = 0, 1, 2  # the outcomes, as component.yaml names them
FINGERS = {INDEX: np.radians(-40), MIDDLE: np.radians(40), THUMB: np.pi}  # where they are on the circle
CENTRE = np.array([0.1151, 0.025, 0.0])  # where the cap is, in the palm's frame [m]
TIP = 0.012  # radius of a fingertip [m]
CLEAR = 0.01  # how far from the rim open fingertips stay [m]
MORE = 0.006  # how much closer than the thumb, which reaches no further, two fingertips aim where they press [m]
FASTEST = 2.0  # of a joint's target [rad/s]


class FingerController(Node):
    """The node; one cycle at a time."""

    def __init__(self):
        super().__init__("finger_controller")
        given = {"cap_radius": 0.02, "stroke": 48.0, "squeeze": 0.012}
        any_number = ParameterDescriptor(dynamic_typing=True)  # 48 is as good as 48.0
        radius, stroke, squeeze = (self.declare_parameter(n, value, any_number).value for n, value in given.items())
        self.wide, self.pressed, self.half = radius + TIP + CLEAR, radius + TIP - squeeze, np.radians(stroke) / 2
        self.at = self.half, self.wide  # angle and radius that are aimed at
        self.doing, self.parts, self.time, self.targets, self.began = "", [], 0.0, {}, None
        self.create_service(Control, "/finger_controller/control", self.cycle)

    def cycle(self, request, response):
        """Answer a request: go on with the command, or begin it."""
        names, measured = self.joints(request.input)
        if request.command != self.doing:
            self.begin(request.command, measured)
        self.time += request.period
        going = self.advance(request.period)
        response.returned_object.name = [name for finger in FINGERS for name in names[finger]]
        response.returned_object.position = [float(q) for finger in FINGERS for q in self.targets[finger]]
        if self.began is not None:
            response.turned = self.angle(measured) - self.began
        elif self.at[1] == self.pressed:
            self.began = self.angle(measured)
        response.outcome = GOING if going else DONE if self.reached() else OUT_OF_REACH
        if not going:
            self.doing = ""
        return response

    def joints(self, state):
        """Return the names and the measured positions of the joints of each finger, whatever the names begin with."""
        numbers = {f"joint_{f.first + k}.0": (f, k) for f in FINGERS for k in range(4)}
        names, measured = {f: [""] * 4 for f in FINGERS}, {f: np.zeros(4) for f in FINGERS}
        for name, position in zip(state.name, state.position, strict=True):
            finger, k = numbers.get(name[name.rfind("joint_") :], (None, 0))
            if finger is not None:
                names[finger][k], measured[finger][k] = name, position
        return names, measured

    def begin(self, command, measured):
        """Plan a command: parts with a duration [s], and the angle and radius at their ends."""
        angle, _ = self.at
        parts = {
            "release": [(0.3, angle, self.wide), (0.5, self.half, self.wide)],
            "turn": [(0.4, angle, self.pressed), (0.9, -self.half, self.pressed), (0.2, -self.half, self.pressed)],
        }
        self.doing, self.parts, self.time, self.began = command, parts[command], 0.0, None
        self.targets = self.targets or measured
        self.get_logger().info(f"{command}, from {np.degrees(angle):.0f} degrees")

    def advance(self, period):
        """Move the targets on; return whether the command goes on."""
        duration, *goal = self.parts[0]
        share = min(1.0, period / max(duration, period))
        self.at = tuple(now + (then - now) * share for now, then in zip(self.at, goal, strict=True))
        self.parts[0] = (duration - period, *goal)
        most = FASTEST * period
        for finger, aimed in self.aims().items():
            there = finger.towards(aimed)
            self.targets[finger] = self.targets[finger] + np.clip(there - self.targets[finger], -most, most)
        if duration <= period + 1e-9 and self.off() < 1e-3 or duration < -1.0:
            self.parts.pop(0)
        return bool(self.parts)

    def aims(self):
        """Return where the tips are to be."""
        angle, radius = self.at
        inside = MORE * (self.wide - radius) / (self.wide - self.pressed)
        aims = {}
        for finger, place in FINGERS.items():
            away = radius - (0.0 if finger is THUMB else inside)
            aims[finger] = CENTRE + away * np.array([0.0, -np.sin(place + angle), np.cos(place + angle)])
        return aims

    def off(self):
        """Return how far the targets are from where the tips are to be [m]."""
        return max(np.linalg.norm(finger.tip(self.targets[finger])[0] - aim) for finger, aim in self.aims().items())

    def reached(self):
        """Tell whether the targets are where the tips are to be."""
        return self.off() < 2e-3

    def angle(self, measured):
        """Return how far the tips are around the circle, on the average [rad], counter-clockwise from above."""
        turns = []
        for finger, place in FINGERS.items():
            _, y, z = finger.tip(measured[finger])[0] - CENTRE
            turns.append(np.angle(np.exp(1j * (place - np.arctan2(-y, z)))))
        return float(np.mean(turns))


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
