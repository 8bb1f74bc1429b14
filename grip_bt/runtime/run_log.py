"""The log of one run, as the thread that ticks sees it: a list that grows, and that the journal's writer empties."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from grip_bt.base.errors import NodeError
from grip_bt.base.ports import Clock
from grip_bt.base.values import Failure
from grip_bt.runtime.recording import PREEMPT
from grip_bt.runtime.value_codec import snapshot

if TYPE_CHECKING:
    from grip_bt.runtime.journal import Journal

ENTER, INTERRUPTED = 0, 1
"""What a transition is that isn't an end; an end is its outcome."""

_DIED = "died"
"""Status of a run that was cut off: nobody has stopped it, and it can be resumed."""

ENTRIES = 4
"""Entries of `RunLog.buffer` for an event."""
LIMIT = 2_000_000
"""Events that may wait for the writer; beyond that, whoever appends waits for it."""


class DetailedEvent:
    """An event that says more than that a node began or ended.

    Attributes:
        event: its kind.
        outcome: of an end.
        code: of a failure.
        data: anything else, as JSON.
        written: a variable's value, to be encoded by the writer; whoever appends it promises not to change it.
    """

    __slots__ = ("code", "data", "event", "outcome", "written")

    def __init__(
        self,
        event: str,
        outcome: str | None = None,
        code: str | None = None,
        data: dict[str, Any] | None = None,
        written: tuple[object] | None = None,
    ):
        self.event, self.outcome, self.code, self.data, self.written = event, outcome, code, data, written


class RunLog:
    """The log of one run.

    Attributes:
        id: the run's id.
        buffer: four entries an event: path, what (`ENTER`, `INTERRUPTED`, an outcome, or a `DetailedEvent`), the moment
            [s, monotonic] and the time on the run's clock [s]. It is extended by whole events, at once, and only the
            writer takes from its front.
        ended: whether the run's end was entered.
        last: the event after which nothing is written any more; None as long as the run isn't cut off.
        over: whether the writer has written that one; kept here, since a log that has ended may be followed again.

    Args:
        journal: that it belongs to.
        run: the run's id.
    """

    def __init__(self, journal: Journal, run: str):
        self.journal, self.id = journal, run
        self.buffer: list[Any] = []
        self.ended = False
        self.last: DetailedEvent | None = None
        self.over = False
        self._cutting = threading.RLock()
        journal.follow(self)

    def append(
        self,
        t: float,
        path: str,
        event: str,
        outcome: str | None = None,
        code: str | None = None,
        data: dict[str, Any] | None = None,
    ) -> None:
        """Add an event; returns before it is committed.

        Args:
            t: time on the run's clock [s].
            path: the node; `/` for the root and for the run itself.
            event: its kind.
            outcome: of an end.
            code: of a failure.
            data: anything else, as JSON.
        """
        self.note(t, path, DetailedEvent(event, outcome, code, data))

    def note(self, t: float, path: str, what: DetailedEvent) -> None:
        """Add an event at the time `t` on the run's clock [s]."""
        self.buffer.extend((path, what, time.monotonic(), t))
        if self.ended:
            self.journal.follow(self)
        if len(self.buffer) > ENTRIES * LIMIT:
            self.wait_for_room()

    def wait_for_room(self) -> None:
        """Return when the writer has caught up; memory is bounded by that."""
        while len(self.buffer) > ENTRIES * LIMIT // 2 and self.journal.writing:
            time.sleep(0.001)

    def end(self, status: str, outcome: str | None) -> None:
        """Enter how the run has ended; nothing where it was cut off."""
        if self.last is not None and status != _DIED:
            return
        statement = "UPDATE runs SET ended=?, status=?, outcome=? WHERE id=?"
        self.journal.execute(statement, (time.time(), status, outcome, self.id))
        self.ended = True

    def cut(self, t: float, why: str) -> None:
        """End the journal of the run here, as if its process had died: it can be resumed from here.

        What happens after this, such as that everything is interrupted, isn't written: whoever has the run stopped
        because of it, from whichever thread, does so when this has returned.
        """
        with self._cutting:
            if self.ended or self.last is not None:
                return
            self.last = DetailedEvent("run_ended", data={"status": _DIED, "message": why})
            self.note(t, "/", self.last)
            self.end(_DIED, None)


