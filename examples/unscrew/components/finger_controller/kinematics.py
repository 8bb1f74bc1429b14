"""Where three fingertips of a right Allegro hand are, and which joints bring them elsewhere. numpy only.

In the palm's frame x leaves the palm and z runs along the fingers [m, rad]; numbers are those of the maker's URDF.
"""

import numpy as np

X, Y, Z = np.eye(3)


def about(axis, angle):
    """Return the matrix of a turn (Rodrigues)."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


class Finger:
    """A chain of four joints.

    Args:
        first: number of the first joint.
        base: where that is, and how it is turned: roll, pitch, yaw.
        axes: of the joints, shape (4, 3).
        ways: from each joint to the next, the last to the tip, shape (4, 3).
        lower, upper: limits, shape (4,).
        rest: joints in the middle of the work, shape (4,).
    """

    def __init__(self, first, base, turn, axes, ways, lower, upper, rest):
        self.first, self.base, self.axes, self.ways = first, np.array(base), axes, np.array(ways)
        self.turn = about(Z, turn[2]) @ about(Y, turn[1]) @ about(X, turn[0])
        self.lower, self.upper, self.rest = np.array(lower), np.array(upper), np.array(rest)

    def tip(self, q):
        """Return where the tip is, shape (3,), and how that changes with the joints, shape (3, 4)."""
        place, turn, joints = self.base, self.turn, []
        for axis, way, angle in zip(self.axes, self.ways, q, strict=True):
            joints.append((place, turn @ axis))
            turn = turn @ about(axis, angle)
            place = place + turn @ way
        return place, np.column_stack([np.cross(axis, place - origin) for origin, axis in joints])

    def towards(self, goal, steps=30, damping=1e-5):
        """Return joints that bring the tip to a goal, as far as they can (damped least squares).

        The search begins at rest, so that one goal has one answer, and near goals have near ones.
        """
        q = self.rest
        for _ in range(steps):
            place, jacobian = self.tip(q)
            error = goal - place
            if np.abs(error).max() < 1e-5:
                break
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + damping * np.eye(3), error)
            q = np.clip(q + np.clip(step, -0.4, 0.4), self.lower, self.upper)
        return q


_WAYS = [(0, 0, 0.0164), (0, 0, 0.054), (0, 0, 0.0384), (0, 0, 0.0267)]
_LIMITS = (-0.47, -0.196, -0.174, -0.227), (0.47, 1.61, 1.709, 1.618)
_REST = (0.0, 1.2, 0.5, 0.2)
INDEX = Finger(0, (0, 0.0435, -0.001542), (-0.08726646, 0, 0), (Z, Y, Y, Y), _WAYS, *_LIMITS, _REST)
MIDDLE = Finger(4, (0, 0, 0.0007), (0, 0, 0), (Z, Y, Y, Y), _WAYS, *_LIMITS, _REST)
THUMB = Finger(
    12,
    (-0.0182, 0.019333, -0.045987),
    (0, -1.65806279, -1.57079633),
    (-X, Z, Y, Y),
    [(-0.027, 0.005, 0.0399), (0, 0, 0.0177), (0, 0, 0.0514), (0, 0, 0.0423)],
    (0.263, -0.105, -0.189, -0.162),
    (1.396, 1.163, 1.644, 1.719),
    (1.1, 0.5, 0.7, 0.2),
)
