"""What the grasp frame keeps to on its whole way: an orientation within tolerances, an origin within a box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from grip_bt.values import Pose
from grip_bt.values.pose import check_frame

from ..model import Chain

_DAMPING = 1e-6
_ROUNDS = 20
_MARGIN = 0.05
"""Projections aim this part inside the tolerances: a point on the very edge would be left by the next rounding."""


@dataclass(frozen=True)
class PathConstraint:
    """Where the grasp frame may be on the way.

    Attributes:
        orientation: the frame, in world, whose orientation is kept; its position doesn't matter. None: any orientation.
        tolerance: largest turns about x, y and z of that frame [rad]; `inf` leaves an axis free. A full cup, whose z
            axis points up, has `(0.1, 0.1, inf)`.
        box: centre and attitude of a box in world that the origin stays in, or None.
        size: the box's edge lengths [m].

    Raises:
        ValueError: a tolerance or a length isn't positive, or a pose isn't in world.
    """

    orientation: Pose | None = None
    tolerance: tuple[float, float, float] = (0.1, 0.1, np.inf)
    box: Pose | None = None
    size: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        if not all(value > 0 for value in (*self.tolerance, *self.size)):
            raise ValueError(f"tolerances {self.tolerance} rad and lengths {self.size} m are positive")
        for pose in (self.orientation, self.box):
            if pose is not None:
                check_frame(pose, "world")

    def excess(
        self, chain: Chain, q: NDArray[np.float64], shrunk: float = 0.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return what goes beyond the tolerances, and how that changes with the joints.

        Args:
            chain: what moves.
            q: configuration, shape (n,).
            shrunk: part of the tolerances to take off.

        Returns:
            The excess, shape (m,) [rad, m], zero where a tolerance is kept, and its derivative, shape (m, n).
        """
        pin.computeJointJacobians(chain.model, chain.data, q)
        pin.updateFramePlacement(chain.model, chain.data, chain.frame)
        frame = chain.data.oMf[chain.frame]
        jacobian = pin.getFrameJacobian(chain.model, chain.data, chain.frame, pin.LOCAL)
        values, rows, allowed = [np.empty(0)], [np.empty((0, len(q)))], [np.empty(0)]
        if self.orientation is not None:
            relative = self.orientation.matrix()[:3, :3].T @ frame.rotation
            values.append(pin.log3(relative))
            rows.append(pin.Jlog3(relative) @ jacobian[3:])
            allowed.append(np.array(self.tolerance))
        if self.box is not None:
            box = self.box.matrix()
            values.append(box[:3, :3].T @ (frame.translation - box[:3, 3]))
            rows.append(box[:3, :3].T @ frame.rotation @ jacobian[:3])
            allowed.append(np.array(self.size) / 2)
        value, limit = np.concatenate(values), np.concatenate(allowed) * (1 - shrunk)
        return np.sign(value) * np.maximum(np.abs(value) - limit, 0.0), np.concatenate(rows)

    def kept(self, chain: Chain, configurations: NDArray[np.float64], slack: float = 1e-6) -> bool:
        """Tell whether all configurations, shape (k, n), keep to it, up to `slack` [rad, m]."""
        return all(np.abs(self.excess(chain, q)[0]).max(initial=0.0) <= slack for q in configurations)

    def projected(self, chain: Chain, q: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return a configuration near `q`, shape (n,), that keeps to it, or None when none is found.

        Gauss-Newton steps on the excess, as in CBiRRT (Berenson et al. 2009).
        """
        for _ in range(_ROUNDS):
            excess, jacobian = self.excess(chain, q, shrunk=_MARGIN)
            if np.abs(self.excess(chain, q)[0]).max(initial=0.0) == 0.0:
                return q
            active = excess != 0
            rows = jacobian[active]
            step = -rows.T @ np.linalg.solve(rows @ rows.T + _DAMPING * np.eye(len(rows)), excess[active])
            q = np.clip(q + step, chain.limits.lower, chain.limits.upper)
        return None
