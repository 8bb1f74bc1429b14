"""Control of a run over two streams: one JSON object a line, commands in, events out; see `docs/protocols.md`."""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TextIO, TypedDict

from grip_bt.base.errors import ExpressionError, GripError, UnknownNameError
from grip_bt.base.types import JsonObject
from grip_bt.base.value_codec import preview

from .result import RunResult
from .runner import Runner

COMMANDS = ("pause", "resume", "step", "run_to", "break", "clear", "breakpoints", "inspect", "preempt", "fault", "stop")


GONE = "the controlling process went away without a stop"


class RunEnd(TypedDict, total=False):
    """The event `ended` of a run, or `failed` where none could be run; `truth` is the referee's word."""

    event: str
    run: str | None
    status: str
    outcome: str | None
    code: str | None
    message: str
    path: str
    duration: float
    ticks: int | None
    zombies: list[str]
    rest: str
    unconfirmed: dict[str, str]
    truth: dict[str, str]
    judged: dict[str, bool]
    contradiction: str


class Control:
    """One end of the protocol; `lost` says whether whoever controls the run has gone, without a stop.

    Args:
        interrupt: called by a stop that comes before there is a run; it has whatever starts the run end.
    """

    def __init__(self, commands: TextIO, events: TextIO, interrupt: Callable[[], None] = lambda: None):
        self._commands, self._events, self._interrupt = commands, events, interrupt
        self._writing, self._lock = threading.RLock(), threading.RLock()
        self._runner: Runner | None = None
        self._early: list[JsonObject] = []
        self._stopped = self.lost = False
        self.order: queue.SimpleQueue[JsonObject | None] = queue.SimpleQueue()
        """The line that says what is to be run after this, which ends the control of this run; None: nothing will."""

    def start(self) -> None:
        threading.Thread(target=self._obey, name="grip_control", daemon=True).start()

    def send(self, event: str, **fields: object) -> None:
        """Write one event, from any thread and from signal handlers; a reader that went away has gone altogether."""
        try:
            with self._writing:
                self._events.write(json.dumps({"event": event, **fields}, default=str) + "\n")
                self._events.flush()
        except (OSError, ValueError, RuntimeError):
            self.stop(lost=True)

    def stop(self, lost: bool = False) -> None:
        """Stop the run, or the start of one; it is `lost` where whoever controls it has gone without saying so."""
        with self._lock:
            first, self._stopped, runner = not self._stopped, True, self._runner
            self.lost = self.lost or (lost and first)
            if runner is None and first:
                self._interrupt()
        if runner is not None:
            self.end(runner)
        elif first:
            self.send("state", state="stopping")

    def end(self, runner: Runner) -> None:
        if self.lost:
            runner.lose(GONE)
        else:
            runner.stop()

    def leave(self) -> None:
        """Control nothing any more: the run is over, and all that it had is closed."""
        with self._lock:
            self._runner, self._stopped = None, True

    def attach(self, runner: Runner) -> None:
        """Control this run from now on; obey what came before it."""
        journal = runner.journal
        if journal is not None:
            journal.on_commit(lambda run, seq: self.send("committed", seq=seq) if run == runner.run_id else None)
        runner.pacing.on_state(lambda state: self.send("state", state=state))

        def held(place: Any) -> None:
            if journal is not None:
                journal.flush()
            self.send("held", **vars(place))

        runner.debugger.on_held(held)
        if journal is not None:
            journal.flush()  # whatever happens to this process, the run is in the journal
        self.send("started", run=runner.run_id, journal=str(journal.file) if journal is not None else None)
        if runner.pacing.state == "paused":
            self.send("state", state="paused")
        with self._lock:
            self._runner = runner
            early, self._early = self._early, []
        if self._stopped:
            self.end(runner)
        for command in early:
            self._do(runner, command)

    def run(self, more: Callable[[RunResult], RunEnd] = lambda _: {}) -> RunResult:
        """Run to the end in this thread, and tell of it; after `attach`.

        Args:
            more: returns what else is to be told of the end, or in place of other facts, as JSON data.
        """
        assert self._runner is not None, "attach a runner first"
        result = self._runner.run()
        if self._runner.journal is not None:
            self._runner.journal.flush()
        self.send("ended", **{**result_facts(result), **more(result)})
        return result

    def _obey(self) -> None:
        for line in _lines(self._commands):
            try:
                command = json.loads(line)
                if "task" in command:
                    return self.order.put(command)
                if command["command"] not in COMMANDS:
                    raise KeyError(command["command"])
            except (ValueError, KeyError, TypeError):
                allowed = ", ".join(COMMANDS)
                self.send("refused", message=f"not a command: {line.strip()[:80]!r} (available: {allowed})")
                continue
            with self._lock:
                runner = self._runner
                if runner is None and command["command"] != "stop":
                    self._early.append(command)
                    continue
            if command["command"] == "stop":
                self.stop()
            elif runner is not None:
                self._do(runner, command)
        self.stop(lost=True)
        self.order.put(None)

    def _do(self, runner: Runner, command: JsonObject) -> None:
        try:
            _ACTIONS[command["command"]](self, runner, command)
        except (GripError, LookupError, TypeError, ValueError, AttributeError) as error:
            said = str(error) if isinstance(error, GripError) else f"{command['command']}: {error!r}"
            self.send("refused", message=said, command=command["command"])

    def _break(self, runner: Runner, command: JsonObject) -> None:
        how = command.get("when") or "", command.get("outcome"), command.get("if") or ""
        self.send("breakpoint", **runner.debugger.set(_text(command, "node"), *how).facts())

    def _breakpoints(self, runner: Runner, command: Mapping[str, object]) -> None:
        held = runner.debugger.at
        self.send(
            "breakpoints",
            breakpoints=[point.facts() for point in runner.debugger.breakpoints],
            at=None if held is None else vars(held),
        )

    def _inspect(self, runner: Runner, command: JsonObject) -> None:
        wanted = command.get("variable")
        data = runner.compiled.data.snapshot()
        if wanted is not None and all(name != wanted for _, name in data):
            raise UnknownNameError("written variable", wanted, {name for _, name in data})
        found = [
            {"scope": scope or "/", "name": name, "value": preview(value)}
            for (scope, name), value in data.items()
            if wanted in (None, name)
        ]
        self.send("data", variables=found)


