"""Straight motions of the grasp frame: chains of nearby solutions of the inverse kinematics."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array, Path
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import check_frame

from ..ik.damped_least_squares import solve_from
from ..ik.target import Target
from ..model import Chain

STEP = 0.015
"""Distance of the grasp frame between two solutions [m]."""
TURN = 0.08
"""Angle of the grasp frame between two solutions [rad]."""
JUMP = 0.35
"""A joint that moves more than this [rad] between two solutions has jumped to another branch."""


class BrokenLineError(ValueError):
    """A straight motion can't be followed all the way.

    Attributes:
        fraction: the part that can, in [0, 1).
        jump: whether a joint jumps there; otherwise the pose is out of reach.
    """

    def __init__(self, fraction: float, jump: bool):
        self.fraction, self.jump = fraction, jump
        super().__init__(f"{'a joint jumps' if jump else 'out of reach'} after {fraction:.0%} of the line")


def world_pose(pose: Pose) -> pin.SE3:
    """Return a pose of the grasp frame as the chains have it.

    Raises:
        ValueError: it isn't given in world.
    """
    check_frame(pose, "world")
    return pin.SE3(pose.matrix())


def straight_path(chain: Chain, start: Array, goal: pin.SE3) -> Path:
    """Return configurations, shape (k, n), that move the grasp frame on a straight line from where `start` puts it.

    The position moves on a line, the orientation about one axis, both evenly.

    Raises:
        BrokenLineError: part of the line is out of reach, or a joint jumps.
    """
    begin = chain.grasp_pose(start)
    turn = pin.log3(begin.rotation.T @ goal.rotation)
    way = goal.translation - begin.translation
    steps = max(1, int(np.ceil(max(np.linalg.norm(way) / STEP, np.linalg.norm(turn) / TURN))))
    rows = [start]
    for k in range(1, steps + 1):
        part = k / steps
        pose = pin.SE3(begin.rotation @ pin.exp3(turn * part), begin.translation + way * part)
        q = solve_from(chain, Target(pose), rows[-1], iterations=30)
        if q is None or np.abs(q - rows[-1]).max() > JUMP:
            raise BrokenLineError((k - 1) / steps, jump=q is not None)
        rows.append(q)
    return np.stack(rows)


def closer(chain: Chain, path: Path, times: int) -> Path:
    """Return a straight path, shape (k, n), with `times` as many steps; the rows that it has stay."""
    rows = [path[0]]
    for one, other in zip(path[:-1], path[1:], strict=True):
        begin, end = chain.grasp_pose(one), chain.grasp_pose(other)
        turn, way = pin.log3(begin.rotation.T @ end.rotation), end.translation - begin.translation
        for k in range(1, times):
            pose = pin.SE3(begin.rotation @ pin.exp3(turn * k / times), begin.translation + way * k / times)
            guess = one + (other - one) * k / times
            q = solve_from(chain, Target(pose), guess, iterations=30)
            rows.append(guess if q is None else q)
        rows.append(other)
    return np.stack(rows)
