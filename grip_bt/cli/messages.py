"""`grip messages`: serve a project's named messages over ROS 2, and look at what a server has."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

from grip_bt.errors import ServerLostError

ARCHIVE = "messages.sqlite"
WAIT = 15.0


def add_parser(subparsers: Any) -> None:
    """Add the verb."""
    parser = subparsers.add_parser("messages", help="named joint states, poses, grasps ...: serve, list, show, reset")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    serve = actions.add_parser("serve", help="serve a project's messages until stopped")
    serve.add_argument("--project", type=Path, default=Path(), help="project folder (default: here)")
    serve.set_defaults(run=run_serve)
    listing = actions.add_parser("list", help="what a running server has")
    listing.add_argument("store", nargs="?", default="", help="only of this store")
    listing.add_argument("--json", action="store_true", help="print one JSON list")
    listing.set_defaults(run=run_list)
    show = actions.add_parser("show", help="print one message")
    show.add_argument("store", help="such as poses, joint_states")
    show.add_argument("name", help="of the message")
    show.set_defaults(run=run_show)
    delete = actions.add_parser("delete", help="remove one message")
    delete.add_argument("store", help="such as poses, joint_states")
    delete.add_argument("name", help="of the message")
    delete.set_defaults(run=lambda args: _ask(lambda m: m.delete(args.store, args.name)))
    reset = actions.add_parser("reset", help="empty a store, or all, and read the project's files again")
    reset.add_argument("store", nargs="?", default="", help="only this one (default: all)")
    reset.set_defaults(run=lambda args: _ask(lambda m: m.reset(args.store)))
    save = actions.add_parser("save", help="keep everything over restarts of the server")
    save.set_defaults(run=lambda args: _ask(lambda m: m.save()))


def run_serve(args: argparse.Namespace) -> int:
    """Serve until SIGINT or SIGTERM."""
    from grip_bt.app.project import find_project
    from grip_bt.ros.bus import Bus
    from grip_bt.ros.managers import MessageServer

    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: over.set())
    project = find_project(args.project)
    with Bus("grip_messages") as bus:
        MessageServer(bus, project.folder / "messages", project.state_folder / ARCHIVE)
        print(f"serving the messages of {project.folder} under /grip/messages", flush=True)
        while not over.wait(1.0):
            pass
    return 0


def run_list(args: argparse.Namespace) -> int:
    """Print one line for each message."""
    answer = _answer(lambda messages: messages.listing())
    rows = [
        {
            "store": e.store,
            "name": e.name,
            "type": e.type,
            "time": e.stamp.sec + e.stamp.nanosec * 1e-9,
            "provenance": e.provenance,
        }
        for e in answer.entries
        if args.store in ("", e.store)
    ]
    if args.json:
        print(json.dumps(rows, indent=2))
        return 0
    for row in rows:
        when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(row["time"]))
        print(f"{row['store']:<14} {row['name']:<24} {row['type']:<36} {when}  {row['provenance']}")
    for store, count in zip(answer.stores, answer.queued, strict=True):
        if count and args.store in ("", store):
            print(f"{store:<14} {count} in the queue")
    return 0


def run_show(args: argparse.Namespace) -> int:
    """Print one message."""
    entry = _answer(lambda messages: messages.get(args.store, args.name))
    print(entry.value)
    return 0


def _ask(request: Any) -> int:
    _answer(request)
    return 0


def _answer(request: Any) -> Any:
    """Return what a server answers.

    Raises:
        ServerLostError: there is none.
    """
    from grip_bt.ros.bus import Bus
    from grip_bt.ros.managers import RosMessages

    with Bus("grip_messages_client") as bus:
        operation = request(RosMessages(bus))
        if not operation.wait(WAIT):
            sys.stderr.write("grip: no answer\n")
        try:
            return operation.result()
        except ServerLostError as error:
            advice = "start one: `grip messages serve` in the project's folder, with the same ROS_DOMAIN_ID"
            raise ServerLostError(f"{error}; {advice}") from error
