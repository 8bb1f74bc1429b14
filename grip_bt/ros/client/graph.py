"""What runs: the services, actions and topics that others serve, and whether a name has the one server that is meant.

A client and a server of different types, or of different definitions of one type, never exchange anything, and
`service_is_ready` does not look. A query of an endpoint tells type, type hash, reliability and identity.
"""

from __future__ import annotations

import importlib
import json
import re
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import cache
from pathlib import Path
from typing import Literal

from rclpy.action.graph import get_action_names_and_types
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from grip_bt.base.errors import GripError, UnknownNameError, listing
from grip_bt.base.failures import IncompatibleServerError

from .connection import Connection
from .types import InterfaceType

LOOKING = 5.0
"""How long one look at the graph may take [s]."""
SETTLE = 0.1
"""Discovery is complete when nothing new was seen for this time [s]: of a server's parts, some are seen before
others. A server is sent nothing sooner: it has to have found our reader too, or its first answer is lost."""


@dataclass(frozen=True, slots=True)
class Served:
    """Something in the running graph.

    Attributes:
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
    found = []
    for name, types in served(node):
        if len(types) > 1:
            raise TwoTypesError(name, types)
        kind: Literal["action", "srv"] = "action" if "/action/" in types[0] else "srv"
        ends = endpoints_of(node, f"{name}/_action/send_goal" if kind == "action" else name)
        nodes = sorted(end.node_name for end in ends if end.node_name and end.node_name != _NAMELESS)
        found.append(Served(name, kind, types[0], tuple(nodes)))
    found += [Served(name, "msg", types[0]) for name, types, _ in topics(node)]
    return sorted(found, key=lambda served: (served.kind, served.name))


def served(node: Node) -> list[tuple[str, list[str]]]:
    """Return the services and the actions with their types, without what every node has; on the bus's thread."""
    names = (*node.get_service_names_and_types(), *get_action_names_and_types(node))
    return [(name, types) for name, types in names if types and not is_internal(name)]


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
        seen: list[Served] = []
        while True:
            before, seen = seen, bus.ask(lambda: everything(bus.node), LOOKING)
            found, over = [s for s in seen if s.name == wanted], time.monotonic() > deadline
            if found and (seen == before or over):
                return found[0]
            if over:
                names = [s.name for s in seen]
                where = f"the running graph, after {within:.0f} s (ROS_DOMAIN_ID {bus.domain_id})"
                raise UnknownNameError("service, action or topic", wanted, names, where)
            time.sleep(SETTLE)


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


def instead(node: Node, name: str, wanted: str, done: Done) -> str:
    """Return what there is instead of a name that isn't there as `wanted`, in words to be put behind the message.

    On the bus's thread.

    Args:
        wanted: its type; empty where nobody said it.
    """
    ends = node.get_subscriptions_info_by_topic if done == "heard" else node.get_publishers_info_by_topic
    carried = [(n, sorted({e.topic_type for e in ends(n)})) for n, _ in node.get_topic_names_and_types()]
    carried = [(n, types) for n, types in carried if types and not is_internal(n)]
    there, others = (served(node), carried) if done == "served" else (carried, served(node))
    other = next((f"; {n} itself is {types[0]}" for n, types in others if n == name), "")
    there = [found for found in there if done == "served" or found[0] != name]
    return other + in_words(name, wanted, there, done, node.context.get_domain_id())


def in_words(name: str, wanted: str, there: Iterable[tuple[str, Sequence[str]]], done: Done, domain: int) -> str:
    """Return in words what is there, as names with types: first the name itself, then its type, then names like it."""
    where = f"{done} in ROS_DOMAIN_ID {domain}"
    names = sorted(
        there, key=lambda o: (o[0] != name, wanted not in o[1], -SequenceMatcher(None, name, o[0]).ratio(), o)
    )
    if not names:
        return f"; nothing of its kind is {where}"
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return f"; {where}: {listing(f'{n} ({types[0]})' for n, types in names[:MOST])}{more}"


TRUST = 0.5
"""How long a check of the server holds [s]; a query per call would double the price of a call."""
STALE = 3.5
"""How long a second server may be a dead one whose lease is running out [s]."""
GRACE = 1.0
"""How long to wait for the exit of a process of ours whose server has gone [s]: it says more than DDS does."""


_NAMELESS = "_NODE_NAME_UNKNOWN_"
_ACTION_PART = re.compile(r"_(SendGoal|GetResult|FeedbackMessage)$")


def endpoints_of(node: Node, service: str) -> list[TopicEndpointInfo]:
    """Return what is known of each server of a service: endpoint of its requests, node name, type, type hash, QoS."""
    return list(node.get_subscriptions_info_by_topic(f"rq{service}Request", no_mangle=True))


