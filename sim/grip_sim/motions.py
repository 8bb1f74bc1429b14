"""What the physics is advanced for: motions of joints, and waiting. Each is asked before every step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from grip_bt.base.arrays import Array, Indices
from grip_bt.base.values import Trajectory
from grip_bt.commanders.trajectory.stopping import even_ramp, jerks_of, stop_ramp
from grip_sim.robot import SimRobot
from grip_sim.world import World

START_TOLERANCE, END_TOLERANCE = 0.05, 0.02
"""Largest error of a joint at the start and at the end of a trajectory [rad]."""
GRACE = 1.0
"""How long a motion may take to come to rest after its time [s]."""
STILL = 0.05
"""Joints slower than this stand still [rad/s]."""
STILL_TIME = 0.1
"""Fingers have come to rest when they stood still for this long [s]."""
NEARLY = 0.1
"""A hand presses as it is to when it does but for this part of the force."""
AHEAD = 256
"""Steps for which a path is sampled at once."""
LOOK, LONGEST, MOVED = 0.25, 10.0, 5e-4
"""Objects lie still when two looks, so far apart [s], differ by less [m]; longer than that isn't waited [s]."""
_PAST = 0.1
"""What was followed longer ago is forgotten when a motion is amended [s]."""


@dataclass(frozen=True)
class Ended:
    """How a motion has ended: empty, `aborted` or `canceled`, why, and whether the joints were measured at rest."""

    error: str = ""
    message: str = ""
    stopped: bool = True


class Motion(Protocol):
    """Something under way in the simulator."""

    rows: Indices

    def advance(self, world: World) -> Ended | None:
        """Set the drives for the next step, or return how it has ended."""

    def braking(self, world: World) -> Motion:
        """Return what brings its joints to rest; itself where it does that, or moves none."""


class Brake:
    """Joints come to rest by a ramp, and then hold where they are measured, as joint_trajectory_controller has it.

    A drive that brakes is some mrad ahead of its target: drawn back, the joints would creep for another 0.1 s.

    Args:
        rows: which joints, n of them.
        begun: simulated time now [s].
    """

    def __init__(self, robot: SimRobot, rows: Indices, ramp: Trajectory, begun: float):
        self.rows, self._robot, self._ramp, self._begun = rows, robot, ramp, begun
        self._hold: Array | None = None

    def advance(self, world: World) -> Ended | None:
        t = world.time - self._begun + world.spec.dt
        position, velocity, _ = self._ramp.sampled(np.array([t]))
        if t <= self._ramp.duration:
            self._robot.drive(self.rows, position[0], velocity[0])
            return None
        if self._hold is None:  # what stood still, such as a finger that presses, keeps its target
            moved = self._ramp.sampled(np.zeros(1))[1][0] != 0.0
            self._hold = np.where(moved, self._robot.positions()[self.rows], position[0])
        self._robot.drive(self.rows, self._hold)
        speeds = np.abs(self._robot.velocities()[self.rows])
        if speeds.max() < STILL:
            return Ended("canceled", "the motion was stopped")
        if t > self._ramp.duration + GRACE:
            joint, fast = self._ramp.names[int(speeds.argmax())], speeds.max()
            message = f"the motion was cancelled, but {joint} still moves at {fast:.2f} rad/s {GRACE:g} s after braking"
            return Ended("canceled", message, stopped=False)
        return None

    def braking(self, world: World) -> Motion:
        return self


