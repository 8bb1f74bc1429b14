"""Steering: motions without an end that is known beforehand, made of steps that each could be the last.

A step goes on with the velocity of the one before, follows for `HOLD` the velocity that is wanted, and then comes to
rest. The next step goes on where the coming to rest would begin, once it is known to be free; where it isn't, or is
too late, the joints come to rest on what was checked before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from grip_bt.values import Trajectory

HOLD = 0.2
"""How long a step holds what is wanted [s]; its successor is planned meanwhile."""
SAMPLING = 0.02
"""Time between two points of a step [s]."""

Velocity = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Joint positions -> the joint velocities that are wanted there, each shape (n,)."""


def steered(
    names: Sequence[str],
    position: NDArray[np.float64],
    velocity: NDArray[np.float64],
    wanted: Velocity,
    acceleration: NDArray[np.float64],
    hold: float = HOLD,
) -> Trajectory:
    """Return a step: from a position and a velocity on, towards the wanted velocities, then to rest.

    Args:
        names: n joints.
        position: shape (n,) [rad].
        velocity: shape (n,) [rad/s].
        wanted: what velocities are wanted, within the joints' limits.
        acceleration: limits that are kept on the way, shape (n,) [rad/s^2].
        hold: for how long the wanted velocities are followed [s], rounded to `SAMPLING`.
    """
    q, v = np.array(position, dtype=float), np.array(velocity, dtype=float)
    rows, speeds = [q], [v]
    for _ in range(round(hold / SAMPLING)):
        change = wanted(q) - v
        most = float((np.abs(change) / acceleration).max()) / SAMPLING
        faster = v + change / max(1.0, most)
        q = q + (v + faster) * (SAMPLING / 2)
        v = faster
        rows.append(q)
        speeds.append(v)
    times: NDArray[np.float64] = np.arange(len(rows), dtype=np.float64) * np.float64(SAMPLING)
    if v.any():
        braking = max(SAMPLING, float((np.abs(v) / acceleration).max()))
        rest = np.linspace(0.0, braking, int(np.ceil(braking / SAMPLING)) + 1)[1:]
        rows.extend(q + np.outer(rest - rest**2 / (2 * braking), v))
        speeds.extend(np.outer(1.0 - rest / braking, v))
        times = np.concatenate([times, times[-1] + rest])
    return Trajectory(tuple(names), times, np.stack(rows), np.stack(speeds))


def spliced(before: Trajectory, after: Trajectory, at: float) -> Trajectory:
    """Return the first trajectory until `at` [s], and the other one from there on.

    Raises:
        ValueError: the other one moves other joints, or begins elsewhere than the first one is at that moment.
    """
    if before.names != after.names:
        raise ValueError(f"{after.names} can't go on with a motion of {before.names}")
    off = float(np.abs(before.at(at) - after.positions[0]).max())
    if off > 1e-3:
        raise ValueError(f"what goes on begins {off:.4f} rad away from where the motion is then")
    kept = before.times < at - 1e-6
    both = before.velocities is not None and after.velocities is not None
    return Trajectory(
        before.names,
        np.concatenate([before.times[kept], at + after.times]),
        np.concatenate([before.positions[kept], after.positions]),
        np.concatenate([before.velocities[kept], after.velocities]) if both else None,  # type: ignore[index]
    )
