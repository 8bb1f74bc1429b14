"""The run under way: its process, what it has said, and the certainty that STOP ends it."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from grip_bt.base.interpreter import how_ended
from grip_gui.processes import ChildProcess
from grip_gui.runs.journal import JournalRuns
from grip_gui.wire.runs import Breakpoint, Held, RunOptions, RunState, SessionView

log = logging.getLogger(__name__)

ACKNOWLEDGE = 0.5
"""A run that hasn't acknowledged a stop after this time is killed [s]; its parent needs a tenth of that."""
ACKNOWLEDGE_STARTING = 2.0
"""Likewise while it is being started, when Python may still be loading and nothing moves [s]."""
WIND_DOWN = 10.0  # a run that has acknowledged a stop may take this long to end [s]
DRAIN = 1.0  # how long the last lines of a process that has ended are waited for [s]
_STATES: dict[str, RunState] = {"running": "running", "paused": "paused", "stopping": "stopping"}
STOP: Mapping[str, Any] = {"command": "stop"}
_Place: TypeAlias = tuple[str, str, str | None, str]
"""Node, when, outcome and condition of a breakpoint."""


Launch: TypeAlias = Callable[[Path, Path, RunOptions], Awaitable[ChildProcess]]
"""Starts a run of a task's file, which writes to a journal."""


async def start_run(task_file: Path, journal: Path, options: RunOptions) -> ChildProcess:
    """Start `grip run --control`."""
    journal.parent.mkdir(parents=True, exist_ok=True)
    words = ("grip_bt.cli", "run", str(task_file), "--control", "--journal", str(journal), *options.arguments())
    return await ChildProcess.start(*words)


class Session:
    """One run in its own process.

    `changed` is called after each change of `view`, and when new events can be read from the journal `source`.
    """

    def __init__(self, process: ChildProcess, view: SessionView, changed: Callable[[], None], source: JournalRuns):
        self.view = view
        self._process, self._changed, self._source = process, changed, source
        self._acknowledged = asyncio.Event()
        self._killed_because = ""
        self._run: str | None = None
        self._wanted: set[_Place] = set()
        self._set_points: dict[_Place, int] = {}
        self._stopping: asyncio.Task[None] | None = None
        self._life = asyncio.create_task(self._live())

    @property
    def over(self) -> bool:
        """Whether its process has ended."""
        return self.view.state == "ended"

    async def command(self, fields: Mapping[str, Any]) -> None:
        """Pass a command of the control protocol on; `stop` returns when the process has ended."""
        if self.over:
            return
        if fields["command"] != "stop":
            self._set(message="" if self.view.state != "starting" else self.view.message)
            await self._process.send(fields)
            return
        if self._stopping is None:
            self._stopping = asyncio.create_task(self._stop())
        await asyncio.shield(self._stopping)

    async def hold_at(self, points: Sequence[Breakpoint]) -> None:
        """Set these breakpoints, and clear all others."""
        self._wanted = {(p.node.strip("/") or "/", p.when, p.outcome, p.condition) for p in points}
        for key, number in list(self._set_points.items()):
            if key not in self._wanted:
                del self._set_points[key]
                await self._process.send({"command": "clear", "id": number})
        for key in self._wanted - self._set_points.keys():
            node, when, outcome, condition = key
            request = {"command": "break", "node": node, "when": when, "outcome": outcome, "if": condition}
            await self._process.send({name: value for name, value in request.items() if value})

    async def _stop(self) -> None:
        patience = ACKNOWLEDGE_STARTING if self.view.state == "starting" else ACKNOWLEDGE
        self._set(state="stopping", held=None)
        await self._process.send(STOP)
        if not await _within(patience, self._acknowledged.wait()):
            await self._kill(f"The run did not answer STOP within {patience:g} s, so its processes were killed.")
        elif not await _within(WIND_DOWN, asyncio.shield(self._life)):
            await self._kill(f"The run did not end within {WIND_DOWN:g} s of STOP, so its processes were killed.")
        await asyncio.shield(self._life)

    async def _kill(self, why: str) -> None:
        log.warning(why)
        self._killed_because = why
        await self._process.kill()

    async def _live(self) -> None:
        reader = asyncio.create_task(self._process.follow(self._heard))
        status = await self._process.wait()
        await asyncio.wait([reader], timeout=DRAIN)
        reader.cancel()
        with suppress(asyncio.CancelledError):
            await reader
        await self._ended(status)

    async def _heard(self, message: dict[str, Any]) -> None:
        match message:
            case {"event": "started", "run": str(run)}:
                self._run = run
                self._set(state="running", message="")
            case {"event": "committed"}:
                # Only now the run is in the journal for sure, so that viewers may ask for it.
                self._set(run=self._run)
                self._changed()
            case {"event": "state", "state": str(word)} if word in _STATES:
                if word == "stopping":
                    self._acknowledged.set()
                if self._stopping is None or word == "stopping":
                    held = self.view.held if word == "paused" else None
                    self._set(state=_STATES[word], held=held)
            case {"event": "held"}:
                with suppress(ValidationError):
                    self._set(held=Held.model_validate({k: message[k] for k in Held.model_fields if k in message}))
            case {"event": "breakpoint", "id": int(number)}:
                await self._breakpoint_is_set(message, number)
            case {"event": "refused", "message": str(why)}:
                log.warning("the run refused: %s", why)
                self._set(message=f"The run refused: {why}"[:1000])
            case {"event": "ended", "status": str(status)}:
                self._acknowledged.set()
                self._set(status=status, held=None, **_end(message))
                self._changed()
            case {"event": "log", "text": str(text)}:
                log.info("run: %s", text)
                if self.view.state == "starting" and text.strip():
                    self._set(message=text.strip()[:200])

    async def _breakpoint_is_set(self, facts: Mapping[str, object], number: int) -> None:
        key = (str(facts.get("node")), str(facts.get("when")), facts.get("outcome"), str(facts.get("if") or ""))
        if key in self._wanted:
            self._set_points[key] = number
        else:  # it was taken back before the run had answered
            await self._process.send({"command": "clear", "id": number})

    async def _ended(self, exit_status: int) -> None:
        self._acknowledged.set()
        status, why = self.view.status, self._killed_because or self.view.message
        if status is None and self._killed_because:
            status = "killed"
            if self.view.run is not None:
                await asyncio.to_thread(self._source.end_run, self.view.run)
        elif status is None:
            status, tail = "died", self._process.tail()  # its journal knows that, and it can be resumed
            said = f"Last output:\n{tail}" if tail else "No output."
            why = f"The run's process {how_ended(exit_status)} before the task had ended. {said}"
        self._set(state="ended", status=status, message=why)
        self._changed()

    def _set(self, **changes: object) -> None:
        if any(getattr(self.view, key) != value for key, value in changes.items()):
            self.view = self.view.model_copy(update=changes)
            self._changed()


def _end(facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the page is told of the end of a run, besides its status; of messages those of errors."""
    texts = {key: str(facts.get(key) or "")[:4000] for key in ("message", "contradiction", "rest")}
    lists = {key: [str(each)[:500] for each in facts.get(key) or ()] for key in ("zombies", "unconfirmed")}
    message = texts["message"] if facts["status"] == "error" else ""
    return {**texts, **lists, "message": message, "outcome": facts.get("outcome")}


async def _within(seconds: float, something: Awaitable[object]) -> bool:
    try:
        async with asyncio.timeout(seconds):
            await something
    except TimeoutError:
        return False
    return True