def _text(command: Mapping[str, object], key: str) -> str:
    value = command.get(key)
    if not isinstance(value, str):
        raise ExpressionError(json.dumps(dict(command)), f"{command['command']!r} needs {key!r}, a text")
    return value


_ACTIONS: dict[str, Callable[[Control, Runner, JsonObject], object]] = {
    "pause": lambda control, runner, command: runner.pause(),
    "resume": lambda control, runner, command: runner.resume(),
    "step": lambda control, runner, command: runner.step(command.get("how") or "tick"),
    "run_to": lambda control, runner, command: runner.debugger.run_to(
        _text(command, "node"), command.get("when") or ""
    ),
    "break": Control._break,
    "clear": lambda control, runner, command: control.send(
        "cleared", ids=list(runner.debugger.clear(command.get("id")))
    ),
    "breakpoints": Control._breakpoints,
    "inspect": Control._inspect,
    "preempt": lambda control, runner, command: runner.request_preempt(),
    "fault": lambda control, runner, command: runner.inject(_text(command, "fault")),
}


def result_facts(result: RunResult) -> RunEnd:
    """Return how a run has ended as the control protocol says it."""
    return {
        "status": result.status,
        "outcome": result.outcome,
        "code": result.failure.code if result.failure else None,
        "message": str(result.error or result.failure or ""),
        "duration": result.duration,
        "ticks": result.ticks,
        "zombies": [str(zombie) for zombie in result.zombies],
        "rest": str(result.rest),
        "unconfirmed": dict(result.rest.unconfirmed),
    }


def serve_control(
    runner: Runner, commands: TextIO, events: TextIO, more: Callable[[RunResult], RunEnd] = lambda _: {}
) -> RunResult:
    """Run to the end in this thread, obeying commands meanwhile; see `Control.run`."""
    control = Control(commands, events)
    control.attach(runner)
    control.start()
    return control.run(more)


def _lines(stream: TextIO) -> Iterator[str]:
    try:
        yield from (line for line in stream if line.strip())
    except (OSError, ValueError):
        return
