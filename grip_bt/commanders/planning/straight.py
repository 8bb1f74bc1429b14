"""Straight motions of the grasp frame: chains of nearby solutions of the inverse kinematics.

What was timed is measured against its lines, and where it is off by too much, configurations are set closer. Where two
lines meet at a corner no spline would stay on both of them: there the motion comes to rest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from grip_bt.base.arrays import Array, Path
from grip_bt.base.failures import NoIkError, PathInvalidError
from grip_bt.base.values import Pose, Trajectory
from grip_bt.base.values.pose import check_frame

from ..kinematics.collision import CollisionChecker
from ..kinematics.damped_least_squares import Target, solve_from
from ..kinematics.model import Chain, RobotModel
from ..settings import PlanningSettings
from ..trajectory.splines import joined
from .checks import chain_and_checker, drawn_in, refuse_collisions, timed_free
from .paths import interpolated
from .requests import PlanStraight
from .search import RESOLUTION

STEP = 0.015
"""Distance of the grasp frame between two solutions [m]."""
TURN = 0.08
"""Angle of the grasp frame between two solutions [rad]."""
JUMP = 0.35
"""A joint that moves more than this [rad] between two solutions has jumped to another branch."""


def world_pose(pose: Pose) -> pin.SE3:
    """Return a pose of the grasp frame as the chains have it. Raises ValueError: it isn't given in world."""
    check_frame(pose, "world")
    return pin.SE3(pose.matrix())


def straight_path(chain: Chain, start: Array, goal: Pose, where: str = "the line") -> Path:
    """Return configurations, shape (k, n), that move the grasp frame on a straight line from where `start` puts it.

    The position moves on a line, the orientation about one axis, both evenly.

    Args:
        goal: where it ends, in world.
        where: begins the words of errors.

    Raises:
        NoIkError: part of the line is out of reach; `data['fraction']` tells how far one gets.
        PathInvalidError: a joint would jump; likewise.
    """
    begin, end = chain.grasp_pose(start), world_pose(goal)
    way, turn = end.translation - begin.translation, pin.log3(begin.rotation.T @ end.rotation)
    steps = max(1, int(np.ceil(max(np.linalg.norm(way) / STEP, np.linalg.norm(turn) / TURN))))
    rows = [start]
    for k in range(1, steps + 1):
        q, fraction = _solved(chain, begin, end, k / steps, rows[-1]), (k - 1) / steps
        if q is None:
            raise NoIkError(f"{where}: out of reach after {fraction:.0%} of the line", fraction=fraction)
        if np.abs(q - rows[-1]).max() > JUMP:
            raise PathInvalidError(f"{where}: a joint jumps after {fraction:.0%} of the line", fraction=fraction)
        rows.append(q)
    return np.stack(rows)


def _solved(chain: Chain, begin: pin.SE3, end: pin.SE3, part: float, guess: Array) -> Array | None:
    """Return the configuration near `guess` that is a part of the way along a line."""
    turn, way = pin.log3(begin.rotation.T @ end.rotation), end.translation - begin.translation
    pose = pin.SE3(begin.rotation @ pin.exp3(turn * part), begin.translation + way * part)
    return solve_from(chain, Target(pose), guess)


def closer(chain: Chain, path: Path, times: int) -> Path:
    """Return a straight path, shape (k, n), with `times` as many steps; the rows that it has stay."""
    rows = [path[0]]
    for one, other in zip(path[:-1], path[1:], strict=True):
        begin, end = chain.grasp_pose(one), chain.grasp_pose(other)
        for part in np.arange(1, times) / times:
            guess = one + (other - one) * part
            q = _solved(chain, begin, end, part, guess)
            rows.append(guess if q is None else q)
        rows.append(other)
    return np.stack(rows)


T = TypeVar("T")
OFF = 1e-3
"""Largest distance of a straight motion from its line [m]."""
TURNED = 0.01
"""Largest angle between its orientation and those on the line [rad]."""
FINER = (1, 2, 4, 8, 16)
"""How many times closer than usual configurations on a line are set, one after the other."""
_BEND = 0.1
"""Where the joints' direction turns by more than this [rad], lines meet at a corner."""


Ball = tuple[Array, float]
"""A centre in world, shape (3,), and a radius [m]."""


