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
from grip_gui.runs.session import STOP, Launch, Session
from grip_gui.wire.runs import Breakpoint, Control, RunOptions, SessionView, SharedState

log = logging.getLogger(__name__)


class BusyError(GripError):
    """A run is under way, or none is where one is needed."""


class RunControl:
    """The run under way, if any.

    Args:
        launch: starts a process.
        journal: the file that runs are written to; breakpoints are kept beside it.
        source: where the end of a run is entered whose process died.

    Attributes:
        viewers: events that are set whenever something has changed.
    """

    def __init__(self, launch: Launch, journal: Path, source: JournalRuns):
        self._launch, self._journal, self._source = launch, journal, source
        self.session: Session | None = None
        self._shown: SessionView | None = None
        self.presence = Presence(self.notify)
        self._breakpoints = Breakpoints(journal.parent / "breakpoints.json")
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
            holder=seen.holder, connections=seen.connections, viewers=seen.viewers, breakpoints=self._breakpoints.all
        )

    async def start(
        self, task: str, task_file: Path, options: RunOptions, page: str = "", run_to: str = ""
    ) -> SessionView:
        """Start a run of a task's file, as the page `page` asks; it holds before the node `run_to`, empty for none.

        Raises:
            ControlTakenError: another page holds control.
            BusyError: another one is under way.
            OSError: its process can't be started.
        """
        self.presence.require(page)
        if self._starting or (self.session and not self.session.over):
            raise BusyError("a run is under way; stop it before starting another one")
        self._starting = True
        try:
            process = await self._launch(task_file, self._journal, options)
        finally:
            self._starting = False
        view = SessionView(state="starting", task=task, **options.model_dump())
        self.session = Session(process, view, self.notify, self._source)
        # The process keeps what comes before there is a run, so that no breakpoint is set too late.
        await self.session.hold_at(self._breakpoints.of(task))
        if run_to:
            await self.session.command({"command": "run_to", "node": run_to})
        self.notify()
        return self.session.view

    async def command(self, request: Control) -> SessionView:
        """Pass a command to the run under way; `stop` returns when its process has ended, and is anybody's."""
        if self.session is None:
            raise BusyError("no run was started")
        if request.command != "stop":
            self.presence.require(request.page)
        await self.session.command(request.fields())
        return self.session.view

    def follow_edit(self, task: str, steps: Sequence[Step]) -> None:
        """Let the breakpoints of a task follow an edit of it; a run under way goes on with those that it has."""
        try:
            self._breakpoints.follow(task, steps)
        except OSError as error:
            log.warning("the breakpoints of %s aren't kept: %s", task, error)

    async def set_breakpoints(self, task: str, points: Sequence[Breakpoint], page: str = "") -> SharedState:
        """Replace the breakpoints of a task, also in the run under way."""
        self.presence.require(page)
        self._breakpoints.set(task, points)
        if self.session is not None and not self.session.over and self.session.view.task == task:
            await self.session.hold_at(self._breakpoints.of(task))
        self.notify()
        return self.shared_state

    async def close(self) -> None:
        """Stop the run under way; afterwards no process of it is left."""
        if self.session is not None:
            await self.session.command(STOP)

    def notify(self) -> None:
        """Wake all viewers."""
        for event in self.viewers:
            event.set()


_FILE: TypeAdapter[dict[str, list[Breakpoint]]] = TypeAdapter(dict[str, list[Breakpoint]])


class Breakpoints:
    """Where runs hold, for each task of the project: kept beside the journal, not in the task.

    Args:
        file: where they are kept; one that can't be read counts as empty.
    """

    def __init__(self, file: Path):
        self._file = file
        self.all: dict[str, list[Breakpoint]] = {}
        try:
            self.all = _FILE.validate_json(file.read_bytes())
        except FileNotFoundError:
            pass
        except (OSError, ValidationError) as error:
            log.warning("breakpoints of %s left out: %s", file, str(error).splitlines()[0])

    def of(self, task: str) -> list[Breakpoint]:
        """Return those of one task."""
        return self.all.get(task, [])

    def follow(self, task: str, steps: Sequence[Step]) -> None:
        """Let the breakpoints of nodes that an edit has renamed or moved go with them; those of removed nodes stay."""
        points = self.of(task)
        moved = [p.model_copy(update={"node": path_after(p.node, steps) or p.node}) for p in points]
        if moved != points:
            self.set(task, moved)

    def set(self, task: str, points: Sequence[Breakpoint]) -> None:
        """Replace those of one task; each place once."""
        once = {(p.node, p.when, p.outcome): p for p in points}
        self.all = {**self.all, task: list(once.values())}
        if not once:
            self.all.pop(task, None)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        replace_text(self._file, _FILE.dump_json(self.all, indent=1).decode() + "\n")
