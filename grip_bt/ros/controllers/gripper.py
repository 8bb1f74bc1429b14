"""A parallel gripper behind the port `HandPort`: the action GripperCommand."""

from __future__ import annotations

from collections.abc import Mapping

from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState

from ..bus import Bus
from ..definitions import provide
from ..goal import GoalEnd
from ..types import load_type
from .joint_states import JointStates
from .motion import measured
from .rest import Motion
from .trajectory import LATE, as_motion

ACTION = "control_msgs/action/GripperCommand"
UNKNOWN_FORCE = 1.0
"""Force of a contact where the gripper tells none [N]: that there is one, not how strong."""
GAVE_WAY = 2e-3
"""Fingers that have moved further than this since something stopped them [m or rad] don't touch it any more."""


class GripperHand:
    """Implements `grip_bt.base.ports.HandPort`.

    Args:
        bus: the connection to ROS.
        action: the gripper's action, such as `/gripper_controller/gripper_cmd`.
        joint: the joint that it moves.
        states: where that is measured.
        wait: how long to wait for the gripper to appear [s].
    """

    def __init__(self, bus: Bus, action: str, joint: str, states: JointStates, wait: float = 5.0):
        provide("control_msgs")
        self._type = load_type(ACTION)
        self._client = bus.action(self._type, action, wait=wait)
        self._action, self._joint, self._states = action, joint, states
        self._motion: Motion | None = None
        self._force, self._stopped_at = 0.0, 0.0

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The one joint."""
        return (self._joint,)

    def state(self) -> JointState:
        """Return the measured state.

        Raises:
            SensorError: nothing is known of the joint.
        """
        return self._states.state(self.joint_names)

    def move(self, posture: JointState, duration: float, torque_limit: float | None = None) -> Operation[JointState]:
        """Move to a posture with at most `torque_limit` [N or N m, as the gripper has it].

        The gripper decides how long that takes. It ends also when something stops the fingers. Cancelled or given up,
        it ends when they were measured at rest; see `RosExecutor.execute`.
        """
        if self._motion is not None:
            self._motion.overtake()
        goal = self._type.Goal()
        (goal.command.position,) = map(float, posture.ordered(self.joint_names))
        goal.command.max_effort = float(torque_limit or 0.0)
        self._force = 0.0
        sent = self._client.send(goal, timeout=duration + LATE)
        part = as_motion(self._stalls_are_ends(sent), self._action, self._type.Result).then(self._ended)
        self._motion = Motion(part, self._states, self.joint_names)
        return self._motion.whole

    def contacts(self) -> Mapping[str, float]:
        """Return the gripper's effort when something has stopped its fingers, and they are still there."""
        if not self._force or abs(self.state().position[0] - self._stopped_at) > GAVE_WAY:
            return {}
        return {self._joint: self._force}

    def stop(self) -> None:
        """Bring the fingers to rest; a motion under way ends as cancelled when they are measured to be there."""
        if self._motion is not None:
            self._motion.whole.cancel()

    def _stalls_are_ends(self, sent: Operation[GoalEnd]) -> Operation[GoalEnd]:
        """Take a goal that was given up because the fingers were stopped for one that is over."""

        def judge(ended: GoalEnd) -> Operation[GoalEnd]:
            stalled = ended.status == "aborted" and ended.result.stalled
            return Operation.finished(GoalEnd("succeeded", ended.result) if stalled else ended)

        return sent.then(judge)

    def _ended(self, ended: GoalEnd) -> Operation[JointState]:
        result = ended.result
        force = abs(result.effort) or UNKNOWN_FORCE if result.stalled and not result.reached_goal else 0.0

        def note(state: JointState) -> Operation[JointState]:
            self._force, self._stopped_at = force, float(state.position[0])
            return Operation.finished(state)

        return measured(self._states, self.joint_names).then(note)
