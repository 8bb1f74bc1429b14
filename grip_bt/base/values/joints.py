"""Joint states, trajectories and plans. Angles in rad, lengths in m, times in s."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from grip_bt.base.arrays import Array, ComparesArrays, Indices


@dataclass(frozen=True, slots=True, eq=False)
class JointState(ComparesArrays):
    """Positions of named joints, and velocities and efforts where they are known.

    Attributes:
        names: n joint names.
        position: shape (n,) [rad or m].
        velocity: shape (n,) [rad/s or m/s], or None.
        effort: shape (n,) [N m or N], or None.
        time: when it was measured, on the run's clock [s].
    """

    names: tuple[str, ...]
    position: Array
    velocity: Array | None = None
    effort: Array | None = None
    time: float = 0.0

    if TYPE_CHECKING:  # what the constructor takes is wider than what it keeps

        def __init__(
            self,
            names: Iterable[str],
            position: ArrayLike,
            velocity: ArrayLike | None = None,
            effort: ArrayLike | None = None,
            time: float = 0.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        self._freeze((len(self.names),), "position", "velocity", "effort")

    @classmethod
    def from_mapping(cls, positions: Mapping[str, float], time: float = 0.0) -> JointState:
        """Make a state from `{joint: position}`."""
        return cls(tuple(positions), np.array(list(positions.values()), dtype=float), time=time)

    def as_mapping(self) -> dict[str, float]:
        """Return `{joint: position}`."""
        return dict(zip(self.names, map(float, self.position), strict=True))

    def ordered(self, names: tuple[str, ...]) -> Array:
        """Return the positions of `names`, shape (len(names),); KeyError where a joint isn't in this state."""
        mine = self.as_mapping()
        return np.array([mine[n] for n in names])


MOVE_GROUP = "move_group"
"""The planner of plans that MoveIt's move_group made."""


@dataclass(frozen=True, slots=True)
class Closing:
    """What a hand did when it last closed.

    Attributes:
        reached: what was measured when the fingers had stopped.
    """

    goal: JointState
    reached: JointState


