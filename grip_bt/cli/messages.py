"""`grip messages`: serve a project's named messages over ROS 2, and ask a server that runs."""

from __future__ import annotations

import argparse
import json
import queue
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

from grip_bt.app.project.folder import find_project
from grip_bt.app.wiring.parts import report_if_slow
from grip_bt.base.errors import GripError, plural
from grip_bt.base.failures import ServerLostError, ServerTimeOutError
from grip_bt.base.message_store.text import plain_of, text_of
from grip_bt.base.operation import Operation
from grip_bt.base.yaml.tree import read_file
from grip_bt.cli.parser import add_actions
from grip_bt.cli.signals import on_stop
from grip_bt.cli.terminal import tell
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.types import type_name
from grip_bt.ros.messages.service import MessageServer, RosMessages
from grip_bt.ros.messages.wire import entry_rows, message_of, pack, text_of_entry

T = TypeVar("T")
ARCHIVE = "messages.sqlite"


def add_messages(parser: argparse.ArgumentParser) -> None:
    serve, listing, show, take, watch, add, push, delete, reset, _ = add_actions(
        parser,
        {
            "serve": (_run_serve, "serve a project's messages until stopped"),
            "list": (_run_list, "list what a running server holds"),
            "show": (_run_show, "print one message as YAML"),
            "take": (_run_show, "print the oldest message of a queue and remove it"),
            "watch": (_run_watch, "print each change as it comes, until stopped"),
            "add": (_run_put, "add or replace a message"),
            "push": (_run_put, "add a message to the end of a queue"),
            "delete": (_run_removal, "remove one message"),
            "reset": (_run_removal, "empty a store, or all, and read the project's files again"),
            "save": (_run_save, "save everything so that it survives a restart of the server"),
        },
    )
    serve.add_argument("--project", type=Path, default=Path(), help="project folder (default: here)")
    for each in (show, add, delete):
        each.add_argument("store", help="such as poses, joint_states")
        each.add_argument("name", help="of the message")
    for each in (take, push):
        each.add_argument("store", help="such as grasps")
        each.set_defaults(name="")
    for each in (listing, watch, reset):
        each.add_argument("store", nargs="?", default="", help="only this one (default: all)")
    for each in (show, take):
        form = each.add_mutually_exclusive_group()
        form.add_argument("--message", action="store_true", help="print the ROS message field by field")
        form.add_argument("--json", action="store_true", help="print one JSON object: the message, when and by whom")
    for each in (add, push):
        each.add_argument("value", nargs="?", help="YAML, as in a project's files or field by field; - for stdin")
        each.add_argument("--file", type=Path, help="take the value from a file")
        each.add_argument("--topic", help="take the next message of a topic")
        each.add_argument("--within", type=float, default=10.0, help="how long to wait for it [s] (default: 10)")
        each.add_argument("--type", default="", help="ROS type of the messages of a new store")
        each.add_argument("--by", default="", help="who or what it comes from, for people")
    listing.add_argument("--json", action="store_true", help="print one JSON list")
    watch.add_argument("--count", type=int, default=0, metavar="N", help="end after N changes")
    watch.add_argument("--json", action="store_true", help="print one JSON object a line, with the value")


def _run_serve(args: argparse.Namespace) -> None:
    over = threading.Event()
    on_stop(over.set)
    project = find_project(args.project)
    with Bus("grip_messages") as bus:
        with _told_of_building():
            MessageServer(bus, project.folder / "messages", project.state_folder / ARCHIVE)
        print(f"serving the messages of {project.folder} under /grip/messages", flush=True)
        while not over.wait(1.0):
            pass


WAIT = 15.0
"""How long a server may take to answer [s]."""
SILENT = 2.0
"""After how long somebody who waits is told what for [s]."""


