"""Who serves a name, and whether a client of ours would understand it: what DDS lets fail without a word.

A client and a server of different types, or of different definitions of one type, never exchange anything, and
`service_is_ready` doesn't look. A query of an endpoint tells type, type hash, reliability and identity.
"""

from __future__ import annotations

import importlib
import json
import re
from functools import cache
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy

from grip_bt.base.failures import UnfitServerError

_ACTION_PART = re.compile(r"_(SendGoal|GetResult|FeedbackMessage)$")


def servers_of(node: Node, name: str) -> list[Any]:
    """Return what is known of each server of a service: endpoint of its requests, node name, type, type hash, QoS."""
    return list(node.get_subscriptions_info_by_topic(f"rq{name}Request", no_mangle=True))


def gids_of(servers: list[Any]) -> frozenset[bytes]:
    """Return the identities of servers; a restarted server has another one."""
    return frozenset(bytes(server.endpoint_gid) for server in servers)


def check_servers(node: Node, service: Any, name: str, servers: list[Any]) -> None:
    """Check that the servers of a name are one server that a client of type `service` can call.

    Raises:
        UnfitServerError: another type, another definition of it, best-effort, or several servers.
    """
    for server in servers:
        _check_endpoint(service, name, server, "Request")
    for endpoint in node.get_publishers_info_by_topic(f"rr{name}Reply", no_mangle=True):
        _check_endpoint(service, name, endpoint, "Response")
    if len(servers) > 1:
        nodes = ", ".join(sorted(_node(s) for s in servers))
        raise UnfitServerError(
            f"{name}: {len(servers)} servers ({nodes}), each of which would execute a request; stop all but one",
            server=name,
        )


def action_servers(node: Node, name: str) -> list[Any]:
    """Return what is known of each server of an action, as `servers_of` does: endpoints that take its goals."""
    return servers_of(node, f"{name}/_action/send_goal")


def check_action_servers(node: Node, action: Any, name: str, servers: list[Any]) -> None:
    """Check that the servers of an action are one server that a client of type `action` can use.

    Raises:
        UnfitServerError: as `check_servers`, for its goals and for its results.
    """
    results = servers_of(node, f"{name}/_action/get_result")
    for server in servers:
        _check_endpoint(action.Impl.SendGoalService, name, server, "Request")
    for server in results:
        _check_endpoint(action.Impl.GetResultService, name, server, "Request")
    for endpoint in node.get_publishers_info_by_topic(f"rr{name}/_action/get_resultReply", no_mangle=True):
        _check_endpoint(action.Impl.GetResultService, name, endpoint, "Response")
    for endpoint in node.get_publishers_info_by_topic(f"rt{name}/_action/feedback", no_mangle=True):
        _check_endpoint(action.Impl.FeedbackMessage, name, endpoint, "")
    if len(servers) > 1:
        nodes = ", ".join(sorted(_node(s) for s in servers))
        raise UnfitServerError(
            f"{name}: {len(servers)} action servers ({nodes}), each of which would execute a goal; stop all but one",
            server=name,
        )


def _check_endpoint(service: Any, name: str, endpoint: Any, part: str) -> None:
    """Check one half of a server; the definitions of requests and responses have hashes of their own."""
    package, kind = service.__module__.split(".")[:2]
    wanted = (
        f"{package}::{kind}::dds_::{service.__name__}_{part}_"
        if part
        else (f"{package}::{kind}::dds_::{service.__name__}_")
    )
    if endpoint.topic_type != wanted:
        raise UnfitServerError(
            f"{name}: {_node(endpoint)} serves {_readable(endpoint.topic_type)}, not {_readable(wanted)}",
            server=name,
            serves=_readable(endpoint.topic_type),
        )
    ours, theirs = type_hash(service, part), str(endpoint.topic_type_hash)
    if ours is not None and theirs != ours:
        half = _half(service, part)
        raise UnfitServerError(
            f"{name}: {_node(endpoint)} was built with another definition of the {half} of {_readable(wanted)} "
            f"({theirs[7:15]}..., ours is {ours[7:15]}...); build both from the same file",
            server=name,
        )
    if part and endpoint.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT:
        what = "a service" if kind == "srv" else "an action"
        raise UnfitServerError(
            f"{name}: {_node(endpoint)} is best-effort; {what} must be reliable, which is ROS's default",
            server=name,
        )


@cache
def type_hash(service: Any, part: str) -> str | None:
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


def _node(endpoint: Any) -> str:
    """Name a server's node; names travel more slowly than endpoints."""
    name = endpoint.node_name
    return f"node {name!r}" if name and name != "_NODE_NAME_UNKNOWN_" else "a node"


def _half(service: Any, part: str) -> str:
    """Name what differs: the request of a service; the goal, the result or the feedback of an action."""
    names = {"_SendGoal": "goal", "_GetResult": "result", "_FeedbackMessage": "feedback"}
    return next((words for suffix, words in names.items() if service.__name__.endswith(suffix)), part.lower())


def _readable(dds_type: str) -> str:
    """Turn `std_srvs::srv::dds_::Trigger_Request_` into `std_srvs/srv/Trigger`."""
    plain = dds_type.replace("::dds_::", "::").removesuffix("_Request_").removesuffix("_Response_").removesuffix("_")
    return (_ACTION_PART.sub("", plain) if "::action::" in plain else plain).replace("::", "/")
