"""Plans of trajectories that somebody else made, such as a project's stored ones: checked, and followed as they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grip_bt.errors import OutOfLimitsError, PathInvalidError
from grip_bt.values import Trajectory

from ..collision import recent_checker
from ..model import Chain, RobotModel
from .continuous import first_touch
from .goals import out_of_limits, touching
from .requests import PlanAlong

FASTER = 1e-3
"""A joint may be asked to go faster than its limit by this part: times in files are rounded."""


def plan_along(model: RobotModel, request: PlanAlong) -> Trajectory:
    """Return the trajectory for all joints of the group; those that it doesn't name stay where they are.

    Raises:
        OutOfLimitsError: a way-point breaks position limits, or a joint would have to move faster than it can;
            `data['joints']` names the joints.
        PathInvalidError: something would be touched; `data` says after what `time` [s], and which `pairs`.
    """
    given, situation = request.trajectory, request.situation
    chain = model.chain(situation.group, situation.start)
    positions = np.tile(situation.start.ordered(chain.joints), (len(given.times), 1))
    columns = [chain.joints.index(name) for name in given.names]
    positions[:, columns] = given.positions
    _refuse_limits(chain, given, positions)
    whole = Trajectory(
        chain.joints,
        given.times,
        positions,
        _of_all(given.velocities, columns, positions),
        _of_all(given.accelerations, columns, positions),
    )
    checker = recent_checker(chain, situation.scene, situation.hand, 0.0)
    if met := checker.pairs(positions[0]):
        raise PathInvalidError(f"where the trajectory begins, {touching(met)}", pairs=met, time=0.0)
    if touched := first_touch(checker, whole):
        at, pairs = touched
        raise PathInvalidError(f"after {at:.1f} s of the trajectory, {touching(pairs)}", pairs=pairs, time=at)
    return whole


def _of_all(
    given: NDArray[np.float64] | None, columns: list[int], like: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Return derivatives for all joints, shape (k, n): zero for those that stay."""
    if given is None:
        return None
    whole = np.zeros_like(like)
    whole[:, columns] = given
    return whole


def _refuse_limits(chain: Chain, given: Trajectory, positions: NDArray[np.float64]) -> None:
    for time, row in zip(given.times, positions, strict=True):
        if not chain.within_limits(row):
            raise out_of_limits(chain, row, f"{time:.1f} s after its beginning, the trajectory is")
    if len(given.times) < 2:
        return
    fastest = np.abs(np.diff(positions, axis=0) / np.diff(given.times)[:, None]).max(axis=0)
    over = fastest / chain.limits.velocity
    if over.max() > 1.0 + FASTER:
        joints = tuple(name for name, part in zip(chain.joints, over, strict=True) if part > 1.0 + FASTER)
        worst = int(over.argmax())
        raise OutOfLimitsError(
            f"the trajectory moves {chain.joints[worst]} at {fastest[worst]:.2f} rad/s, and it can do "
            f"{chain.limits.velocity[worst]:.2f}; give its way-points {over.max():.1f} times as long",
            joints=joints,
        )
