"""What the physics is advanced for: motions of joints, and waiting. Each is asked before every step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .robot import SimRobot
from .world import World

Floats = NDArray[np.float64]
START_TOLERANCE, END_TOLERANCE = 0.05, 0.02
"""Largest error of a joint at the start and at the end of a trajectory [rad]."""
GRACE = 1.0
"""How long a motion may take to come to rest after its time [s]."""
STILL = 0.05
"""Joints slower than this stand still [rad/s]."""
_PAST = 0.1
"""What was followed longer ago is forgotten when a motion is amended [s]."""


@dataclass(frozen=True)
class Ended:
    """How a motion has ended: `error` is empty, `aborted` or `canceled`."""

    error: str = ""
    message: str = ""


class Motion(Protocol):
    """Something under way in the simulator."""

    rows: NDArray[np.intp]

    def advance(self, world: World) -> Ended | None:
        """Set the drives for the next step, or return how it has ended."""
        ...


class Follow:
    """Joints follow a timed path; positions and velocities between its points are linear.

    Args:
        robot: whose joints.
        rows: which joints, n of them.
        times: shape (k,), from 0 [s].
        positions: shape (k, n) [rad].
        velocities: shape (k, n) [rad/s], or None for differences of the positions.
        begun: simulated time now [s].
    """

    def __init__(
        self,
        robot: SimRobot,
        rows: NDArray[np.intp],
        times: Floats,
        positions: Floats,
        velocities: Floats | None,
        begun: float,
    ):
        self.rows, self._robot = rows, robot
        if velocities is None:
            velocities = np.gradient(positions, times, axis=0) if len(times) > 1 else np.zeros_like(positions)
        self._times, self._positions, self._velocities = times, positions, velocities
        self._begun = begun
        self.expects: float | None = None

    def passed(self, time: float) -> float:
        """Return for how long it has been followed at a simulated time [s]."""
        return time - self._begun

    def waits(self, world: World) -> bool:
        """Tell whether the next step would go beyond where an amendment is expected."""
        return self.expects is not None and self.passed(world.time) + world.spec.dt > self.expects

    def amend(self, time: float, at: float, times: Floats, positions: Floats, velocities: Floats) -> bool:
        """Go on with another path from a moment of this one on; False when that is over.

        Raises:
            ValueError: it begins elsewhere than this one is then.
        """
        if self.passed(time) > at or at > self._times[-1] + 1e-6:
            return False
        off = np.abs(self._at(at, self._positions) - positions[0]).max()
        if off > 1e-3:
            raise ValueError(f"what goes on begins {off:.4f} rad away from where the motion is then")
        kept = (self._times < at - 1e-6) & (self._times > self.passed(time) - _PAST)
        self._times = np.concatenate([self._times[kept], at + times])
        self._positions = np.concatenate([self._positions[kept], positions])
        self._velocities = np.concatenate([self._velocities[kept], velocities])
        return True

    def wrong_start(self) -> str:
        """Return why the motion can't start here, or an empty string."""
        error = np.abs(self._robot.positions()[self.rows] - self._positions[0])
        if error.max() <= START_TOLERANCE:
            return ""
        joint = self._robot.measure(self.rows).names[int(error.argmax())]
        return f"{joint} is {error.max():.3f} rad away from the start of the trajectory"

    def advance(self, world: World) -> Ended | None:
        """Aim at where the path is one step from now; after its time, wait for the joints to arrive."""
        t = world.time - self._begun + world.spec.dt
        end = float(self._times[-1])
        self._robot.drive(self.rows, self._at(t, self._positions), self._at(t, self._velocities) if t < end else None)
        if t <= end:
            return None
        error = np.abs(self._robot.positions()[self.rows] - self._positions[-1])
        slow = np.abs(self._robot.velocities()[self.rows]).max() < STILL
        if error.max() < END_TOLERANCE and slow:
            return Ended()
        if t > end + GRACE:
            joint = self._robot.measure(self.rows).names[int(error.argmax())]
            state = "still moves and is" if error.max() < END_TOLERANCE else "is still"
            return Ended("aborted", f"{joint} {state} {error.max():.3f} rad away from the end of the trajectory")
        return None

    def _at(self, t: float, columns: Floats) -> Floats:
        return np.array([np.interp(t, self._times, column) for column in columns.T])


class MoveHand:
    """Fingers go towards a posture, as far as what they meet lets them.

    Args:
        robot: whose joints.
        rows: which joints, n of them.
        goal: shape (n,) [rad].
        duration: how long the targets take to get there [s].
        begun: simulated time now [s].
    """

    def __init__(self, robot: SimRobot, rows: NDArray[np.intp], goal: Floats, duration: float, begun: float):
        self.rows, self._robot, self._goal = rows, robot, goal
        self._start = robot.targets(rows)
        self._duration, self._begun = duration, begun
        self._still = 0.0

    def advance(self, world: World) -> Ended | None:
        """Move the targets; the end is when the time is over and the fingers stand still, or the grace is over."""
        t = world.time - self._begun + world.spec.dt
        part = min(1.0, t / self._duration)
        self._robot.drive(self.rows, self._start + (self._goal - self._start) * part)
        if t <= self._duration:
            return None
        moving = np.abs(self._robot.velocities()[self.rows]).max() > STILL
        self._still = 0.0 if moving else self._still + world.spec.dt
        return Ended() if self._still > 0.1 or t > self._duration + GRACE else None


class Wait:
    """Time passes."""

    rows: NDArray[np.intp] = np.array([], dtype=np.intp)

    def __init__(self, until: float):
        self._until = until

    def advance(self, world: World) -> Ended | None:
        """Wait until the simulated time."""
        return Ended() if world.time >= self._until else None
