"""A joint trajectory controller behind the port `Executor`, and the controller manager of ros2_control."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress

from grip_bt.base.errors import UnknownNameError, listing
from grip_bt.base.failures import (
    CanceledError,
    ExecutionAbortedError,
    ExpectedError,
    GoalRejectedError,
    ServerLostError,
    ServerTimeOutError,
)
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import JointState, Trajectory

from ..client.bus import Bus
from ..client.goal import GoalEnd
from ..client.types import Message, constant_name
from ..convert_values import trajectory_to_message
from ..interfaces.build import ensure_package
from .joint_states import JointStates
from .motion import ActionExecutor
from .streaming import TopicExecutor

LATE = 60.0
"""How long a controller may take beyond the duration of a trajectory [s]."""


class TrajectoryExecutor(ActionExecutor):
    """Implements `grip_bt.base.ports.Executor` and `Steerable` over a joint trajectory controller.

    A steered motion is streamed to the controller's topic `joint_trajectory`, beside the action, as MoveIt Servo does
    it; where nobody subscribes to that, motions can't be changed under way.

    Args:
        accelerations: joint -> limit, for braking a steered motion; see `trajectory.stopping.accelerations_of`.
        jerks: likewise; any where it names none.
    """

    interface = "control_msgs/action/FollowJointTrajectory"

    def __init__(
        self,
        bus: Bus,
        action: str,
        names: Sequence[str],
        states: JointStates,
        accelerations: Mapping[str, float] | None = None,
        jerks: Mapping[str, float] | None = None,
        wait: float = 5.0,
    ):
        super().__init__(bus, action, names, states, wait)
        topic = f"{action.rpartition('/')[0]}/joint_trajectory"
        self._stream = TopicExecutor(bus, topic, names, states, accelerations, jerks)
        self.passed, self.amend = self._stream.passed, self._stream.amend
        self._writer = bus.writer(TopicExecutor.message, topic)
        self._writer.advertise()

    @property
    def steerable(self) -> bool:
        return self._writer.listeners() > 0

    def execute_steered(self, trajectory: Trajectory) -> Operation[JointState]:
        """Stream a motion; a goal under way is cancelled, and over, before. See `ports.Steerable`."""
        return run_steps(self._streamed(trajectory))

    def stop(self) -> None:
        super().stop()
        self._stream.stop()

    def _streamed(self, trajectory: Trajectory) -> Steps[JointState]:
        if self._motion is not None:
            super().stop()
            with suppress(ExpectedError):  # whoever asked for it is told
                yield self._motion.whole
        measured: JointState = yield self._stream.execute(trajectory)
        return measured

    def _begin(self, trajectory: Trajectory) -> Operation[GoalEnd]:
        self._stream.give_way()
        goal = self._type.Goal(trajectory=trajectory_to_message(trajectory))
        return as_motion(self._client.send(goal, trajectory.duration + LATE, self._wait), self._action)


def follow_goal(sent: Operation[GoalEnd], judge: Callable[[GoalEnd, bool], GoalEnd]) -> Operation[GoalEnd]:
    """Return a goal's end as that of a motion: a server that is lost, late or refuses it has aborted the execution.

    Args:
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


def as_motion(sent: Operation[GoalEnd], server: str) -> Operation[GoalEnd]:
    """Return a controller's goal as a motion: all but success and cancelling is an aborted execution.

    A motion that was cancelled, and then given up, is a cancelled one: a newer goal has overtaken the request to
    cancel, and the controller gave this one up for it.
    """

    def judge(ended: GoalEnd, cancel_asked: bool) -> GoalEnd:
        if ended.status == "canceled" or (cancel_asked and ended.status == "aborted"):
            raise CanceledError("the motion was stopped")
        code = int(getattr(ended.result, "error_code", 0))
        if ended.status == "succeeded" and code == 0:
            return ended
        said = getattr(ended.result, "error_string", "")
        name = constant_name(ended.result, code).lower() or f"code {code}"
        reason = f"{server}: the controller aborted the motion: {name}{f' ({said})' if said else ''}"
        raise ExecutionAbortedError(reason, controller_code=code, controller_says=said)

    return follow_goal(sent, judge)


STRICT = 2
ANSWER = 10.0


class SwitchError(ExpectedError):
    """The controller manager didn't switch; `data` tells what was asked."""

    code = "not_switched"


class ControllerManager:
    """Asks a controller manager; `wait`: how long to wait for it to appear [s]."""

    def __init__(self, bus: Bus, name: str = "/controller_manager", wait: float = 5.0):
        ensure_package("controller_manager_msgs")
        self._bus, self._name, self._wait = bus, name, wait

    def states(self) -> dict[str, str]:
        """Return the state (`unconfigured`, `inactive`, `active`, `finalized`) of each loaded controller; it blocks."""
        return {c.name: c.state for c in self._ask("list_controllers", "ListControllers").controller}

    def ensure_active(self, wanted: Collection[str], instead_of: Collection[str] = ()) -> None:
        """Block until the wanted controllers are active, and those of `instead_of` aren't, in one step; for start-up.

        Raises:
            UnknownNameError: one isn't loaded.
            SwitchError: it can't be activated.
            ServerLostError, ServerTimeOutError: the manager isn't there, or doesn't answer.
        """
        states = self.states()
        for name in wanted:
            if name not in states:
                raise UnknownNameError("controller", name, states, self._name)
        start = [name for name in wanted if states[name] != "active"]
        stop = [name for name in instead_of if states.get(name) == "active"]
        if not start and not stop:
            return
        fields = {"activate_controllers": start, "deactivate_controllers": stop}
        answer = self._ask("switch_controller", "SwitchController", **fields, strictness=STRICT, activate_asap=True)
        if not answer.ok:
            asked, said = f"activate {listing(start)}, deactivate {listing(stop)}", getattr(answer, "message", "")
            reason = f"{self._name} didn't {asked}{f': {said}' if said else ''}"
            raise SwitchError(reason, activate=start, deactivate=stop)

    def _ask(self, service: str, type_: str, **fields: object) -> Message:
        interface = f"controller_manager_msgs/srv/{type_}"
        asked = self._bus.call(interface, f"{self._name}/{service}", ANSWER, self._wait, **fields)
        asked.wait()
        return asked.result()
