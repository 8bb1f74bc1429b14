"""Whether a name has one server that a client of ours would understand, and that knows us: asked before sending.

A client and a server of different types, or of different definitions of one type, never exchange anything, and
`service_is_ready` doesn't look. A query of an endpoint tells type, type hash, reliability and identity.
"""

from __future__ import annotations

import importlib
import json
import re
from functools import cache
from pathlib import Path

from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from grip_bt.base.failures import IncompatibleServerError

from .types import InterfaceType

TRUST = 0.5
"""How long a check of the server holds [s]; a query per call would double the price of a call."""
SETTLE = 0.1
"""How long a server must be known before it is sent anything [s]: it has to know our ear too, or its first answer is
lost."""
STALE = 3.5
"""How long a second server may be a dead one whose lease is running out [s]."""
GRACE = 1.0
"""How long to wait for the exit of a process of ours whose server has gone [s]: it says more than DDS does."""


_ACTION_PART = re.compile(r"_(SendGoal|GetResult|FeedbackMessage)$")


def servers_of(node: Node, name: str) -> list[TopicEndpointInfo]:
    """Return what is known of each server of a service: endpoint of its requests, node name, type, type hash, QoS."""
    return list(node.get_subscriptions_info_by_topic(f"rq{name}Request", no_mangle=True))


def gids_of(servers: list[TopicEndpointInfo]) -> frozenset[bytes]:
    """Return the identities of servers; a restarted server has another one."""
    return frozenset(bytes(server.endpoint_gid) for server in servers)


def check_servers(node: Node, service: InterfaceType, name: str, servers: list[TopicEndpointInfo]) -> None:
    """Check that the servers of a name are one server that a client of type `service` can call.

    Raises:
        IncompatibleServerError: another type, another definition of it, best-effort, or several servers.
    """
    replies = node.get_publishers_info_by_topic(f"rr{name}Reply", no_mangle=True)
    parts = [(service, servers, "Request"), (service, replies, "Response")]
    _check_parts(name, parts, servers, "servers", "a request")


def action_servers(node: Node, name: str) -> list[TopicEndpointInfo]:
    """Return what is known of each server of an action, as `servers_of` does: endpoints that take its goals."""
    return servers_of(node, f"{name}/_action/send_goal")


def check_action_servers(node: Node, action: InterfaceType, name: str, servers: list[TopicEndpointInfo]) -> None:
    """Check that the servers of an action are one server that a client of type `action` can use.

    Raises:
        IncompatibleServerError: as `check_servers`, for its goals and for its results.
    """
    impl, ends = action.Impl, node.get_publishers_info_by_topic
    parts = [
        (impl.SendGoalService, servers, "Request"),
        (impl.GetResultService, servers_of(node, f"{name}/_action/get_result"), "Request"),
        (impl.GetResultService, ends(f"rr{name}/_action/get_resultReply", no_mangle=True), "Response"),
        (impl.FeedbackMessage, ends(f"rt{name}/_action/feedback", no_mangle=True), ""),
    ]
    _check_parts(name, parts, servers, "action servers", "a goal")


def _check_parts(
    name: str,
    parts: list[tuple[InterfaceType, list[TopicEndpointInfo], str]],
    servers: list[TopicEndpointInfo],
    kind: str,
    executed: str,
) -> None:
    for type_, endpoints, part in parts:
        for endpoint in endpoints:
            _check_endpoint(type_, name, endpoint, part)
    if len(servers) > 1:
        nodes = ", ".join(sorted(_node(s) for s in servers))
        raise IncompatibleServerError(
            f"{name}: {len(servers)} {kind} ({nodes}), each of which would execute {executed}; stop all but one",
            server=name,
        )


def _check_endpoint(service: InterfaceType, name: str, endpoint: TopicEndpointInfo, part: str) -> None:
    """Check one half of a server; the definitions of requests and responses have hashes of their own."""
    package, kind = service.__module__.split(".")[:2]
    wanted = f"{package}::{kind}::dds_::{service.__name__}_" + (f"{part}_" if part else "")
    if endpoint.topic_type != wanted:
        raise IncompatibleServerError(
            f"{name}: {_node(endpoint)} serves {_readable(endpoint.topic_type)}, not {_readable(wanted)}",
            server=name,
            serves=_readable(endpoint.topic_type),
        )
    ours, theirs = type_hash(service, part), str(endpoint.topic_type_hash)
    if ours is not None and theirs != ours:
        halves = {"_SendGoal": "goal", "_GetResult": "result", "_FeedbackMessage": "feedback"}
        half = next((words for suffix, words in halves.items() if service.__name__.endswith(suffix)), part.lower())
        raise IncompatibleServerError(
            f"{name}: {_node(endpoint)} uses a different definition of the {half} of {_readable(wanted)} "
            f"({theirs[7:15]}..., ours is {ours[7:15]}...); build both from the same file",
            server=name,
        )
    if part and endpoint.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT:
        what = "a service" if kind == "srv" else "an action"
        raise IncompatibleServerError(
            f"{name}: {_node(endpoint)} is best-effort; {what} must be reliable, which is ROS's default",
            server=name,
        )


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
    return f"node {name!r}" if name and name != "_NODE_NAME_UNKNOWN_" else "a node"


def _readable(dds_type: str) -> str:
    """Turn `std_srvs::srv::dds_::Trigger_Request_` into `std_srvs/srv/Trigger`."""
    plain = dds_type.replace("::dds_::", "::").removesuffix("_Request_").removesuffix("_Response_").removesuffix("_")
    return (_ACTION_PART.sub("", plain) if "::action::" in plain else plain).replace("::", "/")
