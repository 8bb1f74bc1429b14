"""Steps of steered motions: the grasp frame goes on with a twist for a moment, then comes to rest; all is checked."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.failures import NoIkError, PathInvalidError
from grip_bt.base.values import Trajectory
from grip_bt.commanders.planning.checks import out_of_limits, touching

from ..kinematics.collision import recent_checker
from ..kinematics.model import Chain, RobotModel
from ..steered_motion import velocity_of
from ..steering import bounded, steered
from .checks import allowed
from .continuous import first_touch
from .requests import PlanServoStep

DAMPING = 1e-4
"""Of the pseudo-inverse of the Jacobian: near singular configurations joints would else become too fast."""
AMISS = 0.3
"""A twist of which more than this part can't be had isn't begun."""


def plan_servo_step(model: RobotModel, request: PlanServoStep) -> Trajectory:
    """Plan one step.

    Raises:
        NoIkError: the arm can't move its hand that way from there.
        OutOfLimitsError: a joint would leave its limits; `data['joints']` names it.
        PathInvalidError: something would be touched, at the latest while coming to rest; `data['pairs']` names what.
    """
    situation, settings = request.situation, request.situation.settings
    chain = model.chain(situation.group, situation.start)
    start = np.clip(situation.start.ordered(chain.joints), chain.limits.lower, chain.limits.upper)
    fastest, hardest, sharpest = allowed(chain, settings)
    twist = np.concatenate(bounded(request.linear, request.angular))
    begin = velocity_of(situation.start, chain.joints)

    def wanted(q: Array) -> Array:
        return _joint_velocity(chain, q, twist, fastest)

    step = steered(chain.joints, start, begin, wanted, hardest, request.hold, sharpest)
    for row in step.positions:
        if not chain.within_limits(row, slack=1e-3):
            raise out_of_limits(chain, row, "the next steering step would be")
    checker = recent_checker(chain, situation.scene, situation.hand, 0.0)
    if touched := first_touch(checker, step):
        raise PathInvalidError(f"the steering step would collide: {touching(touched[1])}", pairs=touched[1])
    return step


def _joint_velocity(chain: Chain, q: Array, twist: Array, fastest: Array) -> Array:
    """Return the joint velocities of a twist, shape (n,), made slower as a whole where a joint is too fast."""
    jacobian = pin.computeFrameJacobian(chain.model, chain.data, q, chain.frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    square = jacobian @ jacobian.T + DAMPING * np.eye(6)
    rates: Array = jacobian.T @ np.linalg.solve(square, twist)
    lost = float(np.linalg.norm(jacobian @ rates - twist))
    if lost > AMISS * float(np.linalg.norm(twist)):
        raise NoIkError("the arm is stretched out, or its axes lie in line: its hand can't move that way from here")
    return rates / max(1.0, float((np.abs(rates) / fastest).max()))
