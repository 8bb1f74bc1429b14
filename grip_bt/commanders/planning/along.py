"""Plans of trajectories that somebody else made, such as a project's stored ones: checked, and followed as they are."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from grip_bt.base.arrays import Array
from grip_bt.base.failures import PathInvalidError
from grip_bt.base.values import Trajectory

from ..collision import recent_checker
from ..model import RobotModel
from ..trajectory.limits import longer, refuse_beyond_limits
from .beginning import allowed
from .continuous import first_touch
from .goals import out_of_limits, touching
from .requests import PlanAlong


def plan_along(model: RobotModel, request: PlanAlong) -> Trajectory:
    """Return the trajectory for all joints of the group; those that it doesn't name stay where they are.

    Raises:
        OutOfLimitsError: a joint would leave its limits of position, velocity or acceleration, at a point or between
            two; `data['joints']` names it.
        PathInvalidError: something would be touched; `data` says after what `time` [s], and which `pairs`.
    """
    given, situation = request.trajectory, request.situation
    chain = model.chain(situation.group, situation.start)
    positions = np.tile(situation.start.ordered(chain.joints), (len(given.times), 1))
    columns = [chain.joints.index(name) for name in given.names]
    positions[:, columns] = given.positions
    for time, row in zip(given.times, positions, strict=True):
        if not chain.within_limits(row):
            raise out_of_limits(chain, row, f"{time:.2f} s after its beginning, the trajectory is")
    checker = recent_checker(chain, situation.scene, situation.hand, 0.0)
    if met := checker.pairs(positions[0]):
        raise PathInvalidError(f"where the trajectory begins, {touching(met)}", pairs=met, time=0.0)
    known = given.velocities is not None
    whole = Trajectory(
        chain.joints,
        given.times,
        positions,
        _of_all(given.velocities if known else _smooth(given), columns, positions),
        _of_all(given.accelerations if known else None, columns, positions),
    )
    if request.slow_down:
        velocity, acceleration, _ = allowed(chain, situation.settings)
        whole = whole.stretched(whole.duration * longer(whole, velocity, acceleration))
    refuse_beyond_limits(whole, chain.limits)
    if touched := first_touch(checker, whole):
        at, pairs = touched
        raise PathInvalidError(f"after {at:.1f} s of the trajectory, {touching(pairs)}", pairs=pairs, time=at)
    return whole


def _of_all(given: Array | None, columns: list[int], like: Array) -> Array | None:
    """Return derivatives for all joints, shape (k, n): zero for those that stay."""
    if given is None:
        return None
    whole = np.zeros_like(like)
    whole[:, columns] = given
    return whole


def _smooth(given: Trajectory) -> Array:
    """Return velocities at way points that have positions alone, shape (k, n), at rest at both ends.

    They are those of the monotone cubic through the points (Fritsch and Butland 1984): no joint leaves what is between
    two points.
    """
    if len(given.times) < 2:
        return np.zeros_like(given.positions)
    velocities: Array = PchipInterpolator(given.times, given.positions).derivative()(given.times)
    velocities[[0, -1]] = 0.0
    return velocities
