"""Fake joints, which are where trajectories lead as soon as they are told to, and a hand of such joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from grip_bt.base.arrays import Array, Mask
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
        self._position, self.joint_names = np.array(start.position), start.names
        self.executed: list[Trajectory] = []

    def state(self) -> JointState:
        return JointState(self.joint_names, self._position, np.zeros(len(self.joint_names)))

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        if trajectory.names != self.joint_names:
            raise ValueError(f"the trajectory moves {trajectory.names}, this executor {self.joint_names}")
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
        self._position = same_joints(position, self.joint_names)


class FakeHand:
    """Implements `ports.HandPort` and `ports.Touch`.

    Args:
        start: where the fingers are at first.
        thing: what is between the fingers: joint positions that they don't get past when closing, or None.
        forces: link -> force [N] while the fingers press on the thing.
        closed: where the joints are when the hand is closed, `start` being where it is open; when None, larger is more
            closed.
        executor: makes what moves the joints, of where they are at first.

    Attributes:
        slipping: how fast the thing slides along the links that touch it [m/s].
    """

    def __init__(
        self,
        start: JointState,
        thing: JointState | None = None,
        forces: Mapping[str, float] | None = None,
        closed: JointState | None = None,
        executor: Callable[[JointState], FakeExecutor] = FakeExecutor,
    ):
        closing = np.ones(len(start.names)) if closed is None else closed.ordered(start.names) - start.position
        self._flexes, self._extends = closing > 0, closing < 0
        self.joint_names = start.names
        self._joints = executor(start)
        self._forces = dict(forces or {"fingertip": 5.0})
        self.torque_limits: list[float | None] = []
        self.forces: list[float | None] = []
        self.thing = thing
        self.slipping = 0.0

    def state(self) -> JointState:
        now, effort = self._joints.state(), 0.5 * self._pressing().astype(float)
        return JointState(self.joint_names, self._blocked(now.position), np.zeros(len(effort)), effort, now.time)

    def move(
        self, posture: JointState, duration: float, torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        start, goal = self._blocked(self.kept()), posture.ordered(self.joint_names)
        self._joints.put_back(start)
        self.torque_limits.append(torque_limit)
        self.forces.append(force)
        if duration <= 0:
            self._joints.put_back(goal)
        times, rows = (np.array([0.0, duration]), [start, goal]) if duration > 0 else (np.zeros(1), [goal])
        # The goal is kept even where the thing is in the way: that is what presses.
        moved = self._joints.execute(Trajectory(self.joint_names, times, np.stack(rows)))
        return moved.then(lambda _: Operation.finished(self.state()))

    def contacts(self) -> Mapping[str, float]:
        if not self._pressing().any():
            return {}
        asked = self.forces[-1] if self.forces else None
        return dict(self._forces if asked is None else dict.fromkeys(self._forces, asked))

    def slips(self) -> Mapping[str, float]:
        return dict.fromkeys(self.contacts(), self.slipping) if self.slipping else {}

    def stop(self) -> None:
        self._joints.stop()

    def kept(self) -> Array:
        """Return where its fingers are or, where a thing is in the way, would be [rad], shape (n,)."""
        return self._joints.state().position

    def put_back(self, position: Array) -> None:
        """Have the fingers where they were, as `kept` returned it; nothing may be under way.

        Raises:
            ValueError: it has another number of joints.
        """
        self._joints.put_back(position)

    def _blocked(self, position: Array) -> Array:
        if self.thing is None:
            return position
        wall = self.thing.ordered(self.joint_names)
        past = (self._flexes & (position > wall)) | (self._extends & (position < wall))
        return np.where(past, wall, position)

    def _pressing(self) -> Mask:
        free = self.kept()
        return np.abs(self._blocked(free) - free) > 1e-6
