"""Joints that are where trajectories lead as soon as they are told to, and fail as a script says."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain, repeat

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import ExecutionAbortedError, ExpectedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory

from ..joined import same_joints

Script = Iterable[ExpectedError | None]
START_TOLERANCE = 0.05
"""A trajectory begins within this distance of where the joints are [rad]."""


def steps_of(script: Script) -> Iterator[ExpectedError | None]:
    """Return the script's entries, and None for ever after."""
    return chain(script, repeat(None))


class FakeExecutor:
    """Implements `ports.Executor` and `ports.Steerable`; its motions have ended when they have begun.

    Args:
        start: where the joints are at first.
        script: what becomes of each motion: None reaches its end, an error ends it half-way.
    """

    steerable = True

    def __init__(self, start: JointState, script: Script = ()):
        self._position, self._names = np.array(start.position), start.names
        self._script = steps_of(script)
        self.executed: list[Trajectory] = []

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self._names

    def state(self) -> JointState:
        return JointState(self._names, self._position, np.zeros(len(self._names)))

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        if trajectory.names != self._names:
            raise ValueError(f"the trajectory moves {trajectory.names}, this executor {self._names}")
        off = float(np.abs(trajectory.positions[0] - self._position).max())
        if off > START_TOLERANCE:
            return Operation.failed(
                ExecutionAbortedError(f"the trajectory begins {off:.3f} rad away from the joints", error=off)
            )
        self.executed.append(trajectory)
        return self._move(trajectory, next(self._script))

    execute_steered = execute

    def _move(self, trajectory: Trajectory, failure: ExpectedError | None) -> Operation[JointState]:
        if failure is None:
            self._position = np.array(trajectory.positions[-1])
            return Operation.finished(self.state())
        (self._position,), *_ = trajectory.sampled(np.array([trajectory.duration / 2]))
        return Operation.failed(failure)

    def stop(self) -> None:
        """Nothing moves."""

    def passed(self) -> float | None:
        return None

    def amend(self, tail: Trajectory, at: float) -> bool:
        return False

    def put_back(self, position: Array) -> None:
        """Have the joints where they were.

        Args:
            position: of its joints [rad], shape (n,).

        Raises:
            ValueError: it has another number of joints.
        """
        self._position = same_joints(position, self._names)
