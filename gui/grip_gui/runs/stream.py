"""The WebSocket of one viewer: how the run under way is, and the events of the run that the viewer looks at."""

from __future__ import annotations

import asyncio
import logging
import sqlite3
from collections.abc import Callable
from contextlib import suppress

from fastapi import WebSocket, WebSocketDisconnect
from pydantic import BaseModel, TypeAdapter, ValidationError

from grip_bt.base.errors import GripError, UnknownNameError
from grip_gui.runs.journal import JournalRuns
from grip_gui.runs.run_control import RunControl
from grip_gui.wire import runs as wire

log = logging.getLogger(__name__)

CLIENT_FRAME: TypeAdapter[wire.Subscribe | wire.Introduce | wire.Selection] = TypeAdapter(wire.ClientFrame)
FRAME = 1 / 30  # shortest time between two frames to one viewer [s]
BATCH = 1000  # most events in one frame
POLL = 1.0  # how often the journal is asked about a run that another process executes [s]
LARGEST_MESSAGE = 4096  # longest message that a viewer may send, in characters
STRIKES = 20  # after this many refused messages the connection is closed


class ClientConnection:
    """Streams to one page until it leaves."""

    def __init__(
        self,
        socket: WebSocket,
        control: RunControl,
        source: JournalRuns,
        revisions: Callable[[], dict[str, int]] = dict,
        page: str = "",
    ):
        self._page = page
        self._socket, self._control, self._source, self._revisions = socket, control, source, revisions
        self._changed = asyncio.Event()
        self._changed.set()
        control.viewers.add(self._changed)
        self._run: str | None = None
        self._next = 0
        self._complete = False
        self._told: dict[type[BaseModel], BaseModel] = {}
        self._told_revisions: dict[str, int] = {}
        self._told_selections: dict[str, wire.Selected] = {}

    async def serve(self) -> None:
        """Talk until the page leaves or breaks the rules too often."""
        self._control.presence.come(self._page)
        sender = asyncio.create_task(self._send_or_close())
        try:
            await self._receive()
        except WebSocketDisconnect:
            pass
        finally:
            self._control.viewers.discard(self._changed)
            self._control.presence.go(self._page)
            sender.cancel()
            with suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
                await sender

    async def _receive(self) -> None:
        strikes = 0
        while strikes < STRIKES:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            reason = self._understand(message.get("text"))
            if reason:
                strikes += 1
                log.warning("refused a message from %s: %s", self._socket.client, reason)
                await self._write(wire.RefusedFrame(reason=reason))
        await self._socket.close(code=1008, reason="too many messages that aren't understood")

    def _understand(self, text: str | None) -> str:
        """Act on a message; return why it is refused, empty when it is fine."""
        if text is None:
            return "messages are text"
        if len(text) > LARGEST_MESSAGE:
            return f"a message may have {LARGEST_MESSAGE} characters, not {len(text)}"
        try:
            request = CLIENT_FRAME.validate_json(text)
        except (ValidationError, RecursionError) as error:
            return f"not understood: {' '.join(str(error).splitlines()[:3])}"
        match request:
            case wire.Introduce():
                self._control.presence.introduce(self._page, request)
            case wire.Selection():
                self._control.presence.select(self._page, request)
            case wire.Subscribe():
                self._run, self._next, self._complete = request.run, request.from_seq, False
                self._changed.set()
        return ""

    async def _send_or_close(self) -> None:
        """Send until the page leaves; where that breaks, close the connection, so that the page comes back."""
        try:
            await self._send()
        except (WebSocketDisconnect, RuntimeError):
            raise  # the page has left
        except Exception:
            log.exception("nothing more can be sent to %s", self._socket.client)
            await self._socket.close(code=1011)

    async def _send(self) -> None:
        while True:
            await self._wait()
            self._changed.clear()
            for frame in (
                wire.SessionFrame(session=self._control.view),
                wire.SharedStateFrame(desk=self._control.shared_state),
            ):
                if self._told.get(type(frame)) != frame:
                    self._told[type(frame)] = frame
                    await self._write(frame)
            now, before = self._control.presence.selections(but=self._page), self._told_selections
            changed = {page: now.get(page) for page in now.keys() | before.keys() if now.get(page) != before.get(page)}
            if changed:
                self._told_selections = now
                await self._write(wire.SelectionsFrame(selections=changed))
            revisions = self._revisions()
            if news := dict(revisions.items() - self._told_revisions.items()):
                self._told_revisions = revisions
                await self._write(wire.RevisionsFrame(revisions=news))
            try:
                more = await self._send_events()
            except (GripError, sqlite3.Error) as error:
                # A run may just be making the file, or hold it for long: the page is told all else meanwhile.
                log.warning("the journal can't be read, which is tried again: %s", error)
                await asyncio.sleep(POLL)
                more = True
            if more:
                self._changed.set()
            await asyncio.sleep(FRAME)

    async def _wait(self) -> None:
        """Wait for news. A run of another process sends none, so its journal is asked now and then."""
        watching = self._run is not None and not self._complete
        # Not `wait_for`: in Python 3.11 it swallows a cancellation that comes together with the news.
        with suppress(TimeoutError):
            async with asyncio.timeout(POLL if watching else None):
                await self._changed.wait()

    async def _send_events(self) -> bool:
        """Send the next batch; return whether there may be more at once."""
        run, first = self._run, self._next
        if run is None or self._complete:
            return False
        # Whether it has ended is asked before the events are read: what was committed before the end is then in them.
        over = await asyncio.to_thread(self._is_over, run)
        events = await asyncio.to_thread(self._source.events, run, first, BATCH)
        if (run, first) != (self._run, self._next):
            return True  # the viewer has turned to another run meanwhile
        complete = over and len(events) < BATCH
        if events or complete:
            self._next = events[-1].seq + 1 if events else first
            self._complete = complete
            await self._write(wire.EventsFrame(run=run, events=events, complete=complete))
        return len(events) == BATCH

    def _is_over(self, run: str) -> bool:
        view = self._control.view
        if self._control.session is not None and view is not None and view.run == run:
            return view.state == "ended"
        try:
            return self._source.run(run).status != "running"
        except UnknownNameError:
            return True

    async def _write(self, frame: BaseModel) -> None:
        await self._socket.send_text(frame.model_dump_json())
