"""What runs: the services, actions and topics that others serve, and of which type each is."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Literal

from rclpy.action.graph import get_action_names_and_types
from rclpy.node import Node

from grip_bt.base.errors import GripError, UnknownNameError

from .bus import Bus
from .others import hidden
from .others import topics as topics

SETTLE = 0.1
"""What was found is all there when nothing new was seen for so long [s]: of a server's parts, some are seen before
others."""
LOOK = 0.01
"""How often is looked [s]; rclpy tells nobody when the graph changes."""


@dataclass(frozen=True, slots=True)
class Served:
    """Something in the running graph.

    Attributes:
        name: its full name.
        kind: `action`, `srv` or `msg`.
        type: its type, such as `std_srvs/srv/Trigger`.
        nodes: names of the nodes that serve it, where they are known.
    """

    name: str
    kind: Literal["action", "srv", "msg"]
    type: str
    nodes: tuple[str, ...] = ()


class TwoTypesError(GripError):
    """One name is served with two types."""

    def __init__(self, name: str, types: list[str]):
        self.name, self.types = name, types
        super().__init__(f"{name} is served as {' and as '.join(types)}; stop one of the two")


def everything(node: Node) -> list[Served]:
    """Return all that is served, without what every node has; on the bus's thread.

    Raises:
        TwoTypesError: a service or an action has two types.
    """
    found: list[Served] = []
    for name, types in get_action_names_and_types(node):
        found.append(Served(name, "action", _one(name, types), _nodes(node, f"{name}/_action/send_goal")))
    for name, types in node.get_service_names_and_types():
        if not hidden(name):
            found.append(Served(name, "srv", _one(name, types), _nodes(node, name)))
    found += [Served(name, "msg", types[0]) for name, types, _ in topics(node)]
    return sorted(found, key=lambda served: (served.kind, served.name))


def find_served(name: str, within: float = 5.0, domain_id: int | None = None) -> Served:
    """Return what is served under a name; actions come before services, services before topics.

    Args:
        name: such as `/plan_grasp`; a missing first slash is added.
        within: how long to look [s].
        domain_id: the DDS domain; ROS_DOMAIN_ID, else 0, by default.

    Raises:
        UnknownNameError: nothing of that name is there; it lists what is.
        TwoTypesError: two types are.
    """
    wanted = name if name.startswith("/") else f"/{name}"
    deadline = time.monotonic() + within
    with Bus("grip_look", domain_id=domain_id) as bus:
        seen, since = _on_bus(bus), time.monotonic()
        while True:
            found = [s for s in seen if s.name == wanted]
            now = time.monotonic()
            if found and (now > since + SETTLE or now > deadline):
                return found[0]
            if now > deadline:
                names = [s.name for s in seen]
                where = f"the running graph, after {within:.0f} s (ROS_DOMAIN_ID {_domain(domain_id)})"
                raise UnknownNameError("service, action or topic", wanted, names, where)
            time.sleep(LOOK)
            before, seen = seen, _on_bus(bus)
            if seen != before:
                since = time.monotonic()


def list_served(within: float = 2.0, domain_id: int | None = None) -> list[Served]:
    """Return all that is seen after listening for `within` [s]."""
    with Bus("grip_look", domain_id=domain_id) as bus:
        time.sleep(within)
        return _on_bus(bus)


def _on_bus(bus: Bus) -> list[Served]:
    operation = bus.post(lambda: everything(bus.node))
    operation.wait(5.0)
    return operation.result()


def _domain(domain_id: int | None) -> Any:
    import os

    return domain_id if domain_id is not None else os.environ.get("ROS_DOMAIN_ID", "0")


def _one(name: str, types: list[str]) -> str:
    if len(types) > 1:
        raise TwoTypesError(name, types)
    return types[0]


def _nodes(node: Node, service: str) -> tuple[str, ...]:
    servers = node.get_subscriptions_info_by_topic(f"rq{service}Request", no_mangle=True)
    return tuple(sorted(s.node_name for s in servers if s.node_name and s.node_name != "_NODE_NAME_UNKNOWN_"))
