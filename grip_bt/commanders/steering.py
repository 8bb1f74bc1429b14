"""Jogging: how far a bounded twist brings a grasp frame, and plans that are no quicker than was asked.

A step goes on with the velocity of the one before, follows for `HOLD` the velocity that is wanted, and then comes to
rest; the next one goes on where the coming to rest would begin, once it is known to be free.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose, Trajectory
from grip_bt.base.values.pose import quaternion_about

from .trajectory.splines import s_curve
from .trajectory.stopping import even_ramp

MOST_LINEAR = 0.25
"""The grasp frame is jogged no quicker than this [m/s]: the limit of ISO 10218-1 for manual control."""
MOST_ANGULAR = 1.0
"""Nor does it turn quicker than this [rad/s]."""


def jogged(pose: Pose, linear: Sequence[float], angular: Sequence[float], seconds: float) -> Pose:
    """Return where a twist brings a pose.

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
    spin = Pose(quaternion=quaternion_about(w * seconds))
    turned = Pose.from_matrix(spin.matrix() @ Pose(quaternion=pose.quaternion).matrix())
    return Pose(pose.position + v * seconds, turned.quaternion, pose.frame)


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


HOLD = 0.2
"""How long a step holds what is wanted [s]; its successor is planned meanwhile."""
SAMPLING = 0.02
"""Time between two points of a step [s]."""
_LOOKS = 4

Velocity = Callable[[Array], Array]
"""Joint positions -> the joint velocities that are wanted there, each shape (n,)."""


def steered(
    names: Sequence[str],
    position: Array,
    velocity: Array,
    wanted: Velocity,
    acceleration: Array,
    hold: float = HOLD,
    jerk: Array | None = None,
) -> Trajectory:
    """Return a step: from a position and a velocity on, towards the wanted velocities, then to rest.

    Args:
        position: shape (n,) [rad].
        velocity: shape (n,) [rad/s].
        wanted: what velocities are wanted, within the joints' limits.
        acceleration: limits that are kept on the way, shape (n,) [rad/s^2].
        hold: for how long the wanted velocities are followed [s], rounded to `SAMPLING`.
        jerk: likewise [rad/s^3]; None for any. With it, a step's velocity changes in an S over all of `hold`, towards
            what is wanted at its end: no joint accelerates where one step goes over into the next.
    """
    q, v = np.array(position, dtype=float), np.array(velocity, dtype=float)
    if jerk is None:
        times, rows, speeds = _followed(q, v, wanted, acceleration, hold)
    else:
        times, rows, speeds = _smoothly(q, v, wanted, acceleration, hold, jerk)
    rest = even_ramp(names, rows[-1], speeds[-1], acceleration, jerk)
    return spliced(Trajectory(tuple(names), times, rows, speeds), rest, float(times[-1]))


def _followed(q: Array, v: Array, wanted: Velocity, acceleration: Array, hold: float) -> tuple[Array, Array, Array]:
    rows, speeds = [q], [v]
    for _ in range(round(hold / SAMPLING)):
        change = wanted(q) - v
        most = float((np.abs(change) / acceleration).max()) / SAMPLING
        faster = v + change / max(1.0, most)
        q = q + (v + faster) * (SAMPLING / 2)
        v = faster
        rows.append(q)
        speeds.append(v)
    return np.arange(len(rows), dtype=np.float64) * np.float64(SAMPLING), np.stack(rows), np.stack(speeds)


def _smoothly(
    q: Array, v: Array, wanted: Velocity, acceleration: Array, hold: float, jerk: Array
) -> tuple[Array, Array, Array]:
    count = max(2, round(hold / SAMPLING))
    corner = float(np.clip(np.ceil((acceleration / jerk).max() / SAMPLING), 1, count // 2)) * SAMPLING
    level = count * SAMPLING - corner
    change = np.zeros_like(v)
    for _ in range(_LOOKS):  # where the step ends depends on how fast it is then
        change = wanted(q + (v + change / 2) * count * SAMPLING) - v
        change /= max(1.0, float((np.abs(change) / np.minimum(acceleration, jerk * corner)).max()) / level)
    times: Array = np.arange(count + 1, dtype=np.float64) * np.float64(SAMPLING)
    moved, part, _ = s_curve(times, count * SAMPLING, corner)
    return times, q + np.outer(times, v) + np.outer(moved, change), v + np.outer(part, change)


def spliced(before: Trajectory, after: Trajectory, at: float) -> Trajectory:
    """Return the first trajectory until `at` [s], and the other one from there on.

    Raises:
        ValueError: the other one moves other joints, or begins elsewhere than the first one is at that moment.
    """
    if before.names != after.names:
        raise ValueError(f"{after.names} can't continue with a motion of {before.names}")
    off = float(np.abs(before.at(at) - after.positions[0]).max())
    if off > 1e-3:
        raise ValueError(f"the new tail starts {off:.4f} rad away from the motion")
    kept = before.times < at - 1e-6
    both = before.velocities is not None and after.velocities is not None
    return Trajectory(
        before.names,
        np.concatenate([before.times[kept], at + after.times]),
        np.concatenate([before.positions[kept], after.positions]),
        np.concatenate([before.velocities[kept], after.velocities]) if both else None,  # type: ignore[index]
    )