def keeps_to_lines(
    chain: Chain, positions: Array, ends: Sequence[tuple[pin.SE3, pin.SE3]], balls: Sequence[Ball] = ()
) -> bool:
    """Tell whether a motion through the rows, shape (k, n), stays on straight lines; half-way between rows too.

    Args:
        ends: poses of the grasp frame in world where each line begins and ends.
        balls: places where it needn't: centre in world, shape (3,), and radius [m].
    """
    between = (positions[1:] + positions[:-1]) / 2
    poses = [chain.grasp_pose(q) for q in np.concatenate([positions, between])]
    places = np.stack([pose.translation for pose in poses])
    rotations = np.stack([pose.rotation for pose in poses])
    good = np.zeros(len(poses), dtype=bool)
    for centre, radius in balls:
        good |= np.linalg.norm(places - centre, axis=1) <= radius
    for begin, end in ends:
        offsets, way = places - begin.translation, end.translation - begin.translation
        parts = np.clip(offsets @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
        off = np.linalg.norm(offsets - np.outer(parts, way), axis=1)
        axis = pin.log3(begin.rotation.T @ end.rotation)
        axis = axis / max(float(np.linalg.norm(axis)), 1e-6)
        turns = Rotation.from_matrix(begin.rotation.T @ rotations).as_rotvec()
        aside = np.linalg.norm(turns - np.outer(turns @ axis, axis), axis=1)
        good |= (off <= OFF) & (aside <= TURNED)
    return bool(good.all())


def plan_straight(model: RobotModel, request: PlanStraight) -> Trajectory:
    """Plan straight lines of the grasp frame; it comes to rest where they meet at a corner.

    Raises:
        NoIkError: part of a line is out of reach; `data['fraction']` tells how far one gets.
        PathInvalidError: a joint would jump, or something would be touched; `data['pairs']` names what.
    """
    situation = request.situation
    chain, checker = chain_and_checker(model, situation)
    start, lines = drawn_in(chain, situation), list[Path]()
    for k, pose in enumerate(request.poses):
        begin = lines[-1][-1] if lines else start
        lines.append(straight_path(chain, begin, pose, f"line {k + 1} of {len(request.poses)}"))
    refuse_collisions(checker, interpolated(np.concatenate([lines[0], *(line[1:] for line in lines[1:])]), RESOLUTION))
    pieces, first = [], 0
    for k in range(1, len(lines) + 1):
        if k == len(lines) or _meet_at_a_corner(lines[k - 1], lines[k]):
            pieces.append(_followed(chain, checker, lines[first:k], situation.settings))
            first = k
    return joined(pieces)


def finer_and_finer(attempt: Callable[[int], T | None]) -> T:
    """Return the first motion that stays on its lines.

    Args:
        attempt: makes one whose configurations are so many times closer than usual; None where it is off its lines.

    Raises:
        PathInvalidError: the finest one is off them still.
    """
    for finer in FINER:
        found = attempt(finer)
        if found is not None:
            return found
    raise PathInvalidError(
        f"the straight motion can't be followed within {OFF * 1e3:g} mm of its line: the arm is near a singularity"
    )


def _followed(chain: Chain, checker: CollisionChecker, lines: list[Path], settings: PlanningSettings) -> Trajectory:
    """Time lines from rest to rest that lead on from one another."""
    ends = [ends_of(chain, line) for line in lines]

    def attempt(finer: int) -> Trajectory | None:
        rows = [lines[0][:1], *(closer(chain, line, finer)[1:] for line in lines)]
        trajectory = timed_free(checker, np.concatenate(rows), settings)
        return trajectory if keeps_to_lines(chain, trajectory.positions, ends) else None

    return finer_and_finer(attempt)


def ends_of(chain: Chain, path: Path) -> tuple[pin.SE3, pin.SE3]:
    """Return the poses of the grasp frame where a path, shape (k, n), begins and ends."""
    return chain.grasp_pose(path[0]), chain.grasp_pose(path[-1])


def _meet_at_a_corner(one: Path, other: Path) -> bool:
    before, after = one[-1] - one[-2], other[1] - other[0]
    lengths = float(np.linalg.norm(before) * np.linalg.norm(after))
    return lengths < 1e-12 or float(before @ after) < np.cos(_BEND) * lengths
