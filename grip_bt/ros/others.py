"""What is served instead of what somebody waited for in vain: another name, another kind, nothing at all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.action.graph import get_action_names_and_types
from rclpy.node import Node

from grip_bt.errors import ServerLostError, listing, nearest

from .types import type_name

_HIDDEN = (
    *("/_action/", "/describe_parameters", "/get_parameter_types", "/get_parameters", "/list_parameters"),
    *("/set_parameters", "/set_parameters_atomically", "/get_type_description", "/rosout", "/parameter_events"),
)
_MOST = 8
"""How many names are listed."""
Names = Sequence[tuple[str, Sequence[str]]]


def hidden(name: str) -> bool:
    """Tell whether a name is of what every node has, or a part of an action."""
    return any(part in name if part.startswith("/_") else name.endswith(part) for part in _HIDDEN)


def explained(error: Exception, node: Node, type_: Any) -> Exception:
    """Return an error that says in vain was waited for a server with what is served instead; any other as it is.

    On the bus's thread.

    Args:
        error: what a call or a goal ended with; `waited` in its data marks the ones meant.
        node: who looks at the graph.
        type_: the class of the service or the action.
    """
    if not isinstance(error, ServerLostError) or "waited" not in error.data:
        return error
    services = [(name, types) for name, types in node.get_service_names_and_types() if not hidden(name)]
    actions = get_action_names_and_types(node)
    domain = node.context.get_domain_id()
    return ServerLostError(
        error.message + instead(error.data["server"], type_name(type_), services, actions, domain), **error.data
    )


def instead(name: str, wanted: str, services: Names, actions: Names, domain: int) -> str:
    """Return what is served instead of a name, in words to be put behind the message.

    Args:
        name: what was waited for.
        wanted: its type.
        services: names and types of the services that run.
        actions: likewise of the actions.
        domain: the DDS domain in which was looked.
    """
    ours, theirs, other = (services, actions, "an action") if "/srv/" in wanted else (actions, services, "a service")
    where = f"in ROS_DOMAIN_ID {domain}"
    for served, types in theirs:
        if served == name:
            return f"; {name} is {other}, of type {types[0]}"
    same = sorted(served for served, types in ours if wanted in types and served != name)
    if same:
        return f"; {wanted} is served {where} as {listing(same[:_MOST])}"
    names = sorted(served for served, _ in ours if served != name)
    kind = "services" if "/srv/" in wanted else "actions"
    more = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
    return f"{nearest(name, names)} ({kind} {where}: {listing(names[:_MOST])}{more})"
