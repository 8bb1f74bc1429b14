"""What move_group serves: plans, kinematics, its scene, execution. Each call is answered, or fails by a name.

MoveIt's error codes are the failures that tasks know; each keeps MoveIt's own name, number and words in its data.
"""

from __future__ import annotations

from pathlib import Path

from grip_bt.base import failures
from grip_bt.base.failures import (
    BadReplyError,
    CanceledError,
    ExecutionAbortedError,
    ExpectedError,
    GoalRejectedError,
    NoPlanError,
    PlannerLostError,
    ServerLostError,
    ServerTimeOutError,
)
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import Trajectory
from grip_bt.base.yaml.tree import parse, to_data

from ..client.bus import Bus
from ..client.goal import GoalEnd
from ..client.service import ServiceClient
from ..client.types import Message, constant_name, load_type
from ..controllers.motion import ActionExecutor
from ..controllers.trajectory import LATE, follow_goal
from ..convert_values import trajectory_to_message
from ..interfaces.build import ensure_package

ANSWER = 10.0
"""How long move_group may take beyond the time that it was given [s]: to simplify a path, to time it, to answer."""
_ALLOWED_COLLISIONS = 128


class MoveGroup:
    """The services and actions of one move_group.

    Args:
        namespace: of its node; empty for the root, else such as `/left`.
        wait: how long a call waits for it to appear [s].

    Attributes:
        name: of its node, for messages.

    Raises:
        MissingPartError: MoveIt's messages aren't installed, and can't be built.
    """

    def __init__(self, bus: Bus, namespace: str = "", wait: float = 10.0):
        ensure_package("moveit_msgs")
        self.name = f"{namespace}/move_group"
        self._bus, self._namespace, self._wait = bus, namespace, wait
        self._scene = self._service("ApplyPlanningScene", "apply_planning_scene")
        self._plan = bus.action(load_type("moveit_msgs/action/MoveGroup"), f"{namespace}/move_action")

    @property
    def scene_server(self) -> frozenset[bytes]:
        """Who answered last when a scene was sent; another value after move_group was started anew."""
        return self._scene.servers

    def plan(self, request: Message, timeout: float) -> Operation[Message]:
        """Plan without executing; the result is the `MoveGroup` action's, and cancelling it stops the search.

        Args:
            timeout: what it was given [s]; a move_group that takes much longer is taken for lost.
        """
        goal = load_type("moveit_msgs/action/MoveGroup").Goal(request=request)
        goal.planning_options.plan_only = True
        goal.planning_options.planning_scene_diff.is_diff = True
        goal.planning_options.planning_scene_diff.robot_state.is_diff = True
        sent = self._plan.send(goal, timeout + ANSWER, self._wait, moves=False)
        return self._named(sent.then(_ended), "planning")

    def cartesian(self, request: Message) -> Operation[Message]:
        """Plan straight lines; the result is the response, whose `fraction` may be less than 1."""
        client = self._service("GetCartesianPath", "compute_cartesian_path")
        return self._named(client.call(request, ANSWER, self._wait), "planning of a straight line")

    def inverse(self, request: Message) -> Operation[Message]:
        """Look for joint positions that reach a pose; the result is the `RobotState`.

        Args:
            request: a `PositionIKRequest`.
        """
        client = self._service("GetPositionIK", "compute_ik")
        asked = client.call(client.type.Request(ik_request=request), ANSWER, self._wait)
        return self._named(asked, "inverse kinematics").then(lambda answer: Operation.finished(answer.solution))

    def apply(self, scene: Message) -> Operation[Message]:
        """Apply a `PlanningScene`, or a difference; the result is the response."""
        asked = self._scene.call(self._scene.type.Request(scene=scene), ANSWER, self._wait)
        return self._named(asked, "the scene")

    def allowed_collisions(self) -> Operation[Message]:
        """Return the matrix of allowed collisions as it is now."""
        client = self._service("GetPlanningScene", "get_planning_scene")
        request = client.type.Request()
        request.components.components = _ALLOWED_COLLISIONS
        return self._named(client.call(request, ANSWER, self._wait), "the scene").then(
            lambda answer: Operation.finished(answer.scene.allowed_collision_matrix)
        )

    def _service(self, type_: str, name: str) -> ServiceClient:
        cls = load_type(f"moveit_msgs/srv/{type_}")
        return self._bus.service(cls, f"{self._namespace}/{name}")

    def _named(self, asked: Operation[Message], what: str) -> Operation[Message]:
        """End as `asked` does, with what MoveIt's error code means, and with PlannerLostError when nobody answers."""
        where = f"{self.name}: {what}"

        def steps() -> Steps[Message]:
            try:
                answer = yield asked
            except (ServerLostError, ServerTimeOutError) as error:
                raise PlannerLostError(f"{where}: {error.message}", cause=error.code) from None
            except GoalRejectedError as error:
                raise GoalRejectedError(f"{where}: it doesn't take requests now; {error.message}") from None
            code = getattr(answer, "error_code", None)
            wrong = None if code is None else failure(code, where)
            if wrong is not None:
                raise wrong
            return answer

        return run_steps(steps())


