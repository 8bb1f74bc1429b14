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
from grip_bt.base.values import JointState, Trajectory
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
from grip_bt.commanders.planning.paths import arc, at_arc, interpolated, kept
from grip_bt.commanders.planning.requests import PlanThrough, PlanTo
from grip_bt.commanders.planning.search import RESOLUTION, Search, first_success
from grip_bt.commanders.planning.straight import closer, ends_of, finer_and_finer, keeps_to_lines, straight_path
from grip_bt.commanders.trajectory.splines import joined

SMALLEST = 1e-3
"""A smaller blend isn't worth it: the arm comes to rest at the point [m]."""
OUTSIDE = 1e-4
"""How far a rounded corner may be outside the ball [m]."""
_SPACING = 0.06
_SAME = 1e-4
_CLOSE = 0.01
"""Rows of a segment this near to a blend [rad] are left out: the spline through both would bend."""


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


_SHRUNK = (1.0, 0.5, 0.25, 0.125)
ROUNDING = 1e-3
"""Configurations on a line that keeps to a constraint may leave it by this, as they are solved numerically [rad, m]."""
_ABOUT = 0.03


Radii = tuple[float, ...]


def plan_through(model: RobotModel, request: PlanThrough, canceled: Callable[[], bool]) -> tuple[Trajectory, Radii]:
    """Plan a motion through way points; return it, and the blend radii that it has at the inner ones [m].

    Raises:
        StartInCollisionError, OutOfLimitsError, GoalInCollisionError: `data` names pairs or joints.
        NoIkError: a pose or a part of a line is out of reach.
        NoPlanError, TimeOutError: no path around obstacles was found, or not in time.
        PathInvalidError: a joint would jump, or a straight segment touches something.
        ConstraintBrokenError: the start, a way point or a straight segment breaks what the motion must keep to.
    """
    through, settings = _Through(model, request, canceled), request.situation.settings
    attempts = settings.attempts if any(not point.straight for point in request.way_points) else 1
    for attempt in range(attempts):
        segments = through.segments(attempt)
        try:
            return finer_and_finer(partial(through.followed, segments))
        except PathInvalidError:
            if attempt == attempts - 1:
                raise
    raise AssertionError("unreachable")


class _Through:
    """What the segments and corners of one request share."""

    def __init__(self, model: RobotModel, request: PlanThrough, canceled: Callable[[], bool]):
        self.request, self.canceled, self.settings = request, canceled, request.situation.settings
        self.budget = Budget(self.settings.planning_time)
        self.chain, self.checker = chain_and_checker(model, request.situation)
        self.start = free_start(self.chain, self.checker, request.situation, request.constraint)
        self.lines = [p.straight and not isinstance(p.goal, JointState) for p in request.way_points]

    def segments(self, attempt: int) -> list[Path]:
        segments, start, constraint = list[Path](), self.start, self.request.constraint
        for k, point in enumerate(self.request.way_points):
            where = f"segment {k + 1} of {len(self.request.way_points)}"
            assert not isinstance(point.goal, str), "the arm knows its named states, the planner doesn't"
            if point.straight and not isinstance(point.goal, JointState):
                segments.append(straight_path(self.chain, start, point.goal, where))
            else:
                ask = self.settings.model_copy(update={"seed": self.settings.seed + attempt})
                to = PlanTo(replace(self.request.situation, settings=ask), point.goal, constraint=constraint)
                goals = goals_of(self.chain, self.checker, to, start)
                if point.straight:
                    segments.append(np.stack([start, goals[0]]))
                else:
                    search = partial(Search(self.checker, ask, constraint, self.canceled).path, start)
                    finer = RESOLUTION / 2 ** min(attempt, 2)
                    tries = [partial(search, goal, resolution=finer) for goal in goals]
                    segments.append(first_success(tries, self.budget))
            if point.straight and not self.keeping(interpolated(segments[-1], RESOLUTION)):
                raise ConstraintBrokenError(
                    f"{where}: the straight way leaves what the motion must keep to; search it (`straight: false`), "
                    "or widen the tolerances or the box"
                )
            start = segments[-1][-1]
        return segments

    def keeping(self, rows: Path) -> bool:
        constraint = self.request.constraint
        return constraint is None or kept(constraint, self.chain, rows, ROUNDING)

    def followed(self, segments: list[Path], finer: int) -> tuple[Trajectory, Radii] | None:
        """Round and time segments, lines of the hand so many times finer; None where the result is off them."""
        chain, checker, constraint = self.chain, self.checker, self.request.constraint
        paths = [closer(chain, s, finer) if line else s for s, line in zip(segments, self.lines, strict=True)]
        parts, radii = self.rounded(paths)
        for part in parts:
            refuse_collisions(checker, interpolated(part, RESOLUTION))
        trajectory = joined([timed_free(checker, part, self.settings, constraint) for part in parts])
        elsewhere = [s for s, line in zip(segments, self.lines, strict=True) if not line]  # there, lines say nothing
        ends = [ends_of(chain, s) for s, line in zip(segments, self.lines, strict=True) if line]
        balls = [
            *((chain.grasp_pose(s[-1]).translation, r + OUTSIDE) for s, r in zip(segments[:-1], radii, strict=True)),
            *((chain.grasp_pose(q).translation, _ABOUT) for s in elsewhere for q in interpolated(s, RESOLUTION)),
        ]
        return (trajectory, radii) if keeps_to_lines(chain, trajectory.positions, ends, balls) else None

    def rounded(self, segments: list[Path]) -> tuple[list[Path], Radii]:
        """Round the corners between segments; return paths at whose ends the arm comes to rest, and the radii."""
        begins, parts, radii = 0.0, list[Path](), list[float]()
        before: Path | None = None
        for k, segment in enumerate(segments):
            radius, ends, after, rows = 0.0, 0.0, 0.0, None
            if k + 1 < len(segments):
                incoming, outgoing = Leg(self.chain, segment[::-1]), Leg(self.chain, segments[k + 1])
                radius, rows = self.fitting(incoming, outgoing, segment[-1], self.request.way_points[k].radius)
                radii.append(radius)
                if rows is not None:
                    ends, after = incoming.crossing(radius), outgoing.crossing(radius)
            own = without_ends(segment, begins, ends)
            if before is None:
                parts.append(own)
            else:
                parts[-1] = np.concatenate([parts[-1][:-1], before, own[1:]])
            begins, before = after, rows
        return [distinct(part) for part in parts], tuple(radii)

    def fitting(self, incoming: Leg, outgoing: Leg, point: Array, asked: float) -> tuple[float, Path | None]:
        """Return the radius that fits at a way point [m] and the corner's rows; 0 and None: the arm has to stop."""
        largest = min(asked, incoming.reach, outgoing.reach)
        for part in _SHRUNK:
            radius = largest * part
            if radius < SMALLEST:
                break
            rows = corner(incoming, outgoing, radius)
            fine = interpolated(rows, RESOLUTION)
            possible = self.keeping(rows) and within(self.chain, point, rows, radius)
            if possible and self.chain.within_limits(fine, slack=1e-3) and continuously_free(self.checker, fine):
                return radius, rows
        return 0.0, None
