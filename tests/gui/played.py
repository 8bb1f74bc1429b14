"""The address of a page, a task, and a launcher whose runs play recorded events instead of starting a process."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.runtime import Journal, RunLog
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
class PlayedRun:
    """Plays a `Supervisor`: writes recorded events to the journal and obeys commands, unless it dies."""

    journal: Path
    told: Callable[[Mapping[str, Any]], None]
    dies: bool = False
    contradicted: str = ""
    rest: Mapping[str, Any] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)
    heard: list[dict[str, Any]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.points = 0
        self.ended = threading.Event()
        self.end: dict[str, Any] = {}
        self.file = Journal(self.journal)
        self.log = self.file.begin("tiny", "tasks/tiny.yaml", TASK, "bt", 7)
        write(self.log, EVENTS)
        self.file.flush()
        self.tell(event="progress", part="simulator", detail="the world starts")
        self.tell(event="started", run=self.log.id, journal=str(self.journal))
        self.tell(event="committed", seq=len(EVENTS))
        self.tell(event="state", state="running")
        if self.dies:
            self.log.end("error", None)
            self.over(status="error", message="first: the run's process ended with exit status 70; at File count.py")
        if self.contradicted:
            message = f"the simulator's referee disagrees: {self.contradicted}"
            self.over(status="success", outcome="done", contradiction=self.contradicted, message=message)

    def tell(self, **message: Any) -> None:
        self.told(message)

    def over(self, **end: Any) -> None:
        if not self.ended.is_set():
            self.file.close()
            self.end = {"event": "ended", "outcome": None, **end}
            self.ended.set()

    def send(self, fields: Mapping[str, Any]) -> None:
        command = fields["command"]
        self.said.append(command)
        self.heard.append(dict(fields))
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

    def stop(self) -> None:
        if not self.ended.is_set():
            self.said.append("stop")
            self.tell(event="state", state="stopping")
            write(self.log, [("/", "run_ended", None, {"status": "stopped"})])
            self.log.end("stopped", None)
            self.file.flush()
            self.over(status="stopped", **self.rest)

    def wait(self) -> dict[str, Any]:
        self.ended.wait()
        return self.end


@dataclass
class PlayedLauncher:
    """Makes `PlayedRun`s."""

    dies: bool = False
    contradicted: str = ""
    rest: Mapping[str, Any] = field(default_factory=dict)
    started: list[tuple[Path, RunOptions]] = field(default_factory=list)
    last: PlayedRun | None = None

    def __call__(self, task_file: Path, journal: Path, options: RunOptions, told: Any) -> Any:
        self.started.append((task_file, options))
        self.last = PlayedRun(journal, told, self.dies, self.contradicted, self.rest)
        return self.last
