"""Motions through way points, as one: without a stop where a point has a blend radius (as MoveIt's Pilz sequences).

From where the grasp frame comes into the ball about a way point to where it leaves it, the arm goes smoothly from one
segment to the next: (1 - a(s)) in(s) + a(s) out(s), with a quintic `a`, so that velocity and acceleration are
continuous (as Pilz blends in time; here in joint space and along the path, which is timed afterwards).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from grip_bt.base.arrays import Array, Path
from grip_bt.base.failures import ConstraintBrokenError, PathInvalidError
from grip_bt.base.values import JointState, PathConstraint, Trajectory
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.model import Chain, RobotModel
from grip_bt.commanders.planning.budget import Budget
from grip_bt.commanders.planning.checks import (
    chain_and_checker,
    free_start,
    goals_of,
    refuse_collisions,
    timed_free,
)
from grip_bt.commanders.planning.continuous import continuously_free
from grip_bt.commanders.planning.paths import interpolated, kept
from grip_bt.commanders.planning.requests import PlanThrough, PlanTo
from grip_bt.commanders.planning.search import RESOLUTION, Search, first_success
from grip_bt.commanders.planning.straight import closer, ends_of, finer_and_finer, keeps_to_lines, line_to
from grip_bt.commanders.trajectory.splines import joined

SMALLEST = 1e-3
"""A smaller blend isn't worth it: the arm comes to rest at the point [m]."""
OUTSIDE = 1e-4
"""A rounded corner may be so far outside the ball [m]."""
_SPACING = 0.06
_SAME = 1e-4
_CLOSE = 0.01
"""Rows of a segment so near to a blend [rad] are left out: the spline through both would bend."""


class Leg:
    """One of the two segments that meet at a way point, looked at from there.

    Attributes:
        reach: the radius of the largest ball that the first half of the segment leaves [m].

    Args:
        path: the segment's configurations, shape (k, n), the first one at the way point.
    """

    def __init__(self, chain: Chain, path: Path):
        self.path = path
        half = arc(path)[-1] / 2
        self._at = np.linspace(0.0, half, int(np.ceil(half / RESOLUTION)) + 2)
        origins = np.stack([chain.grasp_pose(q).translation for q in at_arc(path, self._at)])
        self._distances = np.linalg.norm(origins - origins[0], axis=1)
        self.reach = float(self._distances.max())

    def crossing(self, radius: float) -> float:
        """Return how far along the segment [rad] it leaves a ball, which is no larger than its reach."""
        last = max(1, int(np.argmax(self._distances >= radius - 1e-9)))
        before, after = self._distances[last - 1], self._distances[last]
        return float(np.interp(radius, [before, after], self._at[last - 1 : last + 1]))


def corner(incoming: Leg, outgoing: Leg, radius: float) -> Path:
    """Return the rounded corner: configurations from where it leaves one segment to where it joins the next."""
    before, after = incoming.crossing(radius), outgoing.crossing(radius)
    count = int(np.clip(np.ceil((before + after) / _SPACING), 8, 40))
    s = np.linspace(0.0, 1.0, count + 1)
    weight = (s**3 * (10 - 15 * s + 6 * s**2))[:, None]
    return (1 - weight) * at_arc(incoming.path, (1 - s) * before) + weight * at_arc(outgoing.path, s * after)


def within(chain: Chain, way_point: Array, rows: Path, radius: float) -> bool:
    """Tell whether a corner's rows, shape (k, n), keep the grasp frame in the ball about a way point, shape (n,)."""
    centre = chain.grasp_pose(way_point).translation
    away = [np.linalg.norm(chain.grasp_pose(q).translation - centre) for q in rows]
    return bool(max(away) <= radius + OUTSIDE)


def without_ends(path: Path, begin: float, end: float) -> Path:
    """Return a segment without `begin` [rad] of its beginning and `end` [rad] of its end, which corners replace."""
    at = arc(path)
    first, last = begin, at[-1] - end
    kept = path[(at > first + _CLOSE) & (at < last - _CLOSE)]
    head, tail = at_arc(path, np.array([first, last]))
    return np.concatenate([head[None, :], kept, tail[None, :]])


def distinct(path: Path) -> Path:
    """Return a path without rows that are hardly away from the one before; both its ends stay."""
    rows = [path[0]]
    for row in path[1:-1]:
        if np.linalg.norm(row - rows[-1]) > _SAME and np.linalg.norm(row - path[-1]) > _SAME:
            rows.append(row)
    return np.stack([*rows, path[-1]])


def at_arc(path: Path, where: Array) -> Path:
    """Return the configurations so far along a path [rad], shape (m,) -> (m, n)."""
    at = arc(path)
    return np.stack([np.interp(where, at, column) for column in path.T], axis=1)


