"""Jogging: how far a bounded twist brings a grasp frame, and plans that are no quicker than was asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Plan, Pose

MOST_LINEAR = 0.25
"""The grasp frame is jogged no quicker than this [m/s]: the limit of ISO 10218-1 for manual control."""
MOST_ANGULAR = 1.0
"""Nor does it turn quicker than this [rad/s]."""


def jogged(pose: Pose, linear: Sequence[float], angular: Sequence[float], seconds: float) -> tuple[Pose, float]:
    """Return where a twist brings a pose, and how long that takes.

    A twist above the bounds is made smaller as a whole, so that its direction and pitch stay.

    Args:
        pose: in world.
        linear: velocity of its origin in world, 3 numbers [m/s].
        angular: angular velocity in world, 3 numbers [rad/s].
        seconds: for how long.

    Raises:
        ValueError: a number isn't finite, or the time isn't positive.
    """
    v, w = bounded(linear, angular)
    if not 0 < seconds < np.inf:
        raise ValueError(f"jogging takes a positive time [s], not {seconds}")
    turn = w * seconds
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0 else np.array([0.0, 0.0, 1.0])
    spin = Pose(quaternion=[np.cos(angle / 2), *(np.sin(angle / 2) * axis)])
    turned = Pose.from_matrix(spin.matrix() @ Pose(quaternion=pose.quaternion).matrix())
    return Pose(pose.position + v * seconds, turned.quaternion, pose.frame), seconds


def bounded(linear: Sequence[float], angular: Sequence[float]) -> tuple[Array, Array]:
    """Return a twist, made smaller as a whole where it is above the bounds.

    Raises:
        ValueError: it isn't twice 3 finite numbers.
    """
    v, w = np.asarray(linear, dtype=float), np.asarray(angular, dtype=float)
    if v.shape != (3,) or w.shape != (3,) or not (np.isfinite(v).all() and np.isfinite(w).all()):
        raise ValueError(f"a twist is 3 + 3 finite numbers, not {list(linear)} and {list(angular)}")
    excess = max(1.0, float(np.linalg.norm(v)) / MOST_LINEAR, float(np.linalg.norm(w)) / MOST_ANGULAR)
    return v / excess, w / excess


def approaching(pose: Pose, target: Pose, speed: float, period: float) -> tuple[list[float], list[float]]:
    """Return a twist towards a target that gets slower near it, so that steps of a period [s] don't go beyond it.

    Args:
        pose: where the grasp frame is, in world.
        target: likewise.
        speed: of the grasp frame's origin at most [m/s].
        period: how long the twist is held [s].
    """
    linear, angular = twist_towards(pose, target, 2.0 * period)
    slower = min(1.0, speed / max(float(np.linalg.norm(linear)), 1e-9))
    return [v * slower for v in linear], [w * slower for w in angular]


def twist_towards(pose: Pose, target: Pose, seconds: float) -> tuple[list[float], list[float]]:
    """Return the twist, linear [m/s] and angular [rad/s] in world, that brings one pose to another in a time [s]."""
    turn = pose.rotation() @ (pose.inverse(pose.frame) @ target).rotation_vector()
    return ((target.position - pose.position) / seconds).tolist(), (turn / seconds).tolist()


def lasting(plan: Plan, seconds: float) -> Plan:
    """Return a plan that takes at least so long [s]."""
    return replace(plan, trajectory=plan.trajectory.stretched(seconds))
