"""What every plan begins with: the chain that moves, what it avoids, where it starts; and what every plan ends with."""

from __future__ import annotations

import numpy as np

from grip_bt.base.arrays import Array, Path
from grip_bt.base.failures import ConstraintBrokenError, PathInvalidError, StartInCollisionError
from grip_bt.base.values import PathConstraint, Trajectory

from ..kinematics.collision import CollisionChecker, recent_checker
from ..kinematics.model import Chain, RobotModel
from ..settings import PlanningSettings
from ..trajectory.timing import Allowed, timed
from .continuous import continuously_free, trajectory_free
from .goals import out_of_limits, touching
from .paths import CONSTRAINT_SLACK, kept
from .requests import Situation

START_SLACK = 0.03
"""A measured start may be outside the limits by this much [rad]; it is drawn in."""


def chain_and_checker(model: RobotModel, situation: Situation, margin: float) -> tuple[Chain, CollisionChecker]:
    """Return what moves, and what tells whether it is free, `margin` [m] away from the scene's objects."""
    chain = model.chain(situation.group, situation.start)
    return chain, recent_checker(chain, situation.scene, situation.hand, margin)


def drawn_in(chain: Chain, situation: Situation) -> Array:
    """Return the start within the limits, shape (n,).

    Raises:
        OutOfLimitsError: it is outside by more than `START_SLACK`.
    """
    start = situation.start.ordered(chain.joints)
    if not chain.within_limits(start, START_SLACK):
        raise out_of_limits(chain, start, "the start is")
    return np.clip(start, chain.limits.lower, chain.limits.upper)


def free_start(
    chain: Chain, checker: CollisionChecker, situation: Situation, constraint: PathConstraint | None = None
) -> Array:
    """Return the start within the limits, shape (n,).

    Raises:
        OutOfLimitsError: it is outside by more than `START_SLACK`.
        StartInCollisionError: something is touched there.
        ConstraintBrokenError: it breaks the constraint.
    """
    start = drawn_in(chain, situation)
    if pairs := checker.pairs(start):
        raise StartInCollisionError(f"at the start, {touching(pairs)}", pairs=pairs)
    if constraint is not None and not kept(constraint, chain, start[None, :]):
        raise ConstraintBrokenError("the start violates the path constraint; widen its tolerances or its box")
    return start


def refuse_collisions(checker: CollisionChecker, path: Path) -> None:
    """Look at the rows of a path.

    Raises:
        PathInvalidError: one touches something; `data` says which `pairs`, and after what `fraction` of the rows.
    """
    free = checker.free_each(path)
    if not free.all():
        row = int(np.argmin(free))
        pairs = checker.pairs(path[row])
        raise PathInvalidError(
            f"after {row / len(path):.0%} of the straight motion, {touching(pairs)}",
            pairs=pairs,
            fraction=row / len(path),
        )


def finely_free(checker: CollisionChecker, positions: Array) -> bool:
    """Tell whether the motion through the rows, shape (k, n), is within limits and free all along."""
    within = checker.chain.within_limits(positions, slack=1e-3)
    return within and continuously_free(checker, positions)


def allowed(chain: Chain, settings: PlanningSettings) -> Allowed:
    """Return what the joints may do of what they can."""
    limits, jerk = chain.limits, settings.jerk
    return Allowed(
        limits.velocity * settings.speed,
        limits.acceleration * (settings.acceleration or settings.speed),
        None if jerk is None or limits.jerk is None else limits.jerk * jerk,
    )


def timed_free(
    checker: CollisionChecker,
    path: Path,
    settings: PlanningSettings,
    constraint: PathConstraint | None = None,
) -> Trajectory:
    """Return a path as a trajectory from rest to rest that is within limits, and free as it is executed.

    Raises:
        PathInvalidError: it can't be timed so.
    """
    chain = checker.chain

    def acceptable(trajectory: Trajectory) -> bool:
        keeping = constraint is None or kept(constraint, chain, trajectory.positions, CONSTRAINT_SLACK)
        return keeping and trajectory_free(checker, trajectory)

    return timed(chain.joints, path, chain.limits, allowed(chain, settings), acceptable)