class Recorder:
    """The observer that writes a journal; blocks the threads that tick only where the writer is far behind."""

    def __init__(self, log: RunLog, clock: Clock):
        self._append, self._note, self._now, self._log = log.append, log.note, clock.now, log
        self._extend = log.buffer.extend

    # --- the run ---

    def started(self, facts: Mapping[str, object] | None = None) -> None:
        """The run begins; `facts` are JSON about how."""
        self._append(self._now(), "/", "run_started", data=dict(facts) if facts else None)

    def resumed(self, t: float, facts: Mapping[str, object]) -> None:
        """It goes on at `t` [s], in another process; `facts` are JSON about how."""
        self._append(t, "/", "run_resumed", data=dict(facts))

    def went_on(self, path: str, how: str) -> None:
        """A leaf that was active when its process died goes on, or is started again."""
        self._append(self._now(), path, "went_on", data={"how": how})

    def state(self, state: str) -> None:
        """It runs, pauses or is being stopped."""
        self._append(self._now(), "/", "state", data={"state": state})

    def preempt_requested(self) -> None:
        """Somebody asks the task to come to an end on its own terms."""
        self._append(self._now(), "/", PREEMPT)

    def error(self, error: BaseException, trace: str) -> None:
        """A node raised."""
        path, cause = (error.path, error.cause) if isinstance(error, NodeError) else ("/", error)
        data = {"type": type(cause).__name__, "message": str(cause), "traceback": trace}
        self._append(self._now(), path, "error", data=data)

    def zombie(self, path: str, where: str) -> None:
        """A node's code hasn't returned and was left behind."""
        self._append(self._now(), path, "zombie", data={"where": where})

    def finished(self, outcome: str | None, status: str, rest: str = "") -> None:
        """The run has ended; `rest` tells what was measured of the robot then."""
        data = {"status": status, "rest": rest} if rest else {"status": status}
        self._append(self._now(), "/", "run_ended", outcome, data=data)
        self._log.end(status, outcome)

    def told(self, part: str, text: str) -> None:
        """A part of the robot says something of itself, such as that its process has died."""
        self._append(self._now(), "/", "message", data={"part": part, "text": f"{part}: {text}"})

    def lost(self, why: str) -> None:
        """Whoever controlled it has gone: it is cut off here."""
        self._log.cut(self._now(), why)

    # --- its nodes ---

    def entered(self, path: str) -> None:
        self._extend((path, ENTER, time.monotonic(), self._now()))

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        if failure is not None:
            data: dict[str, Any] = {"message": failure.message}
            if failure.data:
                data["data"] = dict(failure.data)
            self._append(self._now(), path, "exit", outcome, failure.code, data)
            return
        self._extend((path, outcome, time.monotonic(), self._now()))
        if len(self._log.buffer) > ENTRIES * LIMIT:
            self._log.wait_for_room()

    def interrupted(self, path: str) -> None:
        self._extend((path, INTERRUPTED, time.monotonic(), self._now()))

    def message(self, path: str, text: str) -> None:
        self._append(self._now(), path, "message", data={"text": text})

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """A node wrote a variable; its value is kept as it is now."""
        data = {"variable": variable, "type": type_name}
        self._note(self._now(), path, DetailedEvent("write", data=data, written=(snapshot(value),)))

    def kept(self, path: str, part: str, state: object) -> None:
        """The state of a part beside the task is this, when a node ends; see `runtime.observers`."""
        self._note(self._now(), path, DetailedEvent("kept", data={"part": part}, written=(snapshot(state),)))
