"""Starts and controls runs, one at a time, for the one page that holds control; tells all viewers of every change."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Sequence
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from grip_bt.base.errors import GripError
from grip_bt.base.files import replace_text
from grip_bt.task.edit import path_after
from grip_bt.task.edit.steps import Step
from grip_gui.runs.journal import JournalRuns
from grip_gui.runs.pages import Presence
from grip_gui.runs.session import Launch, Session
from grip_gui.wire.runs import Breakpoint, Control, RunOptions, SessionView, SharedState

log = logging.getLogger(__name__)
_FILE: TypeAdapter[dict[str, list[Breakpoint]]] = TypeAdapter(dict[str, list[Breakpoint]])


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