def gids_of(servers: list[TopicEndpointInfo]) -> frozenset[bytes]:
    """Return the identities of servers; a restarted server has another one."""
    return frozenset(bytes(server.endpoint_gid) for server in servers)


def check_servers(node: Node, type_: InterfaceType, name: str, servers: list[TopicEndpointInfo]) -> None:
    """Check that the servers of a name are one server that a client of a service's or an action's type can use.

    Raises:
        IncompatibleServerError: another type, another definition of it, best-effort, or several servers.
    """
    ends = node.get_publishers_info_by_topic
    if hasattr(type_, "Impl"):
        of, action = type_.Impl, f"{name}/_action"
        parts = [
            (of.SendGoalService, servers, "Request"),
            (of.GetResultService, endpoints_of(node, f"{action}/get_result"), "Request"),
            (of.GetResultService, ends(f"rr{action}/get_resultReply", no_mangle=True), "Response"),
            (of.FeedbackMessage, ends(f"rt{action}/feedback", no_mangle=True), ""),
        ]
    else:
        parts = [(type_, servers, "Request"), (type_, ends(f"rr{name}Reply", no_mangle=True), "Response")]
    for part_type, endpoints, part in parts:
        for endpoint in endpoints:
            _check_endpoint(part_type, name, endpoint, part)
    if len(servers) > 1:
        nodes, what = ", ".join(sorted(_node(s) for s in servers)), "a goal" if len(parts) > 2 else "a request"
        reason = f"{len(servers)} servers ({nodes}), each of which would execute {what}; stop all but one"
        raise IncompatibleServerError(f"{name}: {reason}", server=name)


def _check_endpoint(service: InterfaceType, name: str, endpoint: TopicEndpointInfo, part: str) -> None:
    """Check one half of a server; the definitions of requests and responses have hashes of their own."""
    package, kind = service.__module__.split(".")[:2]
    wanted = f"{package}::{kind}::dds_::{service.__name__}_" + (f"{part}_" if part else "")
    ours, theirs = type_hash(service, part), str(endpoint.topic_type_hash)
    data = {}
    if endpoint.topic_type != wanted:
        data["serves"] = _readable(endpoint.topic_type)
        reason = f"serves {data['serves']}, not {_readable(wanted)}"
    elif ours is not None and theirs != ours:
        halves = {"_SendGoal": "goal", "_GetResult": "result", "_FeedbackMessage": "feedback"}
        half = next((words for suffix, words in halves.items() if service.__name__.endswith(suffix)), part.lower())
        hashes = f"({theirs[7:15]}..., ours is {ours[7:15]}...); build both from the same file"
        reason = f"uses a different definition of the {half} of {_readable(wanted)} {hashes}"
    elif part and endpoint.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT:
        what = "a service" if kind == "srv" else "an action"
        reason = f"is best-effort; {what} must be reliable, which is ROS's default"
    else:
        return
    raise IncompatibleServerError(f"{name}: {_node(endpoint)} {reason}", server=name, **data)


@cache
def type_hash(service: InterfaceType, part: str) -> str | None:
    """Return the RIHS01 hash of a service's `Request` or `Response` as built here; None where it isn't installed.

    Args:
        service: a service's class, a service of an action (`Impl.SendGoalService`), or an action's feedback message.
        part: `Request` or `Response`; empty for a message.
    """
    package, kind = service.__module__.split(".")[:2]
    module = importlib.import_module(package)
    if module.__file__ is None:
        return None
    of_action = _ACTION_PART.sub("", service.__name__) if kind == "action" else service.__name__
    file = Path(module.__file__).parents[4] / "share" / package / kind / f"{of_action}.json"
    if not file.is_file():
        return None
    wanted = f"{package}/{kind}/{service.__name__}" + (f"_{part}" if part else "")
    hashes = json.loads(file.read_text(encoding="utf-8"))["type_hashes"]
    return next((h["hash_string"] for h in hashes if h["type_name"] == wanted), None)


def _node(endpoint: TopicEndpointInfo) -> str:
    """Name a server's node; names travel more slowly than endpoints."""
    name = endpoint.node_name
    return f"node {name!r}" if name and name != _NAMELESS else "a node"


def _readable(dds_type: str) -> str:
    """Turn `std_srvs::srv::dds_::Trigger_Request_` into `std_srvs/srv/Trigger`."""
    plain = dds_type.replace("::dds_::", "::").removesuffix("_Request_").removesuffix("_Response_").removesuffix("_")
    return (_ACTION_PART.sub("", plain) if "::action::" in plain else plain).replace("::", "/")
