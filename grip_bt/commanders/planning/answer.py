"""Answers to planning requests: which plan each asks for, of whom."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio as pin
from scipy.interpolate import PchipInterpolator

from grip_bt.base.arrays import Array
from grip_bt.base.failures import NoIkError, PathInvalidError
from grip_bt.base.values import Plan, Trajectory
from grip_bt.base.values.joints import MOVE_GROUP
from grip_bt.commanders.kinematics.collision import CollisionChecker, checker_of
from grip_bt.commanders.kinematics.model import Chain, RobotModel
from grip_bt.commanders.planning import requests
from grip_bt.commanders.planning.budget import Budget
from grip_bt.commanders.planning.checks import (
    allowed,
    chain_and_checker,
    free_start,
    goals_of,
    out_of_limits,
    timed_free,
    touching,
)
from grip_bt.commanders.planning.continuous import first_touch
from grip_bt.commanders.planning.grasps import choose_grasp
from grip_bt.commanders.planning.search import Search, first_success
from grip_bt.commanders.planning.straight import plan_straight
from grip_bt.commanders.planning.through import plan_through
from grip_bt.commanders.steered_motion import velocity_of
from grip_bt.commanders.steering import bounded, steered
from grip_bt.commanders.trajectory.limits import longer, refuse_beyond_limits


def check_together(model: RobotModel, request: requests.CheckTogether) -> None:
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


def plan_from_trajectory(model: RobotModel, request: requests.CheckTrajectory) -> Trajectory:
    """Return the trajectory for all joints of the group; those that it doesn't name stay where they are.

    Raises:
        OutOfLimitsError: a joint would leave its limits of position, velocity or acceleration, at a point or between
            two; `data['joints']` names it.
        PathInvalidError: something would be touched; `data` says after what `time` [s], and which `pairs`.
    """
    given, situation = request.trajectory, request.situation
    chain, checker = chain_and_checker(model, situation)
    positions = np.tile(situation.start.ordered(chain.joints), (len(given.times), 1))
    columns = [chain.joints.index(name) for name in given.names]
    positions[:, columns] = given.positions
    for moment, row in zip(given.times, positions, strict=True):
        if not chain.within_limits(row):
            raise out_of_limits(chain, row, f"{moment:.2f} s into the trajectory, it is")
    if met := checker.pairs(positions[0]):
        raise PathInvalidError(f"the trajectory starts in collision: {touching(met)}", pairs=met, time=0.0)
    known = given.velocities is not None

    def of_all(rows: Array | None) -> Array | None:  # zero for those that stay
        whole = np.zeros_like(positions)
        if rows is not None:
            whole[:, columns] = rows
        return whole if rows is not None else None

    velocities = of_all(given.velocities if known else _smooth(given))
    whole = Trajectory(chain.joints, given.times, positions, velocities, of_all(given.accelerations if known else None))
    if request.slow_down:
        limits = allowed(chain, situation.settings)
        whole = whole.stretched(whole.duration * longer(whole, limits.velocity, limits.acceleration))
    refuse_beyond_limits(whole, chain.limits)
    if touched := first_touch(checker, whole):
        at, pairs = touched
        raise PathInvalidError(f"{at:.1f} s into the trajectory, {touching(pairs)}", pairs=pairs, time=at)
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


SEARCH = 0.03
"""While a path is searched, no joint moves more than this [rad] between two checks; later attempts look closer."""


def answer(
    model: RobotModel, request: requests.Request, canceled: Callable[[], bool]
) -> Plan | requests.ChosenGrasp | None:
    """Answer a request.

    Args:
        canceled: asked often; True ends it.

    Raises:
        ExpectedError: with the reason why there is no answer.
    """
    begin, radii = time.monotonic(), tuple[float, ...]()
    match request:
        case requests.CheckTogether():
            check_together(model, request)
            return None
        case requests.ChooseGrasp():
            return choose_grasp(model, request.situation, request.grasps, canceled)
        case requests.PlanStraight():
            planner, trajectory = "straight", plan_straight(model, request)
        case requests.PlanThrough():
            planner, (trajectory, radii) = "through", plan_through(model, request, canceled)
        case requests.PlanServoStep():
            planner, trajectory = "onward", plan_servo_step(model, request)
        case requests.CheckTrajectory():
            planner, trajectory = "given", plan_from_trajectory(model, request)
        case requests.PlanTo():
            planner, trajectory = request.situation.settings.planner, plan_to(model, request, canceled)
    return Plan(request.situation.group, trajectory, planner, time.monotonic() - begin, radii)


def plan_to(model: RobotModel, request: requests.PlanTo, canceled: Callable[[], bool]) -> Trajectory:
    """Plan a free path.

    Raises:
        StartInCollisionError: `data['pairs']` names what touches.
        GoalInCollisionError: likewise; for a pose, of every solution that was found.
        OutOfLimitsError: the goal breaks position limits; `data['joints']` names them.
        NoIkError: nothing reaches the pose.
        NoPlanError: no goal can be reached.
        TimeOutError: not in time.
        PathInvalidError: the timed path isn't free.
        ConstraintBrokenError: start or goal break what the path must keep to.
    """
    situation = request.situation
    settings = situation.settings
    budget = Budget(settings.planning_time)
    chain, checker = chain_and_checker(model, situation)
    start = free_start(chain, checker, situation, request.constraint)
    goals = goals_of(chain, checker, request, start)
    roomy = checker_of(chain, situation.scene, situation.hand, settings.margin)
    wide = roomy.free(start)
    tries = [(goal, c) for goal in goals for c in ([roomy] if wide and roomy.free(goal) else []) + [checker]]
    attempts = [
        partial(_searched_and_timed, checker, Search(avoid, settings, request.constraint, canceled), start, goal)
        for goal, avoid in tries
    ]
    return first_success(attempts, budget)


def _searched_and_timed(
    checker: CollisionChecker, search: Search, start: Array, goal: Array, budget: Budget
) -> Trajectory:
    """Search, time and check; a path that turns out to graze something is searched again, more finely."""
    settings = search.settings
    for attempt in range(settings.attempts):
        path = search.path(start, goal, budget, attempt, SEARCH / 2 ** min(attempt, 2))
        try:
            return timed_free(checker, path, settings, search.constraint)
        except PathInvalidError:
            if attempt == settings.attempts - 1:
                raise
    raise AssertionError("unreachable")


DAMPING = 1e-4
"""Of the pseudo-inverse of the Jacobian: near singular configurations joints would otherwise become too fast."""
AMISS = 0.3
"""A twist isn't begun when more than this part of it can't be followed."""


def plan_servo_step(model: RobotModel, request: requests.PlanServoStep) -> Trajectory:
    """Plan one step.

    Raises:
        NoIkError: the arm can't move its hand that way from there.
        OutOfLimitsError: a joint would leave its limits; `data['joints']` names it.
        PathInvalidError: something would be touched, at the latest while coming to rest; `data['pairs']` names what.
    """
    situation, settings = request.situation, request.situation.settings
    chain, checker = chain_and_checker(model, situation)
    start = np.clip(situation.start.ordered(chain.joints), chain.limits.lower, chain.limits.upper)
    limits = allowed(chain, settings)
    twist = np.concatenate(bounded(request.linear, request.angular))
    begin = velocity_of(situation.start, chain.joints)

    def wanted(q: Array) -> Array:
        return _joint_velocity(chain, q, twist, limits.velocity)

    step = steered(chain.joints, start, begin, wanted, limits.acceleration, request.hold, limits.jerk)
    for row in step.positions:
        if not chain.within_limits(row, slack=1e-3):
            raise out_of_limits(chain, row, "the next steering step would be")
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
