"""Whether plans of several arms, executed at once, keep the arms apart."""

from __future__ import annotations

from grip_bt.base.failures import PathInvalidError
from grip_bt.base.values.joints import MOVE_GROUP

from ..collision import CollisionChecker
from ..model import RobotModel
from ..trajectory.limits import refuse_beyond_limits
from .continuous import first_touch
from .goals import touching
from .requests import CheckTogether


def check_together(model: RobotModel, request: CheckTogether) -> None:
    """Check the common motion all along, as it is executed.

    Raises:
        OutOfLimitsError: a plan breaks its joints' limits.
        PathInvalidError: something would be touched; `data` says after what `time` [s], and which `pairs`.
        ValueError: two plans move the same joint.
    """
    plans, situation = request.plans, request.situation
    named = [name for plan in plans for name in plan.trajectory.names]
    if len(set(named)) != len(named):
        raise ValueError(f"two plans move the same joint: {sorted(n for n in named if named.count(n) > 1)}")
    for plan in plans:
        if plan.planner != MOVE_GROUP:
            refuse_beyond_limits(plan.trajectory, model.limits_of(plan.trajectory.names))
    chain = model.joined_chain([plan.group for plan in plans], situation.start)
    checker = CollisionChecker(chain, situation.scene)
    if touched := first_touch(checker, *(plan.trajectory for plan in plans)):
        at, pairs = touched
        raise PathInvalidError(
            f"after {at:.1f} s of the common motion, {touching(pairs)}; plan for a group of both"
            " arms, or move one after the other",
            pairs=pairs,
            time=at,
        )
