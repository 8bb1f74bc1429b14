"""Answers planning requests: pure functions of a robot model and a request, apart from the time they take."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from grip_bt.base.arrays import Array, Path
from grip_bt.base.failures import ConstraintBrokenError, ExpectedError, NoPlanError, PathInvalidError, TimeOutError
from grip_bt.base.values import Plan, Trajectory

from ..collision import CollisionChecker, recent_checker
from ..model import Chain, RobotModel
from .along import plan_along
from .beginning import chain_and_checker, free_start, timed_free
from .budget import REAL, Budget, Clocks
from .common import check_together
from .constraints import CONSTRAINT_SLACK, kept
from .free import plan_constrained, plan_free
from .goals import goals_of
from .grasps import choose_grasp
from .lines import plan_straight
from .onward import plan_onward
from .requests import (
    CheckTogether,
    ChooseGrasp,
    ChosenGrasp,
    PlanAlong,
    PlanOnward,
    PlanStraight,
    PlanThrough,
    PlanTo,
    Request,
)
from .through import plan_through

SEARCH = 0.03
"""While a path is searched, no joint moves more than this [rad] between two checks; later attempts look closer."""


def answer(
    model: RobotModel, request: Request, canceled: Callable[[], bool], clocks: Clocks = REAL
) -> Plan | ChosenGrasp | None:
    """Answer a request.

    Args:
        canceled: asked often; True ends it.
        clocks: what tells the time that a search may take.

    Raises:
        ExpectedError: with the reason why there is no answer.
    """
    begin = time.monotonic()
    if isinstance(request, CheckTogether):
        check_together(model, request)
        return None
    if isinstance(request, ChooseGrasp):
        return choose_grasp(model, request.situation, request.grasps, canceled, clocks)
    if isinstance(request, PlanStraight):
        planner, trajectory = "straight", plan_straight(model, request)
    elif isinstance(request, PlanThrough):
        trajectory, radii = plan_through(model, request, canceled, clocks)
        return Plan(request.situation.group, trajectory, "through", time.monotonic() - begin, radii)
    elif isinstance(request, PlanOnward):
        planner, trajectory = "onward", plan_onward(model, request)
    elif isinstance(request, PlanAlong):
        planner, trajectory = "given", plan_along(model, request)
    else:
        planner, trajectory = request.situation.settings.planner, plan_to(model, request, canceled, clocks)
    return Plan(request.situation.group, trajectory, planner, time.monotonic() - begin)


def plan_to(model: RobotModel, request: PlanTo, canceled: Callable[[], bool], clocks: Clocks = REAL) -> Trajectory:
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
    budget = Budget(settings.time_limit, clocks)
    chain, checker = chain_and_checker(model, situation, margin=0.0)
    start = free_start(chain, checker, situation)
    if request.constraint is not None and not kept(request.constraint, chain, start[None, :]):
        raise ConstraintBrokenError("the start breaks what the path must keep to; widen its tolerances or its box")
    goals = goals_of(chain, checker, request, start)
    roomy = recent_checker(chain, situation.scene, situation.hand, settings.margin)
    wide = roomy.free(start)
    tries = [(goal, c) for goal in goals for c in ([roomy] if wide and roomy.free(goal) else []) + [checker]]
    failure: ExpectedError = NoPlanError("there is no goal to plan to")
    for k, (goal, avoid) in enumerate(tries):
        search = _search(avoid, request, start, goal, canceled)
        try:
            return _searched_and_timed(chain, checker, search, request, budget.share(len(tries) - k))
        except (NoPlanError, TimeOutError, PathInvalidError) as error:
            if budget.out_of_time:
                raise
            failure = error
    raise failure


def _search(
    avoid: CollisionChecker, request: PlanTo, start: Array, goal: Array, canceled: Callable[[], bool]
) -> Callable[..., Path]:
    """Return the search that fits the request, as a function of seed, budget and resolution."""
    if request.constraint is not None:
        return partial(plan_constrained, avoid, request.constraint, start, goal, canceled=canceled)
    settings = request.situation.settings
    return partial(
        plan_free, avoid, start, goal, settings.planner, canceled=canceled, parameters=dict(settings.parameters)
    )


def _searched_and_timed(
    chain: Chain, checker: CollisionChecker, search: Callable[..., Path], request: PlanTo, budget: Budget
) -> Trajectory:
    """Search, time and check; a path that turns out to graze something is searched again, more finely."""
    settings, constraint = request.situation.settings, request.constraint

    def keeping(trajectory: Trajectory) -> bool:
        return constraint is None or kept(constraint, chain, trajectory.positions, CONSTRAINT_SLACK)

    for attempt in range(settings.attempts):
        path = search(seed=settings.seed + attempt, budget=budget, resolution=SEARCH / 2 ** min(attempt, 2))
        try:
            return timed_free(checker, path, settings, keeping)
        except PathInvalidError:
            if attempt == settings.attempts - 1:
                raise
    raise AssertionError("unreachable")
