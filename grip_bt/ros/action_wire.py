"""An action as it is on the wire: three services and two topics, https://design.ros2.org/articles/actions.html.

rclpy's own action client makes objects of the status of every goal that the server remembers, three times a goal: with
500 of them, which a server of a hundred goals a second remembers, 8 ms each time, in which nothing else of this process
runs. It gives a handle of a goal only with the server's acceptance, which may be lost, and may be used on the
executor's thread alone. Here the status of a goal is looked up in the serialized list.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from .client import SERVICE_QOS

_FEEDBACK_DEPTH = 10
_FIRST, _NEXT, _STATUS, _EACH = 8, 5, 32, 28
"""Where a list of statuses holds the first goal's id, the others' less their number times `_EACH`, and a status: ids
aren't aligned, seconds are."""


class ActionWire:
    """Sends to and hears of the server of one action; answers are rclpy's futures.

    A future that is cancelled is forgotten, and its answer, if it comes, ignored.

    Args:
        node: the node it lives on.
        type_: the action's class.
        name: the action's full name.
        on_feedback: called on the executor's thread with a goal's id and the feedback message.
        on_status: called on the executor's thread with the serialized statuses of the server's goals; see `status_in`.
    """

    def __init__(
        self,
        node: Any,
        type_: Any,
        name: str,
        on_feedback: Callable[[bytes, Any], None],
        on_status: Callable[[bytes], None],
    ):
        self._type, self._impl = type_, type_.Impl
        self._services = [
            node.create_client(kind, f"{name}/_action/{end}", qos_profile=SERVICE_QOS)
            for kind, end in (
                (self._impl.SendGoalService, "send_goal"),
                (self._impl.GetResultService, "get_result"),
                (CancelGoal, "cancel_goal"),
            )
        ]
        self._goals, self._results, self._cancels = self._services
        self._topics = [f"{name}/_action/feedback", f"{name}/_action/status"]
        self._node = node
        node.create_subscription(
            self._impl.FeedbackMessage,
            self._topics[0],
            lambda message: on_feedback(bytes(message.goal_id.uuid), message.feedback),
            QoSProfile(depth=_FEEDBACK_DEPTH),
        )
        node.create_subscription(
            GoalStatusArray, self._topics[1], on_status, qos_profile_action_status_default, raw=True
        )

    def server_is_ready(self) -> bool:
        """Tell whether there is a server, and all of its services are connected to us."""
        return all(s.service_is_ready() for s in self._services) and all(
            self._node.count_publishers(topic) for topic in self._topics
        )

    def send_goal(self, goal_id: bytes, goal: Any) -> Any:
        """Send a goal under a new id; the answer tells whether it is accepted.

        Raises:
            TypeError: it isn't a goal of this action.
        """
        if not isinstance(goal, self._type.Goal):
            raise TypeError(f"a goal of {self._type.__name__} has to be a {self._type.__name__}.Goal, not {goal!r}")
        return self._goals.call_async(self._impl.SendGoalService.Request(goal_id=_uuid(goal_id), goal=goal))

    def ask_result(self, goal_id: bytes) -> Any:
        """Ask for the result, to be sent when there is one; at once when the server doesn't know the goal."""
        return self._results.call_async(self._impl.GetResultService.Request(goal_id=_uuid(goal_id)))

    def ask_cancel(self, goal_id: bytes) -> Any:
        """Ask the server to cancel a goal, whether or not its acceptance came."""
        request = CancelGoal.Request()
        request.goal_info.goal_id = _uuid(goal_id)
        return self._cancels.call_async(request)


def new_goal_id() -> bytes:
    """Return an id that no other goal has, 16 bytes."""
    return uuid.uuid4().bytes


def status_in(listed: bytes, goal_id: bytes) -> int:
    """Return the status of a goal in a serialized `action_msgs/msg/GoalStatusArray`; 0 when it isn't listed.

    Args:
        listed: the message as it came: four bytes that tell the encoding, then, aligned from there (CDR, OMG DDSI-RTPS
            10.2), the number of goals and of each its id, seconds, nanoseconds and status, 16, 4, 4 and 1 bytes.
        goal_id: its 16 bytes.
    """
    place = listed.find(goal_id, _FIRST)
    while place >= 0:
        number, off = divmod(place - _NEXT, _EACH) if place > _FIRST else (0, 0)
        if off == 0:
            return listed[_STATUS + number * _EACH]
        place = listed.find(goal_id, place + 1)
    return 0


def _uuid(goal_id: bytes) -> Any:
    return UUID(uuid=np.frombuffer(goal_id, np.uint8))
