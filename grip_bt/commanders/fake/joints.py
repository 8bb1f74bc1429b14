"""Joints that move by themselves as trajectories say, on a schedule, and fail as a script says."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain, repeat
from typing import Protocol

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import CanceledError, ExecutionAbortedError, ExpectedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory

from ..joined import same_joints
from ..steering import spliced
from ..trajectory.stopping import accelerations_of, jerks_of, stop_ramp

Script = Iterable[ExpectedError | None]


def steps_of(script: Script) -> Iterator[ExpectedError | None]:
    """Return the script's entries, and None for ever after."""
    return chain(script, repeat(None))


class MovableClock(Protocol):
    """A clock that tells when it was moved, such as `runtime.clock.ManualClock`."""

    def now(self) -> float:
        """Return the time [s]."""

    def on_advance(self, listener: Callable[[], None]) -> None:
        """Call `listener()` after each move."""


class Schedule(Protocol):
    """A fake's time."""

    def now(self) -> float:
        """Return the time [s]."""

    def stamp(self) -> float:
        """Return the stamp of what is measured now [s]; 0 where nobody else's time goes like this."""

    def after(self, delay: float, action: Callable[[], None]) -> None:
        """Call `action()` when `delay` [s] has passed."""


class AtOnce:
    """Time that passes when somebody waits for it: whatever takes time has taken it at once."""

    def __init__(self) -> None:
        self._time = 0.0

    def now(self) -> float:
        return self._time

    def stamp(self) -> float:
        return 0.0

    def after(self, delay: float, action: Callable[[], None]) -> None:
        self._time += delay
        action()


class OnClock:
    """Time of a clock that somebody moves; what has come due happens in order, within the move.

    Args:
        clock: the clock.
    """

    def __init__(self, clock: MovableClock):
        self._clock = clock
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        clock.on_advance(self._run)

    def now(self) -> float:
        return self._clock.now()

    def stamp(self) -> float:
        return self._clock.now()

    def after(self, delay: float, action: Callable[[], None]) -> None:
        self._count += 1
        heapq.heappush(self._due, (self._clock.now() + delay, self._count, action))

    def _run(self) -> None:
        # A hair of tolerance: sums of clock steps aren't exact.
        while self._due and self._due[0][0] <= self._clock.now() + 1e-9:
            heapq.heappop(self._due)[2]()


START_TOLERANCE = 0.05
"""A trajectory begins within this distance of where the joints are [rad]."""


@dataclass
class _Motion:
    trajectory: Trajectory
    begin: float
    operation: Operation[JointState]
    failure: Exception | None = None
    braking: bool = False

    @property
    def end(self) -> float:
        return self.trajectory.duration / (2 if self.failure and not self.braking else 1)


class FakeExecutor:
    """Implements `ports.Executor` and `ports.Steerable`.

    Args:
        start: where the joints are at first.
        schedule: its time; at once when None.
        script: what becomes of each motion: None reaches its end, an error ends it half-way.
        accelerations: joint -> limit, for braking; see `trajectory.stopping.accelerations_of`.
        jerks: joint -> limit, likewise; any where it names none.
    """

    steerable = True

    def __init__(
        self,
        start: JointState,
        schedule: Schedule | None = None,
        script: Script = (),
        accelerations: Mapping[str, float] | None = None,
        jerks: Mapping[str, float] | None = None,
    ):
        self._schedule = schedule or AtOnce()
        self._limits = accelerations_of(start.names, accelerations or {}), jerks_of(start.names, jerks or {})
        self._position, self._names = np.array(start.position), start.names
        self._motion: _Motion | None = None
        self._script = steps_of(script)
        self.executed: list[Trajectory] = []

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self._names

    def state(self) -> JointState:
        position, velocity = self._position, np.zeros(len(self._names))
        if self._motion is not None:
            (position,), (velocity,), _ = self._motion.trajectory.sampled(np.array([self._progress(self._motion)]))
        return JointState(self._names, position, velocity, time=self._schedule.stamp())

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        if trajectory.names != self._names:
            raise ValueError(f"the trajectory moves {trajectory.names}, this executor {self._names}")
        self.end_at(self.state().position)
        off = float(np.abs(trajectory.positions[0] - self._position).max())
        if off > START_TOLERANCE:
            return Operation.failed(
                ExecutionAbortedError(f"the trajectory begins {off:.3f} rad away from the joints", error=off)
            )
        self.executed.append(trajectory)
        operation: Operation[JointState] = Operation(on_cancel=lambda: self._brake(motion))
        self._motion = motion = _Motion(trajectory, self._schedule.now(), operation, next(self._script))
        self._finish_after(motion)
        return operation

    execute_steered = execute

    def stop(self) -> None:
        if self._motion is not None:
            self._brake(self._motion)

    def end_at(self, position: Array) -> None:
        """End a motion under way as cancelled, and have the joints at a position [rad], shape (n,)."""
        motion, self._motion, self._position = self._motion, None, position
        if motion is not None:
            motion.operation.fail(CanceledError("replaced by another motion"))

    def put_back(self, position: Array) -> None:
        """Have the joints where they were; nothing may be under way.

        Args:
            position: of its joints [rad], shape (n,).

        Raises:
            ValueError: it has another number of joints.
        """
        self._position = same_joints(position, self._names)

    def _progress(self, motion: _Motion) -> float:
        return self._schedule.now() - motion.begin

    def passed(self) -> float | None:
        motion = self._motion
        return None if motion is None or motion.braking else self._progress(motion)

    def amend(self, tail: Trajectory, at: float) -> bool:
        motion = self._motion
        if motion is None or motion.braking or self._progress(motion) > min(at, motion.end) + 1e-9:
            return False
        motion.trajectory = spliced(motion.trajectory, tail, at)
        self.executed.append(tail)
        return True

    def _finish_after(self, motion: _Motion) -> None:
        """Finish when the motion has come to its end, however much later that is by then."""

        def look() -> None:
            if self._progress(motion) < motion.end - 1e-9:
                self._finish_after(motion)
            else:
                self._finish(motion)

        self._schedule.after(max(0.0, motion.end - self._progress(motion)), look)

    def _brake(self, motion: _Motion) -> None:
        if self._motion is motion and not motion.braking:
            ramp = stop_ramp(motion.trajectory, self._progress(motion), *self._limits)
            motion.trajectory, motion.begin, motion.braking = ramp, self._schedule.now(), True
            self._finish_after(motion)

    def _finish(self, motion: _Motion) -> None:
        if self._motion is not motion:
            return
        error = CanceledError("the motion was stopped") if motion.braking else motion.failure
        self._position = self.state().position if error is not None else np.array(motion.trajectory.positions[-1])
        self._motion = None
        if error is not None:
            motion.operation.fail(error)
        else:
            motion.operation.succeed(self.state())
