"""The address of a page, a task, and a launcher whose runs play recorded events instead of starting a process."""

from __future__ import annotations

import asyncio
import warnings
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.runtime import Journal, RunLog
from grip_gui.processes import ChildProcess
from grip_gui.wire.runs import RunOptions

with warnings.catch_warnings():
    # Starlette's client asks for the successor of httpx, which does the same here.
    warnings.filterwarnings("ignore", message="Using `httpx` with `starlette.testclient`")
    from starlette.testclient import TestClient as TestClient

BASE = "http://127.0.0.1:8765"
SOCKET = "ws://127.0.0.1:8765/api/socket"
TASK = """\
grip: 1
name: tiny
doc: Two waits, then a machine.
data:
  count: {type: int, value: 0, doc: how often}
root:
  kind: sequence
  children:
    first: {node: flow/wait, with: {seconds: 0.1}}
    machine:
      kind: state_machine
      initial: a
      data: {count: int}
      outcomes: {success: success, failure: failure}
      children:
        a: {node: flow/wait, with: {seconds: 0.1}, on: {success: b}}
        b: {node: flow/wait, with: {seconds: 0.1}, on: {success: success}}
"""
EVENTS: list[tuple[str, str, str | None, dict[str, Any]]] = [
    ("/", "run_started", None, {}),
    ("/", "enter", None, {}),
    ("first", "enter", None, {}),
    ("first", "write", None, {"variable": "count", "type": "int", "preview": "1"}),
    ("first", "exit", "success", {}),
    ("machine", "enter", None, {}),
    ("machine/a", "enter", None, {}),
]

POINT = ("node", "when", "outcome", "if")


def until(socket: Any, wanted: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    """Return the first frame that `wanted` accepts."""
    while not wanted(frame := socket.receive_json()):
        pass
    return dict(frame)


def record(file: Path, events: list[Any] = EVENTS, status: str | None = None) -> str:
    """Write a run, as the runner does; return its id."""
    with Journal(file) as journal:
        log = journal.begin("tiny", "tasks/tiny.yaml", TASK, "bt", 7)
        write(log, events)
        if status is not None:
            log.end(status, None)
    return log.id


def write(log: RunLog, events: list[Any]) -> None:
    for i, (path, event, outcome, data) in enumerate(events):
        log.append(i * 0.5, path, event, outcome, None, data)


@dataclass
class PlayedRun(ChildProcess):
    """A run process that writes recorded events to the journal and obeys commands, unless it is deaf or dies."""

    journal: Path
    deaf: bool = False
    dies: bool = False
    contradicted: str = ""
    rest: Mapping[str, Any] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)
    heard: list[dict[str, Any]] = field(default_factory=list)
    killed: bool = False

    def __post_init__(self) -> None:
        self.points = 0
        self.messages: asyncio.Queue[dict[str, Any] | None] = asyncio.Queue()
        self.ended: asyncio.Future[int] = asyncio.get_running_loop().create_future()
        self.file = Journal(self.journal)
        self.log = self.file.begin("tiny", "tasks/tiny.yaml", TASK, "bt", 7)
        write(self.log, EVENTS)
        self.file.flush()
        self.tell(event="log", text="the world starts")
        self.tell(event="started", run=self.log.id, journal=str(self.journal))
        self.tell(event="committed", seq=len(EVENTS))
        self.tell(event="state", state="running")
        if self.dies:
            self.end(70)
        if self.contradicted:
            told = f"the simulator's referee disagrees: {self.contradicted}"
            self.tell(event="ended", status="success", outcome="done", contradiction=self.contradicted, message=told)
            self.end(3)

    def tell(self, **message: Any) -> None:
        self.messages.put_nowait(message)

    def end(self, status: int) -> None:
        if not self.ended.done():
            self.file.close()
            self.messages.put_nowait(None)
            self.ended.set_result(status)

    async def follow(self, heard: Callable[[dict[str, Any]], Awaitable[None]]) -> None:
        while (message := await self.messages.get()) is not None:
            await heard(message)

    async def send(self, fields: Mapping[str, Any]) -> None:
        command = fields["command"]
        self.said.append(command)
        self.heard.append(dict(fields))
        if self.deaf:
            return
        if command == "break":
            self.points += 1
            self.tell(event="breakpoint", id=self.points, **{key: fields.get(key) for key in POINT})
        elif command == "run_to" and fields["node"] == "nowhere":
            self.tell(event="refused", message="unknown node 'nowhere'", command="run_to")
        elif command in {"run_to", "step"}:
            place = {"path": fields.get("node", "first"), "when": "before", "why": command}
            self.tell(event="held", **place, breakpoint=None, outcome=None, code=None, message=None)
            self.tell(event="state", state="paused")
        elif command in {"pause", "resume"}:
            self.tell(event="state", state="paused" if command == "pause" else "running")
        elif command == "stop":
            self.tell(event="state", state="stopping")
            write(self.log, [("/", "run_ended", None, {"status": "stopped"})])
            self.log.end("stopped", None)
            self.file.flush()
            self.tell(event="ended", status="stopped", outcome=None, **self.rest)
            self.end(130)

    async def wait(self) -> int:
        return await asyncio.shield(self.ended)

    async def kill(self) -> None:
        self.killed = True
        self.end(-9)

    def tail(self) -> str:
        return "Traceback: something broke" if self.dies else ""


@dataclass
class PlayedLauncher:
    """Makes `PlayedRun`s."""

    deaf: bool = False
    dies: bool = False
    contradicted: str = ""
    rest: Mapping[str, Any] = field(default_factory=dict)
    started: list[tuple[Path, RunOptions]] = field(default_factory=list)
    last: PlayedRun | None = None

    async def __call__(self, task_file: Path, journal: Path, options: RunOptions) -> PlayedRun:
        self.started.append((task_file, options))
        self.last = PlayedRun(journal, self.deaf, self.dies, self.contradicted, self.rest)
        return self.last
