"""Joints that are where trajectories lead as soon as they are told to."""

from __future__ import annotations

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import ExecutionAbortedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory

from ..joined import same_joints

START_TOLERANCE = 0.05
"""A trajectory begins within this distance of where the joints are [rad]."""


class FakeExecutor:
    """Implements `ports.Executor` and `ports.Steerable`; its motions have ended when they have begun.

    Args:
        start: where the joints are at first.
    """

    steerable = True

    def __init__(self, start: JointState):
        self._position, self._names = np.array(start.position), start.names
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
        return self._move(trajectory)

    execute_steered = execute

    def _move(self, trajectory: Trajectory) -> Operation[JointState]:
        self._position = np.array(trajectory.positions[-1])
        return Operation.finished(self.state())

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