def arc(path: Path) -> Array:
    """Return how far along the path [rad] its rows are, joints weighted alike, shape (k,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])


_SHRUNK = (1.0, 0.5, 0.25, 0.125)
ROUNDING = 1e-3
"""Configurations on a line that keeps to a constraint may leave it by this, as they are solved numerically [rad, m]."""
_ABOUT = 0.03


def plan_through(
    model: RobotModel, request: PlanThrough, canceled: Callable[[], bool]
) -> tuple[Trajectory, tuple[float, ...]]:
    """Plan a motion through way points; return it, and the blend radii that it has at the inner ones [m].

    Raises:
        StartInCollisionError, OutOfLimitsError, GoalInCollisionError: `data` names pairs or joints.
        NoIkError: a pose or a part of a line is out of reach.
        NoPlanError, TimeOutError: no path around obstacles was found, or not in time.
        PathInvalidError: a joint would jump, or a straight segment touches something.
        ConstraintBrokenError: the start, a way point or a straight segment breaks what the motion must keep to.
    """
    settings = request.situation.settings
    budget = Budget(settings.planning_time)
    chain, checker = chain_and_checker(model, request.situation, margin=0.0)
    start = free_start(chain, checker, request.situation, request.constraint)
    searched = any(not point.straight for point in request.way_points)
    attempts = settings.attempts if searched else 1
    for attempt in range(attempts):
        segments = _segments(chain, checker, request, start, attempt, budget, canceled)
        try:
            return finer_and_finer(partial(_followed, chain, checker, request, segments))
        except PathInvalidError:
            if attempt == attempts - 1:
                raise
    raise AssertionError("unreachable")


def _followed(
    chain: Chain, checker: CollisionChecker, request: PlanThrough, segments: list[Path], finer: int
) -> tuple[Trajectory, tuple[float, ...]] | None:
    """Round and time segments, lines of the hand so many times finer; None where the result is off them."""
    lines = [point.straight and not isinstance(point.goal, JointState) for point in request.way_points]
    paths = [closer(chain, s, finer) if line else s for s, line in zip(segments, lines, strict=True)]
    asked = [point.radius for point in request.way_points[:-1]]
    parts, radii = rounded(chain, checker, paths, asked, request.constraint)
    for part in parts:
        refuse_collisions(checker, interpolated(part, RESOLUTION))
    trajectory = joined([timed_free(checker, part, request.situation.settings, request.constraint) for part in parts])
    elsewhere = [s for s, line in zip(segments, lines, strict=True) if not line]  # there, lines say nothing
    ends = [ends_of(chain, s) for s, line in zip(segments, lines, strict=True) if line]
    balls = [
        *((chain.grasp_pose(s[-1]).translation, r + OUTSIDE) for s, r in zip(segments[:-1], radii, strict=True)),
        *((chain.grasp_pose(q).translation, _ABOUT) for s in elsewhere for q in interpolated(s, RESOLUTION)),
    ]
    return (trajectory, radii) if keeps_to_lines(chain, trajectory.positions, ends, balls) else None


def rounded(
    chain: Chain,
    checker: CollisionChecker,
    segments: list[Path],
    radii: list[float],
    constraint: PathConstraint | None = None,
) -> tuple[list[Path], tuple[float, ...]]:
    """Round the corners between segments.

    Returns:
        Paths at whose ends the arm comes to rest, and the radii that fitted.
    """
    begins, ends, corners = [0.0] * len(segments), [0.0] * len(segments), list[Path | None]()
    fitted = []
    for k, asked in enumerate(radii):
        incoming, outgoing = Leg(chain, segments[k][::-1]), Leg(chain, segments[k + 1])
        radius, rows = _fitting(chain, checker, incoming, outgoing, segments[k][-1], asked, constraint)
        fitted.append(radius)
        corners.append(rows)
        if rows is not None:
            ends[k], begins[k + 1] = incoming.crossing(radius), outgoing.crossing(radius)
    parts: list[Path] = []
    for k, segment in enumerate(segments):
        own = without_ends(segment, begins[k], ends[k])
        before = corners[k - 1] if k else None
        if before is None:
            parts.append(own)
        else:
            parts[-1] = np.concatenate([parts[-1][:-1], before, own[1:]])
    return [distinct(part) for part in parts], tuple(fitted)


def _fitting(
    chain: Chain,
    checker: CollisionChecker,
    incoming: Leg,
    outgoing: Leg,
    point: Array,
    asked: float,
    constraint: PathConstraint | None,
) -> tuple[float, Path | None]:
    """Return the radius that fits at a way point [m] and the corner's rows; 0 and None where the arm has to stop."""
    largest = min(asked, incoming.reach, outgoing.reach)
    for part in _SHRUNK:
        radius = largest * part
        if radius < SMALLEST:
            break
        rows = corner(incoming, outgoing, radius)
        keeping = constraint is None or kept(constraint, chain, rows, ROUNDING)
        fine = interpolated(rows, RESOLUTION)
        possible = keeping and within(chain, point, rows, radius) and chain.within_limits(fine, slack=1e-3)
        if possible and continuously_free(checker, fine):
            return radius, rows
    return 0.0, None


def _segments(
    chain: Chain,
    checker: CollisionChecker,
    request: PlanThrough,
    start: Array,
    attempt: int,
    budget: Budget,
    canceled: Callable[[], bool],
) -> list[Path]:
    segments: list[Path] = []
    for k, point in enumerate(request.way_points):
        where = f"segment {k + 1} of {len(request.way_points)}"
        assert not isinstance(point.goal, str), "the arm knows its named states, the planner doesn't"
        if point.straight and not isinstance(point.goal, JointState):
            segments.append(line_to(chain, start, point.goal, where))
        else:
            settings = request.situation.settings
            ask = settings.model_copy(update={"seed": settings.seed + attempt})
            to = PlanTo(replace(request.situation, settings=ask), point.goal, constraint=request.constraint)
            goals = goals_of(chain, checker, to, start)
            if point.straight:
                segments.append(np.stack([start, goals[0]]))
            else:
                search = partial(Search(checker, ask, request.constraint, canceled).path, start)
                finer = RESOLUTION / 2 ** min(attempt, 2)
                segments.append(first_success([partial(search, goal, resolution=finer) for goal in goals], budget))
        kept_to = request.constraint if point.straight else None
        if kept_to is not None and not kept(kept_to, chain, interpolated(segments[-1], RESOLUTION), ROUNDING):
            raise ConstraintBrokenError(
                f"{where}: the straight way leaves what the motion must keep to; search it (`straight: false`), "
                "or widen the tolerances or the box"
            )
        start = segments[-1][-1]
    return segments
