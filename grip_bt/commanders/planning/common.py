"""Whether plans of several arms, executed at once, keep the arms apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grip_bt.errors import PathInvalidError
from grip_bt.values import Plan

from ..collision import CollisionChecker
from ..model import RobotModel
from .continuous import FINE, continuously_free
from .goals import touching
from .paths import interpolated
from .requests import CheckTogether

STEP = 0.02
"""The motions are looked at in steps of so long at most [s]; between two, joints move evenly."""


def check_together(model: RobotModel, request: CheckTogether) -> None:
    """Check the common motion all along.

    Raises:
        PathInvalidError: something would be touched; `data` says after what `time` [s], and which `pairs`.
        ValueError: two plans move the same joint.
    """
    plans, situation = request.plans, request.situation
    named = [name for plan in plans for name in plan.trajectory.names]
    if len(set(named)) != len(named):
        raise ValueError(f"two plans move the same joint: {sorted(n for n in named if named.count(n) > 1)}")
    chain = model.joined_chain([plan.group for plan in plans], situation.start)
    checker = CollisionChecker(chain, situation.scene)
    times = common_times(plans)
    positions = np.empty((len(times), len(chain.joints)))
    for plan in plans:
        for name, column in zip(plan.trajectory.names, plan.trajectory.positions.T, strict=True):
            positions[:, chain.joints.index(name)] = np.interp(times, plan.trajectory.times, column)
    if touched := first_touch(checker, times, positions):
        at, pairs = touched
        raise PathInvalidError(
            f"after {at:.1f} s of the common motion, {touching(pairs)}; plan for a group of both"
            " arms, or move one after the other",
            pairs=pairs,
            time=at,
        )


def first_touch(
    checker: CollisionChecker, times: NDArray[np.float64], positions: NDArray[np.float64]
) -> tuple[float, tuple[tuple[str, str], ...]] | None:
    """Return when [s] and between what a timed motion first touches; None when it is free all along.

    Args:
        checker: of the joints that move.
        times: shape (k,) [s].
        positions: at these times, shape (k, n); between two, joints move evenly.
    """
    if continuously_free(checker, positions):
        return None
    for k in range(len(times) - 1):
        fine = interpolated(positions[k : k + 2], FINE[0])
        free = checker.free_each(fine)
        if not free.all():
            return float(times[k]), checker.pairs(fine[int(np.argmin(free))])
    return None


def common_times(plans: tuple[Plan, ...]) -> NDArray[np.float64]:
    """Return the times [s] of all points of the plans, and others between, so that none are `STEP` apart."""
    return all_times(*(plan.trajectory.times for plan in plans))


def all_times(*given: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return all given times [s], each shape (k,), and others between, so that none are `STEP` apart."""
    last = max(float(times[-1]) for times in given)
    even = np.linspace(0.0, last, max(2, int(np.ceil(last / STEP)) + 1))
    return np.unique(np.concatenate([even, *given]))
