"""A low-level controller of an Allegro hand, which turns a cap with index finger, middle finger and thumb.

Each call of `/finger_controller/control` is a cycle: measured joints come in, joint targets go out. The fingertips stand
on a circle around the cap. Where they press, a joint's target is off from where the tip touches by what its servo, a
spring, turns into its part of the force, J^T f: so they press inwards alone, and neither down nor aside, however stiff
a finger is in one direction or another. Plain rclpy; nothing here knows who calls.
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
CENTRE = np.array([0.095, 0.015, 0.01])  # where the cap is, in the palm's frame [m]
TIP = 0.012  # radius of a fingertip [m]
CLEAR = 0.01  # how far from the rim open fingertips stay [m]
SHARES = {INDEX: 0.5 / np.cos(np.radians(40)), MIDDLE: 0.5 / np.cos(np.radians(40)), THUMB: 1.0}  # of the thumb's force
REACHED = 0.002  # a tip that can't come closer than this is out of reach [m]
FASTEST = 2.0  # of a joint's target [rad/s]


class FingerController(Node):
    """The node; one cycle at a time."""

    def __init__(self):
        super().__init__("finger_controller")
        given = {"cap_radius": 0.02, "stroke": 48.0, "force": 8.0, "stiffness": 6.0}
        any_number = ParameterDescriptor(dynamic_typing=True)  # 48 is as good as 48.0
        radius, stroke, force, stiff = (
            self.declare_parameter(n, value, any_number).value for n, value in given.items()
        )
        self.rim, self.half, self.force, self.stiffness = radius + TIP, np.radians(stroke) / 2, force, stiff
        self.at = self.half, self.rim + CLEAR, 0.0  # angle and radius of the tips, and the thumb's force
        self.doing, self.parts, self.targets, self.began = "", [], {}, None
        self.create_service(Control, "/finger_controller/control", self.cycle)

    def cycle(self, request, response):
        """Answer a request: go on with the command, or begin it."""
        names, measured = self.joints(request.input)
        if request.command != self.doing:
            self.begin(request.command, measured)
        going = self.advance(request.period)
        response.returned_object.name = [name for finger in FINGERS for name in names[finger]]
        response.returned_object.position = [float(q) for finger in FINGERS for q in self.targets[finger]]
        if self.began is not None:
            response.turned = self.angle(measured) - self.began
        elif self.at[2] == self.force:
            self.began = self.angle(measured)
        response.outcome = GOING if going else DONE if self.off < REACHED else OUT_OF_REACH
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
        """Plan a command: parts with a duration [s], and the angle, radius and force at their ends."""
        angle, wide, grip = self.at[0], self.rim + CLEAR, (self.rim, self.force)
        parts = {
            "release": [(0.3, angle, wide, 0.0), (0.5, self.half, wide, 0.0)],
            "turn": [
                (0.3, angle, self.rim, 0.0),
                (0.2, angle, *grip),
                (0.9, -self.half, *grip),
                (0.2, -self.half, *grip),
            ],
        }
        self.doing, self.parts, self.began = command, parts[command], None
        self.targets = self.targets or measured
        self.get_logger().info(f"{command}, from {np.degrees(angle):.0f} degrees")

    def advance(self, period):
        """Move the targets on; return whether the command goes on."""
        duration, *goal = self.parts[0]
        share = min(1.0, period / max(duration, period))
        self.at = tuple(now + (then - now) * share for now, then in zip(self.at, goal, strict=True))
        self.parts[0] = (duration - period, *goal)
        most = FASTEST * period
        aims = self.aims()
        for finger, aim in aims.items():
            self.targets[finger] = self.targets[finger] + np.clip(aim - self.targets[finger], -most, most)
        behind = max(np.abs(aim - self.targets[finger]).max() for finger, aim in aims.items())
        if duration <= period + 1e-9 and behind < 1e-3:
            self.parts.pop(0)
        return bool(self.parts)

    def aims(self):
        """Return where each finger's joints are to be."""
        angle, radius, force = self.at
        aims, self.off = {}, 0.0
        for finger, place in FINGERS.items():
            outwards = np.array([0.0, -np.sin(place + angle), np.cos(place + angle)])
            goal = CENTRE + radius * outwards
            joints = finger.towards(goal)
            tip, jacobian = finger.tip(joints)
            self.off = max(self.off, np.linalg.norm(tip - goal))
            aims[finger] = joints - jacobian.T @ (SHARES[finger] * force * outwards) / self.stiffness
        return aims

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
