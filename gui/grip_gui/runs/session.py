"""The run under way: its process, which a supervisor sees to, and what it has said."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from grip_bt.app.runs import execute
from grip_bt.app.runs.mocks import scripted
from grip_bt.app.runs.supervisor import Supervisor, Told
from grip_gui.wire.runs import Breakpoint, Held, RunOptions, RunState, SessionView

log = logging.getLogger(__name__)
_STATES: dict[str, RunState] = {"running": "running", "paused": "paused", "stopping": "stopping"}
_Place: TypeAlias = tuple[str, str, str | None, str]
"""Node, when, outcome and condition of a breakpoint."""
Launch: TypeAlias = Callable[[Path, Path, RunOptions, Told], Supervisor]
"""Starts a run of a task's file, which writes to a journal, and tells of its events in another thread."""


def start_run(task_file: Path, journal: Path, options: RunOptions, told: Told) -> Supervisor:
    """Start a run in a process of its own."""
    journal.parent.mkdir(parents=True, exist_ok=True)
    fields = options.model_dump(exclude={"mocks"}) | {"journal": journal, "watchdog": execute.WATCHDOG}
    given = execute.RunOptions(**fields, mocks=scripted(options.mocks))
    supervisor = Supervisor(str(task_file), given, told, given.watchdog, own_input=False)
    supervisor.start()
    return supervisor


class Session:
    """One run in its own process; `changed` is called after each change of `view`, and when the journal has more."""

    def __init__(self, view: SessionView, changed: Callable[[], None]):
        self.view = view
        self._changed = changed
        self._run: str | None = None
        self._wanted: set[_Place] = set()
        self._set_points: dict[_Place, int] = {}

    async def start(self, launch: Launch, task_file: Path, journal: Path, options: RunOptions) -> None:
        """Start the process. Raises GripError where it can't be."""
        loop = asyncio.get_running_loop()

        def told(event: Mapping[str, Any]) -> None:
            with suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(self._heard, event)

        self._process = await asyncio.to_thread(launch, task_file, journal, options, told)
        self._life = asyncio.create_task(self._live())

    @property
    def over(self) -> bool:
        """Whether its process has ended."""
        return self.view.state == "ended"

    def send(self, fields: Mapping[str, Any]) -> None:
        """Pass a command of the control protocol on."""
        if not self.over:
            self._set(message="" if self.view.state != "starting" else self.view.message)
            self._process.send(fields)

    async def stop(self) -> None:
        """Stop the run; its process has ended afterwards."""
        if not self.over:
            self._set(state="stopping", held=None)
            self._process.stop()
        await asyncio.shield(self._life)

    def hold_at(self, points: Sequence[Breakpoint]) -> None:
        """Set these breakpoints, and clear all others."""
        self._wanted = {(p.node.strip("/") or "/", p.when, p.outcome, p.condition) for p in points}
        for key, number in list(self._set_points.items()):
            if key not in self._wanted:
                del self._set_points[key]
                self._process.send({"command": "clear", "id": number})
        for key in self._wanted - self._set_points.keys():
            node, when, outcome, condition = key
            request = {"command": "break", "node": node, "when": when, "outcome": outcome, "if": condition}
            self._process.send({name: value for name, value in request.items() if value})

    async def _live(self) -> None:
        end = await asyncio.to_thread(self._process.wait)
        outcome = end.get("outcome")
        self._set(
            state="ended",
            status=end.get("status", "died"),
            outcome=outcome,
            held=None,
            message="" if outcome else end.get("message", "")[:4000],  # of an outcome, the journal has it
            contradiction=end.get("contradiction", ""),
            rest=end.get("rest", ""),
            zombies=end.get("zombies", []),
            unconfirmed=list(end.get("unconfirmed", ())),
        )
        self._changed()

    def _heard(self, message: Mapping[str, Any]) -> None:
        match message:
            case {"event": "started", "run": str(run)}:
                self._run = run
                self._set(state="running", message="")
            case {"event": "committed"}:
                # Only now the run is in the journal for sure, so that viewers may ask for it.
                self._set(run=self._run)
                self._changed()
            case {"event": "state", "state": str(word)} if word in _STATES:
                if self.view.state != "stopping":
                    self._set(state=_STATES[word], held=self.view.held if word == "paused" else None)
            case {"event": "held"}:
                with suppress(ValidationError):
                    self._set(held=Held.model_validate({k: message[k] for k in Held.model_fields if k in message}))
            case {"event": "breakpoint", "id": int(number)}:
                self._breakpoint_is_set(message, number)
            case {"event": "refused", "message": str(why)}:
                log.warning("the run refused: %s", why)
                self._set(message=f"The run refused: {why}"[:1000])
            case {"event": "progress", "part": str(part), "detail": str(detail)} if self.view.state == "starting":
                self._set(message=f"{part}: {detail}"[:200])

    def _breakpoint_is_set(self, facts: Mapping[str, Any], number: int) -> None:
        key = (str(facts.get("node")), str(facts.get("when")), facts.get("outcome"), str(facts.get("if") or ""))
        if key in self._wanted:
            self._set_points[key] = number
        else:  # it was taken back before the run had answered
            self._process.send({"command": "clear", "id": number})

    def _set(self, **changes: object) -> None:
        if any(getattr(self.view, key) != value for key, value in changes.items()):
            self.view = self.view.model_copy(update=changes)
            self._changed()
