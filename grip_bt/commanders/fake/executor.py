"""A fake executor: joints that follow a trajectory exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grip_bt.errors import CanceledError, ExecutionAbortedError
from grip_bt.operation import Operation
from grip_bt.values import JointState, Trajectory

from ..joint_names import same_joints
from ..steering import spliced
from .schedule import AtOnce, Schedule, Script, steps_of

START_TOLERANCE = 0.05
"""A trajectory begins within this distance of where the joints are [rad]."""


@dataclass
class _Motion:
    trajectory: Trajectory
    begin: float
    operation: Operation[JointState]
    failure: Exception | None = None
    stood_at: float | None = None
    due: bool = False

    @property
    def end(self) -> float:
        return self.trajectory.duration / (2 if self.failure else 1)


class FakeExecutor:
    """Implements `ports.Executor`, `ports.Pausable` and `ports.Steerable`.

    Args:
        start: where the joints are at first.
        schedule: its time; at once when None.
        script: what becomes of each motion: None reaches its end, an error ends it half-way.
    """

    def __init__(self, start: JointState, schedule: Schedule | None = None, script: Script = ()):
        self._schedule = schedule or AtOnce()
        self._position, self._names = np.array(start.position), start.names
        self._motion: _Motion | None = None
        self._paused = False
        self._script = steps_of(script)
        self.executed: list[Trajectory] = []

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints that it moves."""
        return self._names

    def state(self) -> JointState:
        """Return where the joints are now."""
        position = self._position
        if self._motion is not None:
            position = self._motion.trajectory.at(self._progress(self._motion))
        return JointState(self._names, position, np.zeros(len(position)), time=self._schedule.now())

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        """Follow a trajectory; one under way ends as cancelled. See `ports.Executor`.

        Raises:
            ValueError: it names other joints.
        """
        if trajectory.names != self._names:
            raise ValueError(f"the trajectory moves {trajectory.names}, this executor {self._names}")
        self.stop()
        off = float(np.abs(trajectory.positions[0] - self._position).max())
        if off > START_TOLERANCE:
            return Operation.failed(
                ExecutionAbortedError(f"the trajectory begins {off:.3f} rad away from the joints", error=off)
            )
        self.executed.append(trajectory)
        operation: Operation[JointState] = Operation(on_cancel=lambda: self._cancel(operation))
        self._motion = motion = _Motion(trajectory, self._schedule.now(), operation, next(self._script))
        if self._paused:
            motion.stood_at = 0.0
        self._finish_after(motion)
        return operation

    def stop(self) -> None:
        """Hold where the joints are now and end a motion under way as cancelled."""
        motion = self._hold()
        if motion is not None:
            motion.operation.fail(CanceledError("the motion was stopped"))

    def put_back(self, position: NDArray[np.float64]) -> None:
        """Have the joints where they were; nothing may be under way.

        Args:
            position: of its joints [rad], shape (n,).

        Raises:
            ValueError: it has another number of joints.
        """
        self._position = same_joints(position, self._names)

    def pause(self) -> None:
        """Hold where the joints are in the middle of a motion; see `ports.Pausable`."""
        self._paused = True
        if self._motion is not None and self._motion.stood_at is None:
            self._motion.stood_at = self._progress(self._motion)

    def resume(self) -> None:
        """Go on with what is left."""
        self._paused = False
        motion = self._motion
        if motion is not None and motion.stood_at is not None:
            motion.begin, motion.stood_at = self._schedule.now() - motion.stood_at, None
            if motion.due:
                motion.due = False
                self._finish_after(motion)

    def _progress(self, motion: _Motion) -> float:
        return self._schedule.now() - motion.begin if motion.stood_at is None else motion.stood_at

    def passed(self) -> float | None:
        """Return for how long the motion under way has been followed [s]; see `ports.Steerable`."""
        return None if self._motion is None else self._progress(self._motion)

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`."""
        motion = self._motion
        if motion is None or self._progress(motion) > min(at, motion.end) + 1e-9:
            return False
        motion.trajectory = spliced(motion.trajectory, tail, at)
        self.executed.append(tail)
        return True

    def expect(self, at: float | None) -> None:
        """Do nothing: its time is that of who asks."""

    def _finish_after(self, motion: _Motion) -> None:
        """Finish when the motion has come to its end, however long it was held and gone on with in between."""

        def look() -> None:
            if motion.stood_at is not None:
                motion.due = True
            elif self._progress(motion) < motion.end - 1e-9:
                self._finish_after(motion)
            else:
                self._finish(motion)

        self._schedule.after(max(0.0, motion.end - self._progress(motion)), look)

    def _cancel(self, operation: Operation[JointState]) -> None:
        if self._motion is not None and self._motion.operation is operation:
            self.stop()

    def _hold(self) -> _Motion | None:
        self._position = np.array(self.state().position)
        motion, self._motion = self._motion, None
        return motion

    def _finish(self, motion: _Motion) -> None:
        if self._motion is not motion:
            return
        self._hold()
        if motion.failure is None:
            self._position = np.array(motion.trajectory.positions[-1])
            motion.operation.succeed(self.state())
        else:
            motion.operation.fail(motion.failure)
