"""Answers planning requests: pure functions of a robot model and a request, apart from the time they take."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from grip_bt.errors import (
    ExpectedError,
    GoalInCollisionError,
    NoIkError,
    NoPlanError,
    OutOfLimitsError,
    PathInvalidError,
    StartInCollisionError,
    TimeOutError,
    UnknownNameError,
)
from grip_bt.values import JointState, Plan, Pose, Trajectory
from grip_bt.values.pose import check_frame

from ..collision import CollisionChecker, recent_checker
from ..ik import Target, solver
from ..model import Chain, RobotModel
from ..trajectory.timing import timed
from .continuous import continuously_free
from .free import RESOLUTION, plan_free
from .grasps import choose_grasp
from .paths import Path, interpolated
from .requests import ChooseGrasp, ChosenGrasp, PlanStraight, PlanTo, Request, Situation
from .straight import BrokenLineError, straight_path

START_SLACK = 0.03
"""A measured start may be outside the limits by this much [rad]; it is drawn in."""
_GOALS = 4


def answer(model: RobotModel, request: Request, canceled: Callable[[], bool]) -> Plan | ChosenGrasp:
    """Answer a request.

    Raises:
        ExpectedError: with the reason why there is no answer.
    """
    begin = time.monotonic()
    if isinstance(request, ChooseGrasp):
        return choose_grasp(model, request.situation, request.grasps, canceled)
    if isinstance(request, PlanStraight):
        planner, trajectory = "straight", plan_straight(model, request)
    else:
        planner, trajectory = request.situation.settings.planner, plan_to(model, request, canceled)
    return Plan(request.situation.group, trajectory, planner, time.monotonic() - begin)


def plan_to(model: RobotModel, request: PlanTo, canceled: Callable[[], bool]) -> Trajectory:
    """Plan a free path.

    Raises:
        StartInCollisionError: `data['pairs']` names what touches.
        GoalInCollisionError: likewise; for a pose, of every solution that was found.
        OutOfLimitsError: the goal breaks position limits; `data['joints']` names them.
        NoIkError: nothing reaches the pose.
        NoPlanError: no goal can be reached.
        TimeOutError: not in time.
        PathInvalidError: the timed path isn't free.
    """
    situation = request.situation
    settings = situation.settings
    deadline = time.monotonic() + settings.time_limit
    chain, checker = _chain_and_checker(model, situation, margin=0.0)
    start = _free_start(chain, checker, situation)
    if isinstance(request.goal, JointState):
        goals = [_joint_goal(chain, checker, request.goal, start)]
    else:
        goals = _pose_goals(chain, checker, request, start)
    roomy = recent_checker(chain, situation.scene, situation.hand, settings.margin)
    wide = roomy.free(start)
    tries = [(goal, c) for goal in goals for c in ([roomy] if wide and roomy.free(goal) else []) + [checker]]
    failure: ExpectedError = NoPlanError("there is no goal to plan to")
    for k, (goal, avoid) in enumerate(tries):
        share = time.monotonic() + max(0.0, deadline - time.monotonic()) / (len(tries) - k)
        search = partial(plan_free, avoid, start, goal, settings.planner, canceled=canceled)
        try:
            return _searched_and_timed(chain, checker, search, settings.seed, settings.speed, share)
        except (NoPlanError, TimeOutError, PathInvalidError) as error:
            failure = error
    raise failure


def plan_straight(model: RobotModel, request: PlanStraight) -> Trajectory:
    """Plan straight lines of the grasp frame.

    Raises:
        NoIkError: part of a line is out of reach; `data['fraction']` tells how far one gets.
        PathInvalidError: a joint would jump, or something would be touched; `data['pairs']` names what.
    """
    situation = request.situation
    chain, checker = _chain_and_checker(model, situation, margin=0.0)
    start = _drawn_in(chain, situation)
    path = start[None, :]
    for k, pose in enumerate(request.poses):
        check_frame(pose, "world")
        try:
            path = np.concatenate([path, straight_path(chain, path[-1], pin.SE3(pose.matrix()))[1:]])
        except BrokenLineError as broken:
            error = PathInvalidError if broken.jump else NoIkError
            raise error(f"line {k + 1} of {len(request.poses)}: {broken}", fraction=broken.fraction) from broken
    _refuse_collisions(checker, interpolated(path, RESOLUTION))
    free = partial(_finely_free, checker)
    return timed(chain.joints, path, chain.limits, situation.settings.speed, free)


def _searched_and_timed(
    chain: Chain,
    checker: CollisionChecker,
    search: Callable[..., Path],
    seed: int,
    speed: float,
    deadline: float,
) -> Trajectory:
    """Search, time and check; a path that turns out to graze something is searched again, more finely."""
    free = partial(_finely_free, checker)
    for attempt in range(3):
        path = search(seed=seed + attempt, deadline=deadline, resolution=RESOLUTION / 2**attempt)
        try:
            return timed(chain.joints, path, chain.limits, speed, free)
        except PathInvalidError:
            if attempt == 2:
                raise
    raise AssertionError("unreachable")


def _chain_and_checker(model: RobotModel, situation: Situation, margin: float) -> tuple[Chain, CollisionChecker]:
    chain = model.chain(situation.group, situation.start)
    return chain, recent_checker(chain, situation.scene, situation.hand, margin)


def _drawn_in(chain: Chain, situation: Situation) -> NDArray[np.float64]:
    start = situation.start.ordered(chain.joints)
    if not chain.within_limits(start, START_SLACK):
        raise _out_of_limits(chain, start, "the start is")
    return np.clip(start, chain.limits.lower, chain.limits.upper)


def _free_start(chain: Chain, checker: CollisionChecker, situation: Situation) -> NDArray[np.float64]:
    start = _drawn_in(chain, situation)
    if pairs := checker.pairs(start):
        raise StartInCollisionError(f"at the start, {_touching(pairs)}", pairs=pairs)
    return start


def _joint_goal(
    chain: Chain, checker: CollisionChecker, goal: JointState, start: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the goal's configuration; joints that it doesn't name stay where they are."""
    q = np.array(start)
    for name, position in zip(goal.names, goal.position, strict=True):
        if name not in chain.joints:
            raise UnknownNameError("joint", name, chain.joints, where="goal")
        q[chain.joints.index(name)] = position
    if not np.all(np.isfinite(q)) or not chain.within_limits(q):
        raise _out_of_limits(chain, q, "the goal is")
    if pairs := checker.pairs(q):
        raise GoalInCollisionError(f"at the goal, {_touching(pairs)}", pairs=pairs)
    return q


