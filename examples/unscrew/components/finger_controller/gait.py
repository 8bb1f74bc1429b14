"""How three fingertips of an Allegro hand go around a cap: where its joints are to be, cycle after cycle. numpy only.

The fingertips stand on a circle around the cap. Where they press, a joint's target is off from where the tip touches
by what its servo, a spring, turns into its part of the force, J^T f: so they press inwards alone, and neither down nor
aside, however stiff a finger is in one direction or another.
"""

import numpy as np
from kinematics import INDEX, MIDDLE, THUMB

FINGERS = {INDEX: np.radians(-40), MIDDLE: np.radians(40), THUMB: np.pi}  # where they are on the circle
SHARES = {INDEX: 0.5 / np.cos(np.radians(40)), MIDDLE: 0.5 / np.cos(np.radians(40)), THUMB: 1.0}  # of the thumb's force
CENTRE = np.array([0.095, 0.015, 0.01])  # where the cap is, in the palm's frame [m]
TIP = 0.012  # radius of a fingertip [m]
CLEAR = 0.01  # how far from the rim open fingertips stay [m]
REACHED = 0.002  # a tip that can't come closer than this is out of reach [m]
FASTEST = 2.0  # of a joint's target [rad/s]


def outwards(angle):
    """Return a direction from the cap's middle, by the angle from the fingers' side, clockwise from above."""
    return np.array([0.0, -np.sin(angle), np.cos(angle)])


class Gait:
    """Where the fingers are to be, and what they are doing.

    Args:
        cap_radius: [m].
        stroke: how far one turn of the hand goes [rad].
        force: of the thumb on the rim; two fingers share as much [N].
        stiffness: of the joints' servos [N m/rad].
    """

    def __init__(self, cap_radius, stroke, force, stiffness):
        self.rim, self.half, self.force, self.stiffness = cap_radius + TIP, stroke / 2, force, stiffness
        self.at = self.half, self.rim + CLEAR, 0.0  # angle and radius of the tips, and the thumb's force
        self.doing, self.parts, self.targets, self.began, self.off = "", [], {}, None, 0.0

    @property
    def reached(self):
        """Whether the tips can be where they are to be."""
        return self.off < REACHED

    def begin(self, command, measured):
        """Plan a command: parts with a duration [s], and the angle, radius and force at their ends."""
        angle, wide, grip = self.at[0], self.rim + CLEAR, (self.rim, self.force)
        parts = {
            "release": [(0.3, angle, wide, 0.0), (0.5, self.half, wide, 0.0)],
            "turn": [(0.3, angle, self.rim, 0.0), (0.2, angle, *grip), *[(t, -self.half, *grip) for t in (0.9, 0.2)]],
        }
        self.doing, self.parts, self.began = command, parts[command], None
        self.targets = self.targets or dict(measured)

    def advance(self, period):
        """Move the targets on by a period [s]; return whether the command goes on."""
        duration, *goal = self.parts[0]
        share = min(1.0, period / max(duration, period))
        self.at = tuple(now + (then - now) * share for now, then in zip(self.at, goal, strict=True))
        self.parts[0] = (duration - period, *goal)
        aims, most, behind = self.aims(), FASTEST * period, 0.0
        for finger, aim in aims.items():
            self.targets[finger] = self.targets[finger] + np.clip(aim - self.targets[finger], -most, most)
            behind = max(behind, np.abs(aim - self.targets[finger]).max())
        if duration <= period + 1e-9 and behind < 1e-3:
            self.parts.pop(0)
        return bool(self.parts)

    def aims(self):
        """Return where each finger's joints are to be."""
        angle, radius, force = self.at
        aims, self.off = {}, 0.0
        for finger, place in FINGERS.items():
            away = outwards(place + angle)
            goal = CENTRE + radius * away
            joints = finger.towards(goal)
            tip, jacobian = finger.tip(joints)
            self.off = max(self.off, np.linalg.norm(tip - goal))
            aims[finger] = joints - jacobian.T @ (SHARES[finger] * force * away) / self.stiffness
        return aims

    def turned(self, measured):
        """Return how far the tips went around since they gripped [rad], counter-clockwise from above; 0 before."""
        if self.began is None and self.at[2] < self.force:
            return 0.0
        turns = []
        for finger, place in FINGERS.items():
            _, y, z = finger.tip(measured[finger])[0] - CENTRE
            turns.append(np.angle(np.exp(1j * (place - np.arctan2(-y, z)))))
        now = float(np.mean(turns))
        self.began = now if self.began is None else self.began
        return now - self.began
