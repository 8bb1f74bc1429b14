"""A joint trajectory controller behind the port `Executor`: the action FollowJointTrajectory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from ..convert_geometry import trajectory_to_message
from ..interfaces.build import provide
from .following import Following
from .joint_states import JointStates
from .motion import RosExecutor

ACTION = "control_msgs/action/FollowJointTrajectory"
LATE = 60.0
"""How long a controller may take beyond the duration of a trajectory [s]."""


class TrajectoryExecutor(RosExecutor):
    """Implements `grip_bt.base.ports.Executor` and `Steerable` over a joint trajectory controller.

    Args:
        bus: the connection to ROS.
        action: the controller's action, such as `/arm_controller/follow_joint_trajectory`.
        names: the joints that it moves.
        states: where they are measured.
        goal_time: how late the joints may reach the goal [s]; 0 for the controller's own setting.
        wait: how long to wait for the controller to appear [s].
    """

    steerable = True

    def __init__(
        self,
        bus: Bus,
        action: str,
        names: Sequence[str],
        states: JointStates,
        goal_time: float = 0.0,
        wait: float = 5.0,
    ):
        super().__init__(names, states)
        provide("control_msgs")
        self._type = load_type(ACTION)
        self._client, self._wait = bus.action(self._type, action), wait
        self._action, self._goal_time = action, goal_time
        self._following: Following | None = None
        self._fixed = False

    def passed(self) -> float | None:
        """Return for how long the motion under way has been followed [s]; see `ports.Steerable`.

        None, too, for a controller that once refused a goal while it followed another one.
        """
        return None if self._following is None or not self._replaces() else self._following.passed()

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`."""
        return self._following is not None and self._replaces() and self._following.amend(tail, at)

    def _replaces(self) -> bool:
        following = self._following
        self._fixed = self._fixed or (following is not None and not following.replaceable)
        return not self._fixed

    def _begin(self, trajectory: Trajectory) -> Operation[GoalEnd]:
        self._replaces()
        self._following = Following(self._sent, trajectory)
        self._following.begin()
        return self._following.whole

    def _sent(self, trajectory: Trajectory, ahead: float, accepted: Callable[[], None]) -> Operation[GoalEnd]:
        goal = self._type.Goal(trajectory=trajectory_to_message(trajectory, ahead))
        goal.goal_time_tolerance.sec = int(self._goal_time)
        goal.goal_time_tolerance.nanosec = round(self._goal_time % 1 * 1e9)
        sent = self._client.send(goal, ahead + trajectory.duration + LATE, self._wait, on_accepted=accepted)
        return as_motion(sent, self._action, self._type.Result)


def follow_goal(sent: Operation[GoalEnd], judge: Callable[[GoalEnd, bool], GoalEnd]) -> Operation[GoalEnd]:
    """Return a goal's end as that of a motion: a server that is lost, late or refuses it has aborted the execution.

    Args:
        sent: the goal.
        judge: returns an end that counts as success, given whether it was to be cancelled, and raises for others.
    """
    operation: Operation[GoalEnd] = Operation(on_cancel=sent.cancel)

    def end() -> None:
        try:
            operation.succeed(judge(sent.result(), operation.cancel_asked))
        except (ServerLostError, ServerTimeOutError, GoalRejectedError) as error:
            operation.fail(ExecutionAbortedError(error.message, cause=error.code, **error.data))
        except ExpectedError as error:
            operation.fail(error)

    sent.add_done_callback(end)
    return operation


def as_motion(sent: Operation[GoalEnd], server: str, result: Any) -> Operation[GoalEnd]:
    """Return a controller's goal as a motion: all but success and cancelling is an aborted execution.

    A motion that was cancelled, and then given up, is a cancelled one: a newer goal has overtaken the request to
    cancel, and the controller gave this one up for it.

    Args:
        sent: the goal.
        server: name of its action.
        result: class of its result, whose constants name the error codes.
    """
    name = _names_of(result)

    def judge(ended: GoalEnd, cancel_asked: bool) -> GoalEnd:
        if ended.status == "canceled" or (cancel_asked and ended.status == "aborted"):
            raise CanceledError("the motion was stopped")
        code = int(getattr(ended.result, "error_code", 0))
        if ended.status == "succeeded" and code == 0:
            return ended
        said = getattr(ended.result, "error_string", "")
        reason = f"{server}: the controller aborted the motion: {name(code)}{f' ({said})' if said else ''}"
        raise ExecutionAbortedError(reason, controller_code=code, controller_says=said)

    return follow_goal(sent, judge)


def _names_of(result: Any) -> Callable[[int], str]:
    """Return what names the codes that a result class has as constants."""
    constants = {
        getattr(result, n): n.lower() for n in dir(type(result)) if n.isupper() and isinstance(getattr(result, n), int)
    }
    return lambda code: constants.get(code, f"code {code}")
