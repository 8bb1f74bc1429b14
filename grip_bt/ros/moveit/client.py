"""What move_group serves: plans, kinematics, its scene, execution. Each call is answered, or fails by a name."""

from __future__ import annotations

from typing import Any

from grip_bt.base.failures import (
    BadReplyError,
    CanceledError,
    ExpectedError,
    GoalRejectedError,
    PlannerLostError,
    ServerLostError,
    ServerTimeOutError,
)
from grip_bt.base.operation import Operation

from ..bus import Bus
from ..definitions import provide
from ..goal import GoalEnd
from ..types import load_type
from .codes import SUCCESS, failure

ANSWER = 10.0
"""How long move_group may take beyond the time that it was given [s]: to simplify a path, to time it, to answer."""
_ALLOWED_COLLISIONS = 128


class MoveGroup:
    """The services and actions of one move_group.

    Args:
        bus: the connection to ROS.
        namespace: of its node; empty for the root, else such as `/left`.
        wait: how long a call waits for it to appear [s].

    Attributes:
        name: of its node, for messages.

    Raises:
        MissingPartError: MoveIt's messages aren't installed, and can't be built.
    """

    def __init__(self, bus: Bus, namespace: str = "", wait: float = 10.0):
        provide("moveit_msgs")
        self.name = f"{namespace}/move_group"
        self._bus, self._namespace, self._wait = bus, namespace, wait
        self._scene = self._service("ApplyPlanningScene", "apply_planning_scene")
        self._plan = bus.action(load_type("moveit_msgs/action/MoveGroup"), f"{namespace}/move_action", wait=wait)

    @property
    def scene_server(self) -> frozenset[bytes]:
        """Who answered last when a scene was sent; another value after move_group was started anew."""
        servers: frozenset[bytes] = self._scene.servers
        return servers

    def plan(self, request: Any, timeout: float) -> Operation[Any]:
        """Plan without executing; the result is the `MoveGroup` action's, and cancelling it stops the search.

        Args:
            request: a `MotionPlanRequest`.
            timeout: what it was given [s]; a move_group that takes much longer is taken for lost.
        """
        goal = load_type("moveit_msgs/action/MoveGroup").Goal(request=request)
        goal.planning_options.plan_only = True
        goal.planning_options.planning_scene_diff.is_diff = True
        goal.planning_options.planning_scene_diff.robot_state.is_diff = True
        sent = self._plan.send(goal, timeout=timeout + ANSWER, moves=False)
        return self._named(sent, "planning", _ended)

    def plan_by_service(self, request: Any, timeout: float) -> Operation[Any]:
        """Plan by the service `plan_kinematic_path`, which can't be cancelled; the result is its response."""
        type_ = load_type("moveit_msgs/srv/GetMotionPlan")
        client = self._bus.service(type_, f"{self._namespace}/plan_kinematic_path", ANSWER, self._wait)
        asked = client.call(type_.Request(motion_plan_request=request), timeout=timeout + ANSWER)
        return self._named(asked, "planning", lambda answer: answer.motion_plan_response)

    def cartesian(self, request: Any) -> Operation[Any]:
        """Plan straight lines; the result is the response, whose `fraction` may be less than 1."""
        client = self._service("GetCartesianPath", "compute_cartesian_path")
        return self._named(client.call(request), "planning of a straight line", lambda answer: answer)

    def inverse(self, request: Any) -> Operation[Any]:
        """Look for joint positions that reach a pose; the result is the `RobotState`.

        Args:
            request: a `PositionIKRequest`.
        """
        client = self._service("GetPositionIK", "compute_ik")
        asked = client.call(client.type.Request(ik_request=request))
        return self._named(asked, "inverse kinematics", lambda answer: answer).then(
            lambda answer: Operation.finished(answer.solution)
        )

    def apply(self, scene: Any) -> Operation[Any]:
        """Apply a `PlanningScene`, or a difference; the result is the response."""
        return self._named(self._scene.call(self._scene.type.Request(scene=scene)), "the scene", lambda answer: answer)

    def allowed_collisions(self) -> Operation[Any]:
        """Return the matrix of allowed collisions as it is now."""
        client = self._service("GetPlanningScene", "get_planning_scene")
        request = client.type.Request()
        request.components.components = _ALLOWED_COLLISIONS
        return self._named(client.call(request), "the scene", lambda answer: answer).then(
            lambda answer: Operation.finished(answer.scene.allowed_collision_matrix)
        )

    def _service(self, type_: str, name: str) -> Any:
        cls = load_type(f"moveit_msgs/srv/{type_}")
        return self._bus.service(cls, f"{self._namespace}/{name}", ANSWER, self._wait)

    def _named(self, asked: Operation[Any], what: str, part: Any) -> Operation[Any]:
        """End as `asked` does, with what MoveIt's error code means, and with PlannerLostError when nobody answers."""
        whole: Operation[Any] = Operation(on_cancel=asked.cancel)
        where = f"{self.name}: {what}"

        def end() -> None:
            try:
                answer = part(asked.result())
            except CanceledError as error:
                whole.fail(error)
            except (ServerLostError, ServerTimeOutError) as error:
                whole.fail(PlannerLostError(f"{where}: {error.message}", cause=error.code))
            except GoalRejectedError as error:
                whole.fail(GoalRejectedError(f"{where}: it doesn't take requests now; {error.message}"))
            except ExpectedError as error:
                whole.fail(error)
            else:
                code = getattr(answer, "error_code", None)
                wrong = None if code is None else failure(code, where)
                if wrong is None:
                    whole.succeed(answer)
                else:
                    whole.fail(wrong)

        asked.add_done_callback(end)
        return whole


def _ended(end: GoalEnd) -> Any:
    """Return the result of a goal; one that was cancelled, or aborted without a reason, has none to speak of.

    Raises:
        CanceledError: it was cancelled.
        BadReplyError: it says both that it ended and that it didn't.
    """
    if end.status == "canceled":
        raise CanceledError("planning was cancelled")
    if end.status == "aborted" and int(end.result.error_code.val) == SUCCESS:
        raise BadReplyError("move_group gave the goal up, and says that it succeeded")
    return end.result
