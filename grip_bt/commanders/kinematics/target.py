"""What an inverse kinematics solver is asked for: a pose of the grasp frame, all of it or a part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.ports.motion import FREEDOMS, Free

from .model import Chain


@dataclass(frozen=True, slots=True)
class Target:
    """A wanted grasp frame.

    Attributes:
        pose: the grasp frame in world.
        free: what of it doesn't matter. With `z`, say, the frame's z axis and origin must be as in `pose`, and it
            may be turned about z as it likes: right for a round object seen from above.

    Raises:
        UnknownNameError: `free` is none of the allowed words.
    """

    pose: pin.SE3
    free: Free = "none"

    def __post_init__(self) -> None:
        if self.free not in FREEDOMS:
            raise UnknownNameError("freedom of a pose", self.free, FREEDOMS)

    def error(self, chain: Chain, q: Array) -> tuple[Array, Array]:
        """Return what is missing to the target, and how that changes with the joints.

        Returns:
            The error, shape (m,), in metres and radians, in the grasp frame, and its derivative by the
            configuration, shape (m, n); m is 6, 5 with a free axis, 3 with a free orientation.
        """
        model, data, frame = chain.model, chain.data, chain.frame
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacement(model, data, frame)
        missing = data.oMf[frame].actInv(self.pose)
        jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
        if self.free == "none":
            return pin.log6(missing).vector, -(pin.Jlog6(missing.inverse()) @ jacobian)
        return _partial(self.free, missing, jacobian)

    def distance(self, chain: Chain, q: Array) -> float:
        """Return the norm of the error at a configuration of shape (n,): metres and radians together."""
        return float(np.linalg.norm(self.error(chain, q)[0]))


def _partial(free: Free, missing: pin.SE3, jacobian: Array) -> tuple[Array, Array]:
    """Return the error in position and, unless the orientation is free, in the direction of the axis that is kept.

    Axis a of the grasp frame must point along b = R a (both in the grasp frame). The error is the turn from a to b:
    along a x b, which has no part about a, so that row is left out. Its derivative is that of small turns.
    """
    position = missing.translation
    linear = pin.skew(position) @ jacobian[3:] - jacobian[:3]
    if free == "orientation":
        return position, linear
    k = "xyz".index(free)
    turn = np.cross(np.eye(3)[k], missing.rotation[:, k])
    sine, cosine = float(np.linalg.norm(turn)), float(missing.rotation[k, k])
    if sine < 1e-9:
        # Parallel is done; opposite can be left by a turn about any axis across.
        turn, sine = np.eye(3)[(k + 1) % 3], 1.0
        angle = 0.0 if cosine > 0 else np.pi
    else:
        angle = float(np.arctan2(sine, cosine))
    rows = [i for i in range(3) if i != k]
    error = np.concatenate([position, turn[rows] * (angle / sine)])
    return error, np.vstack([linear, -jacobian[3:][rows]])
