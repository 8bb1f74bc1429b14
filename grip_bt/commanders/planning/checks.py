"""What every plan begins and ends with: what moves, what it avoids, where it starts and may end, how it is timed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array, Path
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import (
    ConstraintBrokenError,
    GoalInCollisionError,
    NoIkError,
    OutOfLimitsError,
    PathInvalidError,
    StartInCollisionError,
)
from grip_bt.base.values import JointState, PathConstraint, Pose, Trajectory
from grip_bt.base.values.pose import check_frame
from grip_bt.commanders.kinematics.collision import CollisionChecker, checker_of
from grip_bt.commanders.kinematics.damped_least_squares import Target
from grip_bt.commanders.kinematics.ik import solver
from grip_bt.commanders.kinematics.model import Chain, RobotModel
from grip_bt.commanders.planning.continuous import trajectory_free
from grip_bt.commanders.planning.paths import CONSTRAINT_SLACK, kept
from grip_bt.commanders.planning.requests import PlanTo, Situation
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.commanders.trajectory.limits import Limits
from grip_bt.commanders.trajectory.timing import timed

_GOALS = 4
_RESTARTS = 20


def goals_of(chain: Chain, checker: CollisionChecker, request: PlanTo, start: Array) -> list[Array]:
    """Return free configurations that end the motion, each of shape (n,), the best ones first.

    Raises:
        GoalInCollisionError: `data['pairs']` names what touches.
        OutOfLimitsError: joint positions break the limits; `data['joints']` names them.
        NoIkError: nothing reaches the pose, or any of the poses.
        ConstraintBrokenError: what was found breaks the path's constraint.
        UnknownNameError: the goal names a joint that isn't of the group.
    """
    if isinstance(request.goal, JointState):
        goals = [_joint_goal(chain, checker, request.goal, start)]
    else:
        goals = _pose_goals(chain, checker, request, start)
    if request.constraint is None:
        return goals
    keeping = [q for q in goals if kept(request.constraint, chain, q[None, :])]
    if not keeping:
        raise ConstraintBrokenError("the goal violates the path constraint; widen its tolerances or its box")
    return keeping


def _joint_goal(chain: Chain, checker: CollisionChecker, goal: JointState, start: Array) -> Array:
    """Return the goal's configuration; joints that it doesn't name stay where they are."""
    q = np.array(start)
    for name, position in zip(goal.names, goal.position, strict=True):
        if name not in chain.joints:
            raise UnknownNameError("joint", name, chain.joints, where="goal")
        q[chain.joints.index(name)] = position
    if not np.all(np.isfinite(q)) or not chain.within_limits(q):
        raise out_of_limits(chain, q, "the goal is")
    if pairs := checker.pairs(q):
        raise GoalInCollisionError(f"at the goal, {touching(pairs)}", pairs=pairs)
    return q


def _pose_goals(chain: Chain, checker: CollisionChecker, request: PlanTo, start: Array) -> list[Array]:
    """Return a few free configurations that reach the pose: those of hints first, then by their distance."""
    hinted = [q for q in _reaching(chain, request, start, hints_only=True) if checker.free(q)]
    found: list[Array] = []
    pairs: tuple[tuple[str, str], ...] = ()
    for q in _reaching(chain, request, start, hints_only=False):
        contacts = checker.pairs(q)
        if not contacts:
            found.append(q)
        pairs = contacts or pairs
        if len(found) + len(hinted) >= _GOALS:
            break
    if hinted or found:
        return hinted + sorted(found, key=lambda q: float(np.linalg.norm(q - start)))
    if pairs:
        raise GoalInCollisionError(f"every solution for the pose is in collision: {touching(pairs)}", pairs=pairs)
    poses = _poses(request)
    what = f"{poses[0]}" if len(poses) == 1 else f"any of {len(poses)} poses"
    raise NoIkError(f"no joint positions reach {what}", pose=poses[0])


def _reaching(chain: Chain, request: PlanTo, start: Array, hints_only: bool) -> Iterator[Array]:
    """Yield configurations that reach the poses, a few of each in turn."""
    settings = request.situation.settings
    rng, find = np.random.default_rng(settings.seed), solver(settings.kinematics)
    seeds = tuple(h.ordered(chain.joints) for h in request.hints) if hints_only else (start,)
    waiting = [
        find(chain, Target(pin.SE3(pose.matrix()), request.free), rng, seeds, 0 if hints_only else _RESTARTS)
        for pose in _poses(request)
    ]
    while waiting:
        for search in list(waiting):
            q = next(search, None)
            if q is None:
                waiting.remove(search)
            else:
                yield q


def _poses(request: PlanTo) -> tuple[Pose, ...]:
    assert not isinstance(request.goal, JointState)
    poses = (request.goal,) if isinstance(request.goal, Pose) else request.goal
    for pose in poses:
        check_frame(pose, "world")
    return poses


def out_of_limits(chain: Chain, q: Array, what: str) -> OutOfLimitsError:
    """Return the error about a configuration, shape (n,), that breaks position limits."""
    rows = zip(chain.joints, q, chain.limits.lower, chain.limits.upper, strict=True)
    outside = {name: (float(x), float(low), float(high)) for name, x, low, high in rows if not low <= x <= high}
    text = ", ".join(f"{n} = {x:.3f} (allowed {low:.3f} .. {high:.3f})" for n, (x, low, high) in outside.items())
    return OutOfLimitsError(f"{what} out of limits: {text}", joints=tuple(outside))


def touching(pairs: Sequence[tuple[str, str]]) -> str:
    """Return up to three pairs of names in words; without any, why a motion counts as touching."""
    if not pairs:
        return "two bodies come closer than 0.05 mm, which counts as contact"
    shown = "; ".join(f"{a} touches {b}" for a, b in pairs[:3])
    return shown + (f"; and {len(pairs) - 3} more pairs" if len(pairs) > 3 else "")


START_SLACK = 0.03
"""A measured start may be outside the limits by this much [rad]; it is drawn in."""


def chain_and_checker(model: RobotModel, situation: Situation) -> tuple[Chain, CollisionChecker]:
    """Return what moves, and what tells whether it is free."""
    chain = model.chain(situation.group, situation.start)
    return chain, checker_of(chain, situation.scene, situation.hand)


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


def allowed(chain: Chain, settings: PlanningSettings) -> Limits:
    """Return what the joints may do of what they can."""
    limits, jerk = chain.limits, settings.jerk
    return replace(
        limits,
        velocity=limits.velocity * settings.speed,
        acceleration=limits.acceleration * (settings.acceleration or settings.speed),
        jerk=None if jerk is None or limits.jerk is None else limits.jerk * jerk,
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

    return timed(chain.joints, path, allowed(chain, settings), acceptable)
