"""Message types of ROS 1 and ROS 2 by the same questions."""

from __future__ import annotations

import copy
from typing import Any


def new_goal(action: Any) -> Any:
    """Return an empty goal of an action's type."""
    return action.Goal() if hasattr(action, "Goal") else copy.copy(action().action_goal.goal)


def new_result(action: Any) -> Any:
    """Return an empty result of an action's type."""
    return action.Result() if hasattr(action, "Result") else copy.copy(action().action_result.result)


def new_feedback(action: Any) -> Any:
    """Return an empty feedback of an action's type."""
    return action.Feedback() if hasattr(action, "Feedback") else copy.copy(action().action_feedback.feedback)


def new_request(service: Any) -> Any:
    """Return an empty request of a service's type."""
    return service.Request() if hasattr(service, "Request") else service._request_class()


def fields(message: Any) -> tuple[str, ...]:
    """Return the names of a message's fields."""
    if hasattr(message, "get_fields_and_field_types"):
        return tuple(message.get_fields_and_field_types())
    return tuple(message.__slots__)
