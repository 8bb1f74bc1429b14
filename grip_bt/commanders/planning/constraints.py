"""A chain against what its grasp frame keeps to on the way: how far it is off, and how to get back."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.values import PathConstraint

from ..model import Chain

CONSTRAINT_SLACK = 0.02
"""Between its points a path is rounded into a spline; that may leave a constraint by this much [rad, m]."""
_DAMPING = 1e-6
_ROUNDS = 20
_MARGIN = 0.05
"""Projections aim this part inside the tolerances: a point on the very edge would be left by the next rounding."""


def excess(constraint: PathConstraint, chain: Chain, q: Array, shrunk: float = 0.0) -> tuple[Array, Array]:
    """Return what goes beyond the tolerances, and how that changes with the joints.

    Args:
        shrunk: part of the tolerances to take off.

    Returns:
        The excess, shape (m,) [rad, m], zero where a tolerance is kept, and its derivative, shape (m, n).
    """
    pin.computeJointJacobians(chain.model, chain.data, q)
    pin.updateFramePlacement(chain.model, chain.data, chain.frame)
    frame = chain.data.oMf[chain.frame]
    jacobian = pin.getFrameJacobian(chain.model, chain.data, chain.frame, pin.LOCAL)
    values, rows, allowed = [np.empty(0)], [np.empty((0, len(q)))], [np.empty(0)]
    if constraint.orientation is not None:
        wanted = constraint.orientation.rotation()
        about = wanted if constraint.axes == "world" else np.eye(3)
        relative = wanted.T @ frame.rotation
        values.append(about @ pin.log3(relative))
        rows.append(about @ pin.Jlog3(relative) @ jacobian[3:])
        allowed.append(np.array(constraint.tolerance))
    if constraint.box is not None:
        box = constraint.box.matrix()
        values.append(box[:3, :3].T @ (frame.translation - box[:3, 3]))
        rows.append(box[:3, :3].T @ frame.rotation @ jacobian[:3])
        allowed.append(np.array(constraint.size) / 2)
    value, limit = np.concatenate(values), np.concatenate(allowed) * (1 - shrunk)
    return np.sign(value) * np.maximum(np.abs(value) - limit, 0.0), np.concatenate(rows)


def kept(constraint: PathConstraint, chain: Chain, configurations: Array, slack: float = 1e-6) -> bool:
    """Tell whether all configurations, shape (k, n), keep to a constraint, up to `slack` [rad, m]."""
    return all(np.abs(excess(constraint, chain, q)[0]).max(initial=0.0) <= slack for q in configurations)


def projected(constraint: PathConstraint, chain: Chain, q: Array) -> Array | None:
    """Return a configuration near `q`, shape (n,), that keeps to a constraint, or None when none is found.

    Gauss-Newton steps on the excess, as in CBiRRT (Berenson et al. 2009).
    """
    for _ in range(_ROUNDS):
        beyond, jacobian = excess(constraint, chain, q, shrunk=_MARGIN)
        if np.abs(excess(constraint, chain, q)[0]).max(initial=0.0) == 0.0:
            return q
        active = beyond != 0
        rows = jacobian[active]
        step = -rows.T @ np.linalg.solve(rows @ rows.T + _DAMPING * np.eye(len(rows)), beyond[active])
        q = np.clip(q + step, chain.limits.lower, chain.limits.upper)
    return None
