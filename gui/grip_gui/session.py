"""The run under way: its process, what it has said, and the certainty that STOP ends it."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from grip_bt.errors import GripError

from .journal import RunSource
from .launcher import Launcher, RunOptions, RunProcess
from .messages import Command, RunState, SessionView

log = logging.getLogger(__name__)

ACKNOWLEDGE = 2.0
"""A run that hasn't acknowledged a stop after this time is killed [s]."""
WIND_DOWN = 10.0
"""A run that has acknowledged a stop may take this long to end [s]."""
DRAIN = 1.0
"""How long the last lines of a process that has ended are waited for [s]."""
_STATES: dict[str, RunState] = {"running": "running", "paused": "paused", "stopping": "stopping"}


class BusyError(GripError):
    """A run is under way, or none is where one is needed."""


class Session:
    """One run in its own process.

    Args:
        process: the process.
        view: what is known at the start.
        changed: called after each change of `view`, and when new events can be read from the journal.
        source: where the end of the run is entered if its process dies.
    """

    def __init__(
        self,
        process: RunProcess,
        view: SessionView,
        changed: Callable[[], None],
        source: RunSource,
    ):
        self.view = view
        self._process, self._changed, self._source = process, changed, source
        self._acknowledged = asyncio.Event()
        self._killed_because = ""
        self._run: str | None = None
        self._stopping: asyncio.Task[None] | None = None
        self._life = asyncio.create_task(self._live())

    @property
    def over(self) -> bool:
        """Whether its process has ended."""
        return self.view.state == "ended"

    async def command(self, command: Command) -> None:
        """Pass a command on; `stop` returns when the process has ended."""
        if self.over:
            return
        if command != "stop":
            await self._process.send(command)
            return
        if self._stopping is None:
            self._stopping = asyncio.create_task(self._stop())
        await asyncio.shield(self._stopping)

    async def wait(self) -> None:
        """Wait until the process has ended."""
        await asyncio.shield(self._life)

    async def _stop(self) -> None:
        self._set(state="stopping")
        await self._process.send("stop")
        if not await _within(ACKNOWLEDGE, self._acknowledged.wait()):
            await self._kill(f"The run did not answer STOP within {ACKNOWLEDGE:g} s, so its processes were killed.")
        elif not await _within(WIND_DOWN, asyncio.shield(self._life)):
            await self._kill(f"The run did not end within {WIND_DOWN:g} s of STOP, so its processes were killed.")
        await asyncio.shield(self._life)

    async def _kill(self, why: str) -> None:
        log.warning(why)
        self._killed_because = why
        await self._process.kill()

    async def _live(self) -> None:
        reader = asyncio.create_task(self._read())
        status = await self._process.wait()
        await asyncio.wait([reader], timeout=DRAIN)
        reader.cancel()
        with suppress(asyncio.CancelledError):
            await reader
        await self._ended(status)

    async def _read(self) -> None:
        async for message in self._process.lines():
            self._heard(message)

    def _heard(self, message: dict[str, Any]) -> None:
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
                    self._set(state=_STATES[word])
            case {"event": "ended", "status": str(status)}:
                self._acknowledged.set()
                self._set(status=status, outcome=message.get("outcome"), message="")
                self._changed()
            case {"event": "log", "text": str(text)}:
                log.info("run: %s", text)
                if self.view.state == "starting" and text.strip():
                    self._set(message=text.strip()[:200])

    async def _ended(self, exit_status: int) -> None:
        self._acknowledged.set()
        if self.view.status is not None:
            self._set(state="ended", message=self._killed_because)
        elif self._killed_because:
            await self._enter_end("stopped")
            self._set(state="ended", status="killed", message=self._killed_because)
        else:
            await self._enter_end("error")
            self._set(state="ended", status="died", message=_obituary(exit_status, self._process.tail()))
        self._changed()

    async def _enter_end(self, status: Literal["stopped", "error"]) -> None:
        if self.view.run is not None:
            await asyncio.to_thread(self._source.end_run, self.view.run, status)

    def _set(self, **changes: Any) -> None:
        if any(getattr(self.view, key) != value for key, value in changes.items()):
            self.view = self.view.model_copy(update=changes)
            self._changed()


def _obituary(exit_status: int, tail: str) -> str:
    how = f"was ended by signal {-exit_status}" if exit_status < 0 else f"ended with exit status {exit_status}"
    said = f" Its last words:\n{tail}" if tail else " It said nothing."
    return f"The run's process {how} before the task had ended.{said}"


async def _within(seconds: float, something: Any) -> bool:
    try:
        await asyncio.wait_for(something, seconds)
    except TimeoutError:
        return False
    return True


class RunDesk:
    """Starts runs, one at a time, and tells the viewers when something has changed.

    Args:
        launcher: makes the processes.
        journal: the file that runs are written to.
        source: where the end of a run is entered whose process died.
    """

    def __init__(self, launcher: Launcher, journal: Path, source: RunSource):
        self._launcher, self.journal, self._source = launcher, journal, source
        self.session: Session | None = None
        self._starting = False
        self._viewers: set[asyncio.Event] = set()

    @property
    def view(self) -> SessionView | None:
        """How the run under way, or the last one, is."""
        return self.session.view if self.session else None

    async def start(self, task: str, task_file: Path, options: RunOptions) -> SessionView:
        """Start a run.

        Raises:
            BusyError: another one is under way.
            OSError: its process can't be started.
        """
        if self._starting or (self.session and not self.session.over):
            raise BusyError("a run is under way; stop it before starting another one")
        self._starting = True
        try:
            process = await self._launcher.start(task_file, self.journal, options)
        finally:
            self._starting = False
        view = SessionView(
            state="starting",
            task=task,
            robot=options.robot,
            target=options.target,
            seed=options.seed,
            pace=options.pace,
        )
        self.session = Session(process, view, self.notify, self._source)
        self.notify()
        return self.session.view

    async def command(self, command: Command) -> SessionView:
        """Pass a command to the run under way; `stop` returns when its process has ended.

        Raises:
            BusyError: there is no run.
        """
        if self.session is None:
            raise BusyError("no run was started")
        await self.session.command(command)
        return self.session.view

    async def close(self) -> None:
        """Stop the run under way; afterwards no process of it is left."""
        if self.session is not None:
            await self.session.command("stop")
            await self.session.wait()

    # --- viewers ---

    def watch(self) -> asyncio.Event:
        """Return an event that is set whenever something has changed; give it back to `unwatch`."""
        event = asyncio.Event()
        event.set()
        self._viewers.add(event)
        return event

    def unwatch(self, event: asyncio.Event) -> None:
        """Forget a viewer."""
        self._viewers.discard(event)

    def notify(self) -> None:
        """Wake all viewers."""
        for event in self._viewers:
            event.set()
