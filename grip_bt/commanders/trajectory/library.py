"""The library `toppra` behind the same question as ours: for who wants a second opinion on a motion's timing."""

from __future__ import annotations

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint
from scipy.interpolate import BSpline

from grip_bt.base.arrays import Array
from grip_bt.base.failures import PathInvalidError


def squared_velocities(grid: Array, knots: Array, path: BSpline, velocity: Array, acceleration: Array) -> Array:
    """Return the largest squared path velocities from rest to rest [1/s^2], shape (m + 1,), as `toppra` finds them.

    Raises:
        PathInvalidError: the library finds no timing.
    """
    toppra.setup_logging("ERROR")
    limits = [
        toppra.constraint.JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    ends = ((1, path(knots[0], 1)), (1, path(knots[-1], 1)))  # with these it is the same curve
    curve = toppra.SplineInterpolator(knots, path(knots), bc_type=ends)
    method = toppra.algorithm.TOPPRA(limits, curve, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    if method.compute_trajectory(0, 0) is None:
        raise PathInvalidError("toppra finds no timing for the path", knots=len(knots))
    return np.asarray(method.problem_data.sd_vec, dtype=np.float64) ** 2
