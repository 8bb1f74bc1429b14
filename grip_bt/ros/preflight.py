"""Who serves a name, and whether a client of ours would understand it: what DDS lets fail without a word.

A client and a server of different types, or of different definitions of one type, never exchange anything, and
`service_is_ready` doesn't look. One query of the request's endpoint tells type, type hash, reliability and identity.
"""

from __future__ import annotations

import importlib
import json
from functools import cache
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy

from grip_bt.errors import UnfitServerError


def servers_of(node: Node, name: str) -> list[Any]:
    """Return what is known of each server of a service: endpoint, node name, type, type hash, QoS."""
    return list(node.get_subscriptions_info_by_topic(f"rq{name}Request", no_mangle=True))


def gids_of(servers: list[Any]) -> frozenset[bytes]:
    """Return the identities of servers; a restarted server has another one."""
    return frozenset(bytes(server.endpoint_gid) for server in servers)


def check_servers(service: Any, name: str, servers: list[Any]) -> None:
    """Check that the servers of a name are one server that a client of type `service` can call.

    Raises:
        UnfitServerError: another type, another definition of it, best-effort, or several servers.
    """
    package, kind = service.__module__.split(".")[:2]
    wanted = f"{package}::{kind}::dds_::{service.__name__}_Request_"
    ours = type_hash(service)
    for server in servers:
        node = server.node_name
        if server.topic_type != wanted:
            raise UnfitServerError(
                f"{name}: node {node!r} serves {_readable(server.topic_type)}, not {_readable(wanted)}",
                server=name,
                serves=_readable(server.topic_type),
            )
        theirs = str(server.topic_type_hash)
        if ours is not None and theirs != ours:
            raise UnfitServerError(
                f"{name}: node {node!r} was built with another definition of {_readable(wanted)} "
                f"({theirs[7:15]}..., ours is {ours[7:15]}...); build both from the same file",
                server=name,
            )
        if server.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT:
            raise UnfitServerError(f"{name}: node {node!r} is best-effort; a service must be reliable", server=name)
    if len(servers) > 1:
        nodes = ", ".join(sorted(repr(s.node_name) for s in servers))
        raise UnfitServerError(
            f"{name}: {len(servers)} servers ({nodes}), each of which would execute a request; stop all but one",
            server=name,
        )


@cache
def type_hash(service: Any) -> str | None:
    """Return the RIHS01 hash of a service's request as built here; None where it wasn't installed with the package."""
    package, kind = service.__module__.split(".")[:2]
    module = importlib.import_module(package)
    if module.__file__ is None:
        return None
    file = Path(module.__file__).parents[4] / "share" / package / kind / f"{service.__name__}.json"
    if not file.is_file():
        return None
    wanted = f"{package}/{kind}/{service.__name__}_Request"
    hashes = json.loads(file.read_text(encoding="utf-8"))["type_hashes"]
    return next((h["hash_string"] for h in hashes if h["type_name"] == wanted), None)


def _readable(dds_type: str) -> str:
    """Turn `std_srvs::srv::dds_::Trigger_Request_` into `std_srvs/srv/Trigger`."""
    return dds_type.replace("::dds_::", "::").removesuffix("_Request_").replace("::", "/")
