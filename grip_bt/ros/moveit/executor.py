"""Execution by move_group: it hands a trajectory to the controllers that it knows, several of them where need be."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from grip_bt.base.failures import (
    CanceledError,
    ExecutionAbortedError,
    ExpectedError,
    GoalRejectedError,
    ServerLostError,
    ServerTimeOutError,
)
from grip_bt.base.operation import Operation
from grip_bt.base.values import Trajectory

from ..client.bus import Bus
from ..client.goal import GoalEnd
from ..client.types import load_type
from ..controllers import JointStates, RosExecutor
from ..convert_geometry import trajectory_to_message
from ..interfaces.bundled import provide
from .client import failure

LATE = 60.0
"""How long it may take beyond the duration of a trajectory [s]."""


class MoveGroupExecutor(RosExecutor):
    """Implements `grip_bt.base.ports.Executor` over move_group's action ExecuteTrajectory.

    Args:
        bus: the connection to ROS.
        action: such as `/execute_trajectory`.
        names: the joints that it moves.
        states: where they are measured.
        wait: how long to wait for move_group to appear [s].
    """

    def __init__(self, bus: Bus, action: str, names: Sequence[str], states: JointStates, wait: float = 5.0):
        super().__init__(names, states)
        provide("moveit_msgs")
        self._type = load_type("moveit_msgs/action/ExecuteTrajectory")
        self._client, self._wait = bus.action(self._type, action), wait
        self._action = action

    def _begin(self, trajectory: Trajectory) -> Operation[GoalEnd]:
        goal = self._type.Goal()
        goal.trajectory.joint_trajectory = trajectory_to_message(trajectory)
        sent = self._client.send(goal, trajectory.duration + LATE, self._wait)
        whole: Operation[GoalEnd] = Operation(on_cancel=sent.cancel)
        sent.add_done_callback(lambda: self._ended(sent, whole))
        return whole

    def _ended(self, sent: Operation[GoalEnd], whole: Operation[GoalEnd]) -> None:
        """Judge the end of a goal: all but success and stopping is an aborted motion, with MoveIt's name of why."""
        try:
            end = sent.result()
        except (ServerLostError, ServerTimeOutError, GoalRejectedError) as error:
            whole.fail(ExecutionAbortedError(error.message, cause=error.code, **error.data))
        except ExpectedError as error:
            whole.fail(error)
        else:
            wrong = failure(end.result.error_code, f"{self._action}: the motion")
            if end.status == "canceled" or isinstance(wrong, CanceledError):
                whole.fail(CanceledError("the motion was stopped"))
            elif end.status == "succeeded" and wrong is None:
                whole.succeed(end)
            else:
                whole.fail(_aborted(wrong, self._action))


def _aborted(wrong: ExpectedError | None, action: str) -> ExecutionAbortedError:
    if wrong is None:
        return ExecutionAbortedError(f"{action}: move_group gave the motion up, and doesn't say why")
    data: dict[str, Any] = dict(wrong.data)
    return ExecutionAbortedError(wrong.message, cause=wrong.code, **data)
