"""What joints may do: their limits all along a trajectory, and when they count as at rest."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import OutOfLimitsError
from grip_bt.base.values import JointState, Trajectory

ROUNDED = 1e-3
"""Limits may be exceeded by this part, those of positions by this much [rad or m]: numbers in files are rounded."""
_PERIOD, _MOST = 1e-3, 100_000
"""Trajectories are checked at this interval [s], at no more times than that, and on both sides of each point."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a group's joints, each of shape (n,).

    Attributes:
        lower: [rad].
        upper: [rad].
        velocity: [rad/s].
        acceleration: [rad/s^2].
        jerk: [rad/s^3], infinite where none is known; None: of no joint.
    """

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array | None = None


def refuse_beyond_limits(trajectory: Trajectory, limits: Limits) -> None:
    """Look at positions, velocities and accelerations all along, and whether it begins and ends at rest.

    Args:
        trajectory: as `Trajectory.sampled` interpolates.

    Raises:
        OutOfLimitsError: it breaks one; `data` has the `joints`, the `time` [s], the `value` and the `limit`.
    """
    if len(trajectory.times) > 1 and trajectory.velocities is None:
        words = "has points without velocities, where speeds would jump; have `plan_from_trajectory` make a plan of it"
        raise OutOfLimitsError(f"the trajectory {words}", joints=trajectory.names)
    times, position, velocity, acceleration = _all_along(trajectory)
    fastest, hardest, still = limits.velocity, limits.acceleration, np.full(len(trajectory.names), STILL)
    slower = "; give its points {:g} times as long (`slow_down: true` of arm/execute_trajectory does that)"
    ends, rest = trajectory.times[[0, -1]], "; it has to begin and end at rest"
    for what, at, found, low, high, unit, remedy in (
        ("position", times, position, limits.lower, limits.upper, 1.0, ""),
        ("velocity", times, velocity, -fastest, fastest, fastest, slower),
        ("acceleration", times, acceleration, -hardest, hardest, hardest, slower),
        ("velocity", ends, trajectory.sampled(ends)[1], -still, still, STILL, rest),
    ):
        over = np.maximum(low - found, found - high) / unit
        row, joint = np.unravel_index(int(over.argmax()), over.shape)
        if not over[row, joint] <= ROUNDED:  # what isn't a number isn't either
            name, value = trajectory.names[joint], float(found[row, joint])
            if remedy == slower:
                remedy = slower.format(np.ceil(longer(trajectory, fastest, hardest) * 1000) / 1000)
            raise OutOfLimitsError(
                f"{at[row]:.2f} s into the trajectory, it is out of limits: {what} of {name} = {value:.3f} "
                f"(allowed {low[joint]:.3f} .. {high[joint]:.3f}){remedy}",
                joints=(name,),
                time=float(at[row]),
                value=value,
                limit=float(high[joint] if value > high[joint] else low[joint]),
            )


def longer(trajectory: Trajectory, velocity: Array, acceleration: Array) -> float:
    """Return how many times as long a trajectory has to last to keep to limits of its joints, each shape (n,)."""
    _, _, fastest, hardest = _all_along(trajectory)
    return float(max((np.abs(fastest) / velocity).max(), np.sqrt((np.abs(hardest) / acceleration).max())))


def _all_along(trajectory: Trajectory) -> tuple[Array, Array, Array, Array]:
    """Return times, shape (m,), and positions, velocities and accelerations then, each shape (m, n)."""
    points, step = trajectory.times, max(_PERIOD, trajectory.duration / _MOST)
    times = np.concatenate([np.arange(0.0, trajectory.duration, step), points, points[1:] - 1e-9])
    return times, *trajectory.sampled(times)


STILL = 0.01
"""Joints slower than this are at rest [rad/s or m/s], as for joint_trajectory_controller."""
OVER = 0.1
"""For this long, by the stamps of what is measured [s]."""
TOLD = 0.05
"""Velocities that are published are noisy: only larger ones tell that a joint moves [rad/s or m/s]."""


class RestDetector:
    """Judges measurements one after the other.

    Attributes:
        moving: which joint moves, and how fast [rad/s or m/s], by the last measurement; empty before the second one.
    """

    def __init__(self) -> None:
        self._seen: deque[JointState] = deque()
        self.moving = ""

    def see(self, state: JointState) -> bool:
        """Tell whether joints have been at rest for `OVER` until a measurement; one that isn't newer tells nothing."""
        if self._seen and state.time <= self._seen[-1].time:
            return False
        self._seen.append(state)
        while len(self._seen) > 2 and state.time - self._seen[1].time >= OVER:
            self._seen.popleft()
        passed = state.time - self._seen[0].time
        if passed < OVER:
            return False
        positions = np.stack([one.position for one in self._seen])
        speeds = np.ptp(positions, axis=0) / passed
        if state.velocity is not None:
            speeds = np.maximum(speeds, np.where(np.abs(state.velocity) > TOLD, np.abs(state.velocity), 0.0))
        worst = int(speeds.argmax())
        self.moving = f"{state.names[worst]} at {speeds[worst]:.3f} a second"
        return bool(speeds[worst] <= STILL)