def _ended(end: GoalEnd) -> Operation[Message]:
    """Return the result of a goal; one that was cancelled, or aborted without a reason, has none to speak of.

    Raises:
        CanceledError: it was cancelled.
        BadReplyError: it says both that it ended and that it didn't.
    """
    if end.status == "canceled":
        raise CanceledError("planning was cancelled")
    if end.status == "aborted" and int(end.result.error_code.val) == SUCCESS:
        raise BadReplyError("move_group aborted the goal, and says that it succeeded")
    return Operation.finished(end.result)


SUCCESS = 1
FAILURES: dict[str, tuple[type[ExpectedError], str]] = {
    name: (getattr(failures, kind), meaning)
    for kind, meanings in to_data(parse(Path(__file__).with_name("failures.yaml").read_text(encoding="utf-8"))).items()
    for name, meaning in meanings.items()
}


def failure(code: Message, what: str) -> ExpectedError | None:
    """Return the failure that an error code stands for; None for success.

    Args:
        code: a `moveit_msgs/msg/MoveItErrorCodes`; the words that newer releases add are passed on.
        what: what was asked, and of whom; begins the message.
    """
    value = int(code.val)
    if value == SUCCESS:
        return None
    name = constant_name(code, value) or f"CODE_{value}"
    kind, meaning = FAILURES.get(name, (NoPlanError, f"code {value}, which this version doesn't know"))
    said = str(getattr(code, "message", "")).strip()
    words = f"{what}: {meaning}{f' ({said})' if said else ''}"
    return kind(words, moveit=name.lower(), moveit_code=value, moveit_says=said)


class MoveGroupExecutor(ActionExecutor):
    """Implements `grip_bt.base.ports.Executor` over move_group's action ExecuteTrajectory."""

    interface = "moveit_msgs/action/ExecuteTrajectory"

    def _begin(self, trajectory: Trajectory) -> Operation[GoalEnd]:
        goal = self._type.Goal()
        goal.trajectory.joint_trajectory = trajectory_to_message(trajectory)
        sent = self._client.send(goal, trajectory.duration + LATE, self._wait)
        return follow_goal(sent, self._judge)

    def _judge(self, end: GoalEnd, cancel_asked: bool) -> GoalEnd:
        """Take all but success and stopping for an aborted motion, with MoveIt's name of why."""
        wrong = failure(end.result.error_code, f"{self._action}: the motion")
        if end.status == "canceled" or isinstance(wrong, CanceledError):
            raise CanceledError("the motion was stopped")
        if end.status == "succeeded" and wrong is None:
            return end
        if wrong is None:
            raise ExecutionAbortedError(f"{self._action}: move_group aborted the motion without a reason")
        raise ExecutionAbortedError(wrong.message, cause=wrong.code, **wrong.data)
