"""What runs: the services, actions and topics that others serve, and what there is instead of one that isn't there."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Literal

from rclpy.action.graph import get_action_names_and_types
from rclpy.node import Node

from grip_bt.base.errors import GripError, UnknownNameError, listing
from grip_bt.base.failures import ServerLostError

from .connection import Connection
from .types import InterfaceType, type_name

LOOKING = 5.0
"""How long one look at the graph may take [s]."""
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
        if not is_internal(name):
            found.append(Served(name, "srv", _one(name, types), _nodes(node, name)))
    found += [Served(name, "msg", types[0]) for name, types, _ in topics(node)]
    return sorted(found, key=lambda served: (served.kind, served.name))


def served_names(node: Node) -> tuple[set[str], set[str]]:
    """Return the names of what is served (services, actions), and of the topics that somebody publishes."""
    served = {name for name, _ in (*node.get_service_names_and_types(), *get_action_names_and_types(node))}
    return served, {name for name, _ in node.get_topic_names_and_types() if node.count_publishers(name)}


def find_served(name: str, within: float = 5.0) -> Served:
    """Return what is served under a name; actions come before services, services before topics.

    Args:
        name: such as `/plan_grasp`; a missing first slash is added.
        within: how long to look [s].

    Raises:
        UnknownNameError: nothing of that name is there; it lists what is.
        TwoTypesError: two types are.
    """
    wanted = name if name.startswith("/") else f"/{name}"
    deadline = time.monotonic() + within
    with Connection("grip_look") as bus:
        seen, since = bus.ask(lambda: everything(bus.node), LOOKING), time.monotonic()
        while True:
            found = [s for s in seen if s.name == wanted]
            now = time.monotonic()
            if found and (now > since + SETTLE or now > deadline):
                return found[0]
            if now > deadline:
                names = [s.name for s in seen]
                where = f"the running graph, after {within:.0f} s (ROS_DOMAIN_ID {bus.domain_id})"
                raise UnknownNameError("service, action or topic", wanted, names, where)
            time.sleep(LOOK)
            before, seen = seen, bus.ask(lambda: everything(bus.node), LOOKING)
            if seen != before:
                since = time.monotonic()


def _one(name: str, types: list[str]) -> str:
    if len(types) > 1:
        raise TwoTypesError(name, types)
    return types[0]


def _nodes(node: Node, service: str) -> tuple[str, ...]:
    servers = node.get_subscriptions_info_by_topic(f"rq{service}Request", no_mangle=True)
    return tuple(sorted(s.node_name for s in servers if s.node_name and s.node_name != "_NODE_NAME_UNKNOWN_"))


_HIDDEN = (
    *("/_action/", "/describe_parameters", "/get_parameter_types", "/get_parameters", "/list_parameters"),
    *("/set_parameters", "/set_parameters_atomically", "/get_type_description", "/rosout", "/parameter_events"),
)
MOST = 8
"""How many names are listed."""
Done = Literal["served", "published", "heard"]
"""What is done with what is looked for: services and actions are served, topics published, or heard by subscribers."""


def is_internal(name: str) -> bool:
    """Tell whether a name is of what every node has, or a part of an action."""
    return any(part in name if part.startswith("/_") else name.endswith(part) for part in _HIDDEN)


def topics(node: Node) -> list[tuple[str, list[str], int]]:
    """Return the topics that somebody publishes, by name: name, types, number of publishers; on the bus's thread."""
    seen = ((name, types, node.count_publishers(name)) for name, types in node.get_topic_names_and_types())
    return sorted((name, types, count) for name, types, count in seen if count and not is_internal(name))


def explained(error: Exception, node: Node, type_: InterfaceType) -> Exception:
    """Return an error that says in vain was waited for a server with what is served instead; any other as it is.

    On the bus's thread.

    Args:
        error: what a call or a goal ended with; `waited` in its data marks the ones meant.
    """
    if not isinstance(error, ServerLostError) or "waited" not in error.data:
        return error
    there = instead(node, error.data["server"], type_name(type_), "served")
    return ServerLostError(error.message + there, **error.data)


def instead(node: Node, name: str, wanted: str, done: Done) -> str:
    """Return what there is instead of a name that isn't there as `wanted`, in words to be put behind the message.

    On the bus's thread.

    Args:
        wanted: its type; empty where nobody said it.
        done: what should be done with it.
    """
    ends = node.get_subscriptions_info_by_topic if done == "heard" else node.get_publishers_info_by_topic
    carried = [(n, sorted({end.topic_type for end in ends(n)})) for n, _ in node.get_topic_names_and_types()]
    served = [*node.get_service_names_and_types(), *get_action_names_and_types(node)]
    there, others = (served, carried) if done == "served" else ([c for c in carried if c[0] != name], served)
    there += [other for other in others if other[0] == name]
    found = [(n, types) for n, types in there if types and not is_internal(n)]
    return in_words(name, wanted, found, done, node.context.get_domain_id())


def in_words(name: str, wanted: str, there: Iterable[tuple[str, Sequence[str]]], done: Done, domain: int) -> str:
    """Return in words what is there, as names with types: first the name itself, then its type, then names like it."""
    where = f"{done} in ROS_DOMAIN_ID {domain}"
    names = sorted(there, key=lambda o: (o[0] != name, wanted not in o[1], -_alike(name, o[0]), o))
    if not names:
        return f"; nothing of its kind is {where}"
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return f"; {where}: {listing(f'{n} ({types[0]})' for n, types in names[:MOST])}{more}"


def _alike(name: str, other: str) -> float:
    return SequenceMatcher(None, name, other).ratio()