def _run_list(args: argparse.Namespace) -> None:
    with _server() as server:
        if args.store:
            _done(server.names(args.store))  # tells which stores there are
        answer = _done(server.listing())
    rows, lines = [row for row in entry_rows(answer) if args.store in ("", row["store"])], []
    for row in rows:
        when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(row["time"]))
        lines.append(f"{row['store']:<14} {row['name']:<24} {row['type']:<36} {when}  {row['provenance']}")
    queued = zip(answer.stores, answer.queued, strict=True)
    lines += [f"{store:<14} {count} in the queue" for store, count in queued if count and args.store in ("", store)]
    tell(args.json, rows, lines)
    if not lines and not args.json:
        print("no messages; `grip messages add STORE NAME VALUE` adds one", file=sys.stderr)


def _run_show(args: argparse.Namespace) -> None:
    with _server() as server:
        entry = _done(server.message(args.store, args.name))
    if args.json:
        about = {"store": args.store, "name": entry.name, "time": entry.time, "provenance": entry.provenance}
        print(json.dumps({**about, "type": type_name(type(entry.value)), "message": plain_of(entry.value)}))
    else:
        said = text_of(entry.value) if args.message else text_of_entry(args.store, pack(args.store, entry.value))
        print(said.rstrip() or f"# a {type_name(type(entry.value))}, too large to print")


def _run_put(args: argparse.Namespace) -> None:
    given, by = [way for way in (args.value, args.file, args.topic) if way is not None], args.by or "grip messages"
    if len(given) != 1:
        several = "give the value in one way only" if given else "the value is missing"
        raise GripError(f"{several}: say YAML, `-` (the standard input), `--file FILE` or `--topic TOPIC`")
    with _server() as server:
        if args.topic is not None:
            _done(server.put(args.store, args.name, server.next_of(args.topic, args.type, args.within), by))
        else:
            text = read_file(args.file) if args.file else sys.stdin.read() if args.value == "-" else args.value
            _done(server.put_text(args.store, args.name, text, args.type, by))


def _run_removal(args: argparse.Namespace) -> None:
    with _server() as server:
        _done(server.delete(args.store, args.name) if "name" in args else server.reset(args.store))


def _run_save(args: argparse.Namespace) -> None:
    with _server() as server:
        print(f"{plural(_done(server.save()), 'message')} saved; they survive a restart of the server")


def _run_watch(args: argparse.Namespace) -> None:
    changes: queue.SimpleQueue[tuple[str, str, str, Any]] = queue.SimpleQueue()
    printed = 0
    with _server() as server, suppress(KeyboardInterrupt):
        _done(server.names(args.store)) if args.store else _done(server.listing())  # that there is such a store
        stop = server.watch(lambda *change: changes.put(change))
        print("watching /grip/messages/changes; Ctrl-C ends it", file=sys.stderr, flush=True)
        while not args.count or printed < args.count:
            store, kind, name, value = changes.get()
            if args.store in ("", store):
                print(_change(store, kind, name, value, args.json), flush=True)
                printed += 1
        stop()


def _change(store: str, kind: str, name: str, value: object, as_json: bool) -> str:
    if as_json:
        message = None if value is None else plain_of(message_of(pack(store, value)))
        return json.dumps({"store": store, "change": kind, "name": name, "message": message})
    words = "" if value is None else " ".join(str(value).split())
    return f"{store:<14} {kind:<8} {name:<24} {words[:100]}{'...' if len(words) > 100 else ''}".rstrip()


@contextmanager
def _server() -> Iterator[RosMessages]:
    with Bus("grip_messages_client") as bus:
        with _told_of_building():
            messages = RosMessages(bus)
        try:
            yield messages
        except ServerLostError as error:
            advice = "start one: `grip messages serve` in the project's folder, with the same ROS_DOMAIN_ID"
            raise ServerLostError(f"{error}; {advice}") from error


def _told_of_building() -> AbstractContextManager[None]:
    """Say that the interfaces are being built, where that takes its time: once on a machine."""
    words = "grip: building the interfaces of messages, once; this takes a while ..."
    return report_if_slow(lambda _, said: print(said, file=sys.stderr, flush=True), "messages", lambda: words, SILENT)


def _done(operation: Operation[T]) -> T:
    if not operation.wait(WAIT):
        raise ServerTimeOutError(f"the message server did not answer within {WAIT:.0f} s")
    return operation.result()