class Follow:
    """Joints follow a timed path, interpolated as `Trajectory.sampled` does.

    Args:
        rows: which joints.
        path: of these joints, in this order.
        begun: simulated time now [s].
    """

    def __init__(self, robot: SimRobot, rows: Indices, path: Trajectory, begun: float):
        self.rows, self._robot, self._path, self._begun = rows, robot, path, begun
        self._joints, self._since = rows.tolist(), 0.0
        """When `_path` begins, on the time of the motion [s]: what was followed long ago is forgotten."""
        self._ahead: dict[float, tuple[list[float], list[float], float]] = {}
        """Targets for the next steps, and how long after its time they are [s]."""

    def passed(self, time: float) -> float:
        """Return for how long it has been followed at a simulated time [s]."""
        return time - self._begun

    def amend(self, time: float, at: float, times: Array, positions: Array, velocities: Array) -> bool:
        """Go on with another path from a moment of this one on; False when that is over.

        Raises:
            ValueError: it begins elsewhere than this one is then.
        """
        path, since = self._path, self._since
        if self.passed(time) > at or at > since + path.duration + 1e-6:
            return False
        off = np.abs(path.at(at - since) - positions[0]).max()
        if off > 1e-3:
            raise ValueError(f"the new tail starts {off:.4f} rad away from the motion")
        if path.velocities is None:  # its speed jumps at its points: nothing goes on smoothly from there
            return False
        old = path.times + since
        kept = (old < at - 1e-6) & (old > self.passed(time) - _PAST)
        whole = np.concatenate([old[kept], at + times])
        self._since, self._ahead = float(whole[0]), {}
        told, speeds = (path.positions[kept], positions), (path.velocities[kept], velocities)
        self._path = Trajectory(path.names, whole - self._since, np.concatenate(told), np.concatenate(speeds))
        return True

    def wrong_start(self) -> str:
        """Return why the motion can't start here, or an empty string."""
        error = np.abs(self._robot.positions()[self.rows] - self._path.positions[0])
        if error.max() <= START_TOLERANCE:
            return ""
        joint = self._path.names[int(error.argmax())]
        return f"{joint} is {error.max():.3f} rad away from the start of the trajectory"

    def advance(self, world: World) -> Ended | None:
        """Aim at where the path is one step from now; after its time, wait for the joints to arrive."""
        if world.steps not in self._ahead:  # many at once: that takes hardly longer than one
            steps: Array = np.arange(world.steps, world.steps + AHEAD, dtype=float)
            at = steps * world.spec.dt - self._begun + world.spec.dt - self._since
            positions, velocities, _ = self._path.sampled(at)
            ahead = zip(positions.tolist(), velocities.tolist(), (at - self._path.duration).tolist(), strict=True)
            self._ahead = dict(zip(steps.tolist(), ahead, strict=True))
        position, velocity, late = self._ahead[world.steps]
        self._robot.aim(self._joints, position, velocity)
        if late <= 0:
            return None
        error = np.abs(self._robot.positions()[self.rows] - self._path.positions[-1])
        slow = np.abs(self._robot.velocities()[self.rows]).max() < STILL
        if error.max() < END_TOLERANCE and slow:
            return Ended()
        if late > GRACE:
            joint = self._path.names[int(error.argmax())]
            state = "still moves and is" if error.max() < END_TOLERANCE else "is still"
            return Ended("aborted", f"{joint} {state} {error.max():.3f} rad away from the end of the trajectory")
        return None

    def braking(self, world: World) -> Motion:
        """Brake along the path; joints that something keeps off it brake from where they are."""
        passed = self.passed(world.time) - self._since
        measured = self._robot.measure(self.rows)
        limits = self._robot.accelerations(self.rows), jerks_of(measured.names, world.spec.jerks)
        if np.abs(measured.position - self._path.at(passed)).max() > START_TOLERANCE:
            ramp = even_ramp(measured.names, measured.position, measured.velocity, *limits)
        else:
            ramp = stop_ramp(self._path, passed, *limits)
        return Brake(self._robot, self.rows, ramp, world.time)


class MoveHand:
    """Fingers go towards a posture, as far as what they meet lets them.

    Args:
        rows: which joints, n of them.
        goal: shape (n,) [rad].
        duration: how long the targets take to get there [s].
        begun: simulated time now [s].
        force: with which they press then [N]; None for as hard as the drives do.
    """

    def __init__(
        self, robot: SimRobot, rows: Indices, goal: Array, duration: float, begun: float, force: float | None = None
    ):
        self.rows, self._robot, self._force = rows, robot, force
        start: Array = robot.targets(rows)
        self._ways = list(zip(rows.tolist(), start.tolist(), (goal - start).tolist(), strict=True))
        self._duration, self._begun = duration, begun
        self._still_since: float | None = None

    def advance(self, world: World) -> Ended | None:
        t = world.time - self._begun + world.spec.dt
        part = min(1.0, t / self._duration)
        for row, start, way in self._ways:
            self._robot.aim([row], [start + way * part], [0.0])
        if t <= self._duration:
            return None
        if np.abs(self._robot.velocities()[self.rows]).max() > STILL or not self._presses_as_told(world):
            self._still_since = None
        elif self._still_since is None:
            self._still_since = world.time
        still = 0.0 if self._still_since is None else world.time - self._still_since
        return Ended() if still > STILL_TIME or t > self._duration + GRACE else None

    def _presses_as_told(self, world: World) -> bool:
        pressed = world.pressed(self._robot.hand_of(int(self.rows[0]))) if self._force else 0.0
        return not self._force or not pressed or abs(pressed - self._force) < NEARLY * self._force

    def braking(self, world: World) -> Motion:
        """Brake evenly from where the fingers are, behind their targets; what stands still goes on pressing."""
        measured = self._robot.measure(self.rows)
        still = np.abs(measured.velocity) < STILL
        position = np.where(still, self._robot.targets(self.rows), measured.position)
        velocity = np.where(still, 0.0, measured.velocity)
        ramp = even_ramp(measured.names, position, velocity, self._robot.accelerations(self.rows))
        return Brake(self._robot, self.rows, ramp, world.time)


class Wait:
    """Time passes."""

    rows: Indices = np.array([], dtype=np.intp)

    def __init__(self, until: float, end: Ended | None = None):
        self._until, self._end = until, end or Ended()

    def advance(self, world: World) -> Ended | None:
        return self._end if world.time >= self._until else None

    def braking(self, world: World) -> Motion:
        return Wait(world.time, Ended("canceled", "the wait was cancelled"))


class ComeToRest(Wait):
    """Time passes, `LONGEST` at most, until no object moves any more; what is round may roll for seconds."""

    def __init__(self, begun: float):
        super().__init__(begun + LONGEST)
        self._next, self._seen = begun + LOOK, np.zeros(0)

    def advance(self, world: World) -> Ended | None:
        if world.time < self._next:
            return None
        before, self._seen = self._seen, world.kept()["poses"]
        self._next += LOOK
        if self._seen.shape == before.shape and np.abs(self._seen - before).max(initial=0.0) < MOVED:
            return Ended()
        return super().advance(world)
