"""A hand of several joints behind the port `HandPort`, over any executor of its joints."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from grip_bt.base.failures import CanceledError, ExecutionAbortedError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor
from grip_bt.base.values import JointState
from grip_bt.commanders.trajectory.splines import eased, slowed

STOPPED_SHORT = 0.05
"""A joint that stays so far from where it was sent [rad] was stopped by something."""
SHORT = {"controller_code", "stopped_short"}
"""What the data of an aborted motion has one of, when the joints have moved towards its end."""
UNKNOWN_FORCE = 1.0
"""Force of a contact where efforts aren't measured [N]: that there is one, not how strong."""


class ControlledHand:
    """Implements `grip_bt.base.ports.HandPort`.

    Without tactile sensors, what stops a joint short of its goal is a contact; its force is the joint's effort, where
    that is measured.

    Args:
        executor: moves the hand's joints. One that aborts because a finger was stopped has still moved.
        accelerations: joint -> limit, kept to by moving for longer [rad/s^2 or m/s^2]; any, for those it doesn't name.
    """

    def __init__(self, executor: Executor, accelerations: Mapping[str, float] | None = None):
        self._executor = executor
        known = accelerations or {}
        self._hardest = np.array([known.get(name, np.inf) for name in executor.joint_names])
        self._goal: JointState | None = None

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of the hand."""
        return self._executor.joint_names

    def state(self) -> JointState:
        """Return the measured state, with efforts where they are published."""
        return self._executor.state()

    def move(self, posture: JointState, duration: float, torque_limit: float | None = None) -> Operation[JointState]:
        """Move the fingers towards a posture; see `grip_bt.base.ports.HandPort`.

        A torque limit can't be given to a position controller: set it in the controller.
        """
        names = self.joint_names
        start, goal = self.state().ordered(names), posture.ordered(names)
        self._goal = JointState(names, goal)
        moving = self._executor.execute(
            slowed(eased(names, start, goal, duration), np.full(len(names), np.inf), self._hardest)
        )
        whole: Operation[JointState] = Operation(on_cancel=moving.cancel)

        def end() -> None:
            try:
                whole.succeed(moving.result())
            except ExecutionAbortedError as error:
                if SHORT & set(error.data):  # stopped short by contact is what closing is for
                    whole.succeed(self.state())
                else:
                    whole.fail(error)
            except CanceledError as error:
                whole.fail(error)

        moving.add_done_callback(end)
        return whole

    def contacts(self) -> Mapping[str, float]:
        """Return the joints that something has stopped short of the last posture, and their efforts."""
        if self._goal is None:
            return {}
        state = self.state()
        short = np.abs(self._goal.ordered(state.names) - state.position) > STOPPED_SHORT
        efforts = np.full(len(state.names), UNKNOWN_FORCE) if state.effort is None else np.abs(state.effort)
        return {name: float(e) for name, e, s in zip(state.names, efforts, short, strict=True) if s}

    def stop(self) -> None:
        """Hold the fingers where they are."""
        self._executor.stop()
