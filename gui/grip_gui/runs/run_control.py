"""Starts and controls runs, one at a time, for the one page that holds control; tells all viewers of every change.

A run has a process of its own, which a supervisor sees to.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import TypeAdapter, ValidationError

from grip_bt.app.runs import execute
from grip_bt.app.runs.mocks import scripted
from grip_bt.app.runs.supervisor import EventListener, Supervisor
from grip_bt.base.errors import GripError
from grip_bt.base.files import replace_text
from grip_bt.task.edit import path_after
from grip_bt.task.edit.steps import Step
from grip_gui.runs.journal import JournalRuns
from grip_gui.runs.pages import Presence
from grip_gui.wire.runs import Breakpoint, Control, Held, RunOptions, RunState, SessionView, SharedState

log = logging.getLogger(__name__)
_FILE: TypeAdapter[dict[str, list[Breakpoint]]] = TypeAdapter(dict[str, list[Breakpoint]])
_STATES: dict[str, RunState] = {"running": "running", "paused": "paused", "stopping": "stopping"}
_Place: TypeAlias = tuple[str, str, str | None, str]
"""Node, when, outcome and condition of a breakpoint."""
Launch: TypeAlias = Callable[[Path, Path, RunOptions, EventListener], Supervisor]
"""Starts a run of a task's file, which writes to a journal, and tells of its events in another thread."""


def start_run(task_file: Path, journal: Path, options: RunOptions, told: EventListener) -> Supervisor:
    """Start a run in a process of its own."""
    journal.parent.mkdir(parents=True, exist_ok=True)
    fields = options.model_dump(exclude={"mocks"}) | {"journal": journal, "watchdog": execute.WATCHDOG}
    given = execute.RunOptions(**fields, mocks=scripted(options.mocks))
    supervisor = Supervisor(str(task_file), given, told, given.watchdog, terminal=False)
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


class BusyError(GripError):
    """A run is under way, or none is where one is needed."""


class RunControl:
    """The run under way, if any; breakpoints are kept beside the file of the journal.

    Attributes:
        viewers: events that are set whenever something has changed.
    """

    def __init__(self, launch: Launch, journal: Path, source: JournalRuns):
        self._launch, self._journal, self._source = launch, journal, source
        self.session: Session | None = None
        self._shown: SessionView | None = None
        self.presence = Presence(self.notify)
        self._file = journal.parent / "breakpoints.json"
        self._breakpoints = _kept(self._file)
        self._starting = False
        self.viewers: set[asyncio.Event] = set()

    @property
    def view(self) -> SessionView | None:
        """How the run under way, or the last one, is."""
        return self.session.view if self.session else self._shown

    @property
    def run_under_way(self) -> str:
        """Its id in the journal; empty for none."""
        return (self.session.view.run or "") if self.session is not None and not self.session.over else ""

    def show(self, run: str) -> None:
        """Have pages show a run of the journal as if it had just ended here, until one is started."""
        record = self._source.run(run)
        self._shown = SessionView(
            state="ended",
            task=record.task_path,
            target="sm" if record.target == "sm" else "bt",
            seed=record.seed or 0,
            pace=None,
            run=run,
            status=record.status,
            outcome=record.outcome,
        )

    @property
    def shared_state(self) -> SharedState:
        """What all pages share."""
        seen = self.presence
        return SharedState(
            holder=seen.holder, connections=seen.connections, viewers=seen.viewers, breakpoints=self._breakpoints
        )

    async def start(
        self, task: str, task_file: Path, options: RunOptions, page: str = "", run_to: str = ""
    ) -> SessionView:
        """Start a run of a task's file, as the page `page` asks; it holds before the node `run_to`, empty for none.

        Raises:
            ControlTakenError: another page holds control.
            BusyError: another one is under way.
            GripError: its process can't be started.
        """
        self.presence.require(page)
        if self._starting or (self.session and not self.session.over):
            raise BusyError("a run is under way; stop it before starting another one")
        self._starting = True
        session = Session(SessionView(state="starting", task=task, **options.model_dump()), self.notify)
        try:
            await session.start(self._launch, task_file, self._journal, options)
        finally:
            self._starting = False
        self.session = session
        # The process keeps what comes before there is a run, so that no breakpoint is set too late.
        session.hold_at(self._breakpoints.get(task, []))
        if run_to:
            session.send({"command": "run_to", "node": run_to})
        self.notify()
        return self.session.view

    async def command(self, request: Control) -> SessionView:
        """Pass a command to the run under way; `stop` returns when its process has ended, and is anybody's."""
        if self.session is None:
            raise BusyError("no run was started")
        if request.command == "stop":
            await self.session.stop()
        else:
            self.presence.require(request.page)
            self.session.send(request.fields())
        return self.session.view

    def follow_edit(self, task: str, steps: Sequence[Step]) -> None:
        """Let the breakpoints of nodes that an edit moved go with them; those of removed nodes stay, for an undo.

        A run under way goes on with those that it has.
        """
        points = self._breakpoints.get(task, [])
        moved = [p.model_copy(update={"node": path_after(p.node, steps) or p.node}) for p in points]
        if moved != points:
            try:
                self._set_breakpoints(task, moved)
            except OSError as error:
                log.warning("the breakpoints of %s aren't kept: %s", task, error)

    def set_breakpoints(self, task: str, points: Sequence[Breakpoint], page: str = "") -> SharedState:
        """Replace the breakpoints of a task, also in the run under way."""
        self.presence.require(page)
        self._set_breakpoints(task, points)
        if self.session is not None and not self.session.over and self.session.view.task == task:
            self.session.hold_at(self._breakpoints.get(task, []))
        self.notify()
        return self.shared_state

    async def close(self) -> None:
        """Stop the run under way; afterwards no process of it is left."""
        if self.session is not None:
            await self.session.stop()

    def notify(self) -> None:
        """Wake all viewers."""
        for event in self.viewers:
            event.set()

    def _set_breakpoints(self, task: str, points: Sequence[Breakpoint]) -> None:
        """Replace those of one task; each place once."""
        once = {(p.node, p.when, p.outcome): p for p in points}
        others = {other: kept for other, kept in self._breakpoints.items() if other != task}
        self._breakpoints = others | ({task: list(once.values())} if once else {})
        self._file.parent.mkdir(parents=True, exist_ok=True)
        replace_text(self._file, _FILE.dump_json(self._breakpoints, indent=1).decode() + "\n")


def _kept(file: Path) -> dict[str, list[Breakpoint]]:
    """Return task -> its breakpoints, from a file; nothing from one that can't be read."""
    try:
        return _FILE.validate_json(file.read_bytes()) if file.exists() else {}
    except (OSError, ValidationError) as error:
        log.warning("breakpoints of %s left out: %s", file, str(error).splitlines()[0])
        return {}
