"""`grip messages`: serve a project's named messages over ROS 2, and ask a server that runs."""

from __future__ import annotations

import argparse
import threading
from pathlib import Path
from typing import Any

from grip_bt.app.project.folder import find_project
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.messages import MessageServer

from . import messages_client as client
from .signals import on_stop

ARCHIVE = "messages.sqlite"
_VALUE = "YAML, as in a project's files or field by field; - for the standard input"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    serve = actions.add_parser("serve", help="serve a project's messages until stopped")
    serve.add_argument("--project", type=Path, default=Path(), help="project folder (default: here)")
    serve.set_defaults(run=run_serve)
    _add_readers(actions)
    _add_writers(actions)


def _add_readers(actions: Any) -> None:
    listing = actions.add_parser("list", help="what a running server has")
    listing.add_argument("store", nargs="?", default="", help="only of this store")
    listing.add_argument("--json", action="store_true", help="print one JSON list")
    listing.set_defaults(run=client.run_list)
    show = actions.add_parser("show", help="print one message as YAML")
    _add_entry(show)
    _add_form(show)
    show.set_defaults(run=client.run_show)
    take = actions.add_parser("take", help="print the oldest message of a queue and remove it")
    take.add_argument("store", help="such as grasps")
    _add_form(take)
    take.set_defaults(run=client.run_show, name="")
    watch = actions.add_parser("watch", help="print each change as it comes, until stopped")
    watch.add_argument("store", nargs="?", default="", help="only of this store")
    watch.add_argument("--count", type=int, default=0, metavar="N", help="end after N changes")
    watch.add_argument("--json", action="store_true", help="print one JSON object a line, with the value")
    watch.set_defaults(run=client.run_watch)


def _add_writers(actions: Any) -> None:
    add = actions.add_parser("add", help="add or replace a message")
    _add_entry(add)
    push = actions.add_parser("push", help="add a message to the end of a queue")
    push.add_argument("store", help="such as grasps")
    push.set_defaults(name="")
    for parser in (add, push):
        parser.add_argument("value", nargs="?", help=_VALUE)
        parser.add_argument("--file", type=Path, help="take the value from a file")
        parser.add_argument("--topic", help="take the next message of a topic")
        parser.add_argument("--within", type=float, default=10.0, help="how long to wait for it [s] (default: 10)")
        parser.add_argument("--type", default="", help="ROS type of the messages of a new store")
        parser.add_argument("--by", default="", help="who or what it comes from, for people")
        parser.set_defaults(run=client.run_add)
    delete = actions.add_parser("delete", help="remove one message")
    _add_entry(delete)
    delete.set_defaults(run=client.run_delete)
    reset = actions.add_parser("reset", help="empty a store, or all, and read the project's files again")
    reset.add_argument("store", nargs="?", default="", help="only this one (default: all)")
    reset.set_defaults(run=client.run_reset)
    save = actions.add_parser("save", help="keep everything over restarts of the server")
    save.set_defaults(run=client.run_save)


def _add_entry(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("store", help="such as poses, joint_states")
    parser.add_argument("name", help="of the message")


def _add_form(parser: argparse.ArgumentParser) -> None:
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--message", action="store_true", help="print the ROS message field by field, with its header")
    form.add_argument("--json", action="store_true", help="print one JSON object: the message, when and by whom")


def run_serve(args: argparse.Namespace) -> int:
    """Serve until SIGINT or SIGTERM."""
    over = threading.Event()
    on_stop(over.set)
    project = find_project(args.project)
    with Bus("grip_messages") as bus:
        with client.told_of_building():
            MessageServer(bus, project.folder / "messages", project.state_folder / ARCHIVE)
        print(f"serving the messages of {project.folder} under /grip/messages", flush=True)
        while not over.wait(1.0):
            pass
    return 0