def _pose_goals(
    chain: Chain, checker: CollisionChecker, request: PlanTo, start: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    """Return a few free configurations that reach the pose: those of hints first, then by their distance."""
    assert isinstance(request.goal, Pose)
    check_frame(request.goal, "world")
    settings = request.situation.settings
    target, rng = Target(pin.SE3(request.goal.matrix()), request.free), np.random.default_rng(settings.seed)
    hints = tuple(h.ordered(chain.joints) for h in request.hints)
    find = solver(settings.kinematics)
    hinted = [q for q in find(chain, target, rng, hints, 0) if checker.free(q)]
    found: list[NDArray[np.float64]] = []
    pairs: tuple[tuple[str, str], ...] = ()
    for q in find(chain, target, rng, (start,), 20):
        touching = checker.pairs(q)
        if not touching:
            found.append(q)
        pairs = touching or pairs
        if len(found) + len(hinted) >= _GOALS:
            break
    if hinted or found:
        return hinted + sorted(found, key=lambda q: float(np.linalg.norm(q - start)))
    if pairs:
        raise GoalInCollisionError(f"wherever the pose is reached, {_touching(pairs)}", pairs=pairs)
    raise NoIkError(f"no joint positions reach {request.goal}", pose=request.goal)


def _refuse_collisions(checker: CollisionChecker, path: Path) -> None:
    free = checker.free_each(path)
    if not free.all():
        row = int(np.argmin(free))
        pairs = checker.pairs(path[row])
        raise PathInvalidError(
            f"after {row / len(path):.0%} of the straight motion, {_touching(pairs)}",
            pairs=pairs,
            fraction=row / len(path),
        )


def _finely_free(checker: CollisionChecker, positions: NDArray[np.float64]) -> bool:
    within = checker.chain.within_limits(positions, slack=1e-3)
    return within and continuously_free(checker, positions)


def _out_of_limits(chain: Chain, q: NDArray[np.float64], what: str) -> OutOfLimitsError:
    rows = zip(chain.joints, q, chain.limits.lower, chain.limits.upper, strict=True)
    outside = {name: (float(x), float(low), float(high)) for name, x, low, high in rows if not low <= x <= high}
    text = ", ".join(f"{n} = {x:.3f} (allowed {low:.3f} .. {high:.3f})" for n, (x, low, high) in outside.items())
    return OutOfLimitsError(f"{what} out of limits: {text}", joints=tuple(outside))


def _touching(pairs: Sequence[tuple[str, str]]) -> str:
    shown = "; ".join(f"{a} touches {b}" for a, b in pairs[:3])
    return shown + (f"; and {len(pairs) - 3} more pairs" if len(pairs) > 3 else "")
