"""rclpy's action client, with what it keeps to itself: the status of every goal, and cancelling by a goal's id.

By itself rclpy gives a handle of a goal only with the server's acceptance. A server that doesn't know our ear yet can't
deliver that answer; rclpy could then neither cancel the goal nor ask for its result, and would drop its status.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable
from typing import Any

import rclpy.action
from rclpy.action.client import ClientGoalHandle
from unique_identifier_msgs.msg import UUID


class WireClient(rclpy.action.ActionClient):
    """An action client that tells the status of goals whether or not their acceptance came.

    Args:
        node: the node it lives on.
        type_: the action's class.
        name: the action's full name.
        on_status: called on the executor's thread with `action_msgs/msg/GoalStatus` numbers by the bytes of goal ids,
            of all goals of the server.
    """

    def __init__(self, node: Any, type_: Any, name: str, on_status: Callable[[dict[bytes, int]], None]):
        self._on_status = on_status
        super().__init__(node, type_, name)

    def new_goal(self) -> Any:
        """Return a handle with a new id, good for cancelling and for asking for the result once the goal is sent."""
        return ClientGoalHandle(self, UUID(uuid=list(uuid.uuid4().bytes)), None)

    def forget(self, handle: Any) -> None:
        """Drop the feedback callback of a goal whose result was never asked for; rclpy would keep it for ever."""
        self._feedback_callbacks.pop(bytes(handle.goal_id.uuid), None)

    async def execute(self, taken_data: Any) -> None:
        """Handle what the executor took from the wire."""
        await super().execute(taken_data)
        if "status" in taken_data:
            listed = taken_data["status"].status_list
            self._on_status({bytes(entry.goal_info.goal_id.uuid): entry.status for entry in listed})