class ContactPoint(NamedTuple):
    """Where a link of a hand presses on something.

    Attributes:
        link: of the hand.
        other: name of what it presses on.
        position: in world [m].
        force: on what it presses on, along the surface's normal, in world [N].
    """

    link: str
    other: str
    position: tuple[float, float, float]
    force: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Span(ComparesArrays):
    """What lies between a hand's thumb and the fingers that oppose it, in one posture; between a gripper's two fingers.

    Attributes:
        gap: free width between the tips, negative where they overlap [m].
        middle: between the tips, in the grasp frame, shape (3,) [m].
        axis: from the thumb's tip to the fingers', a unit vector in the grasp frame, shape (3,).
        depth: how far what is as wide as the gap reaches in between the fingers, beyond `middle` [m].
        corners: points whose hull holds the hand, in the grasp frame, shape (k, 3) [m].
        squeezing: what the joints aim at to press along `axis` as hard as they can on what is as wide as the gap, the
            thumb as hard as all others together.
    """

    posture: JointState
    gap: float
    middle: Array
    axis: Array
    depth: float
    corners: Array
    squeezing: JointState

    def __post_init__(self) -> None:
        self._freeze((3,), "middle", "axis")
        self._freeze((len(self.corners), 3), "corners")

    @property
    def inward(self) -> Array:
        """At right angles to `axis`, out of the palm towards the tips, as nearly along z as can be, shape (3,)."""
        inward = np.array([0.0, 0.0, 1.0]) - self.axis[2] * self.axis
        return np.asarray(inward / np.linalg.norm(inward))


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory(ComparesArrays):
    """A timed path of named joints.

    Attributes:
        names: n joint names.
        times: shape (k,), increasing, the first is 0 [s].
        positions: shape (k, n).
        velocities: shape (k, n), or None.
        accelerations: shape (k, n), or None.
    """

    names: tuple[str, ...]
    times: Array
    positions: Array
    velocities: Array | None = None
    accelerations: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        self._freeze((None,), "times")
        self._freeze((len(self.times), len(self.names)), "positions", "velocities", "accelerations")
        if not len(self.times) or self.times[0] != 0 or np.any(np.diff(self.times) <= 0):
            raise ValueError("times of a trajectory start at 0 and increase")

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return float(self.times[-1])

    def at(self, time: float) -> Array:
        """Return the positions at `time` [s], shape (n,), as `sampled` interpolates."""
        return self.sampled(np.array([time]))[0][0]

    def sampled(self, times: Array) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations at times, each of shape (m, n).

        Between two points as ros2_control's joint_trajectory_controller draws them: a quintic where accelerations are
        given, a cubic where velocities are, else a straight line. Before the first point and after the last one the
        joints stand.

        Args:
            times: shape (m,) [s].
        """
        if len(self.times) == 1:
            still = np.zeros((len(times), len(self.names)))
            return np.repeat(self.positions, len(times), axis=0), still, still
        row = np.minimum(np.maximum(self.times.searchsorted(times, side="right") - 1, 0), len(self.times) - 2)
        begin = self.times[row]
        span = (self.times[row + 1] - begin)[:, None]
        part = (np.minimum(np.maximum(times, 0.0), self.times[-1]) - begin)[:, None] / span
        found = _between(self, row, span, part)
        outside = (times < 0.0) | (times > self.times[-1])
        if outside.any():
            found[1][outside] = found[2][outside] = 0.0
        return found

    def of(self, names: Sequence[str]) -> Trajectory:
        """Return the motion of some of its joints, in their order."""
        columns = [self.names.index(name) for name in names]
        velocities = None if self.velocities is None else self.velocities[:, columns]
        accelerations = None if self.accelerations is None else self.accelerations[:, columns]
        return Trajectory(tuple(names), self.times, self.positions[:, columns], velocities, accelerations)

    def stretched(self, duration: float) -> Trajectory:
        """Return the same path, slowed down to last `duration` [s]; itself when it lasts that long already."""
        factor = duration / self.duration if self.duration > 0 else 1.0
        if factor <= 1.0:
            return self
        velocities = None if self.velocities is None else self.velocities / factor
        accelerations = None if self.accelerations is None else self.accelerations / factor**2
        return Trajectory(self.names, self.times * factor, self.positions, velocities, accelerations)

    def end(self) -> JointState:
        """Return the last point as a state."""
        return JointState(self.names, self.positions[-1], time=self.duration)


def _between(trajectory: Trajectory, row: Indices, span: Array, part: Array) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations a part (m, 1) of the way from points `row` to the next ones."""
    p0, way = trajectory.positions[row], trajectory.positions[row + 1] - trajectory.positions[row]
    if trajectory.velocities is None:
        factors = [p0, way]
    else:
        v0, v1 = trajectory.velocities[row] * span, trajectory.velocities[row + 1] * span
        if trajectory.accelerations is None:
            factors = [p0, v0, 3 * way - 2 * v0 - v1, v0 + v1 - 2 * way]
        else:
            a0, a1 = trajectory.accelerations[row] * span**2, trajectory.accelerations[row + 1] * span**2
            factors = [
                p0,
                v0,
                a0 / 2,
                10 * way - 6 * v0 - 4 * v1 - (3 * a0 - a1) / 2,
                -15 * way + 8 * v0 + 7 * v1 + (3 * a0 - 2 * a1) / 2,
                6 * way - 3 * (v0 + v1) - (a0 - a1) / 2,
            ]
    position, velocity, curving = factors[-1], np.zeros_like(p0), np.zeros_like(p0)
    for factor in factors[-2::-1]:  # Horner's scheme for the polynomial and its derivatives
        curving = curving * part + velocity
        velocity = velocity * part + position
        position = position * part + factor
    return position, velocity / span, 2 * curving / span**2


@dataclass(frozen=True, slots=True, eq=False)
class Plan(ComparesArrays):
    """A motion that was planned and timed for one group.

    Attributes:
        planning_time: wall time spent [s].
        radii: of a motion through way points, the blend radius at each inner one [m], as it fitted; 0: the arm rests.
    """

    group: str
    trajectory: Trajectory
    planner: str = ""
    planning_time: float = 0.0
    radii: tuple[float, ...] = ()
