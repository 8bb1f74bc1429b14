"""The log of one run, as the thread that ticks sees it: a list that grows, and that the journal's writer empties."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

from grip_bt.base.ports import Clock

from .clock import WallClock

if TYPE_CHECKING:
    from .journal import Journal

ENTER, INTERRUPTED = 0, 1
"""What a transition is that isn't an end; an end is its outcome."""

DIED = "died"
"""Status of a run that was cut off: nobody has stopped it, and it can be gone on with."""

LIMIT = 2_000_000
"""Events that may wait for the writer; beyond that, whoever appends waits for it."""


class Noted:
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
        written: tuple[Any] | None = None,
    ):
        self.event, self.outcome, self.code, self.data, self.written = event, outcome, code, data, written


class RunLog:
    """The log of one run.

    Attributes:
        id: the run's id.
        buffer: four entries an event: path, what (`ENTER`, `INTERRUPTED`, an outcome, or a `Noted`), the moment
            [s, monotonic] and the time on the run's clock [s]; three, without the last, where that is a `WallClock`. It
            is extended by whole events, at once, and only the writer takes from its front.
        stride: how many entries an event has.
        turns: those of the `WallClock`; None where it is another.
        ended: whether the run's end was entered.
        last: the event after which nothing is written any more; None as long as the run isn't cut off.

    Args:
        journal: that it belongs to.
        run: the run's id.
    """

    def __init__(self, journal: Journal, run: str):
        self.journal, self.id = journal, run
        self.buffer: list[Any] = []
        self.stride = 4
        self.turns: list[tuple[float, float, int]] | None = None
        self.ended = False
        self.last: Noted | None = None
        self._cutting = threading.RLock()
        journal.follow(self)

    def follow(self, clock: Clock) -> None:
        """Take times from this clock; before the first event."""
        if isinstance(clock, WallClock) and not self.buffer:
            self.turns, self.stride = clock.turns, 3

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
            t: time on the run's clock [s]; after `follow(WallClock)` that clock is asked instead.
            path: the node; `/` for the root and for the run itself.
            event: its kind.
            outcome: of an end.
            code: of a failure.
            data: anything else, as JSON.
        """
        self.note(t, path, Noted(event, outcome, code, data))

    def note(self, t: float, path: str, what: Noted) -> None:
        """Add an event at the time `t` on the run's clock [s]."""
        event = (path, what, time.monotonic(), t)
        self.buffer.extend(event[: self.stride])
        if self.ended:
            self.journal.follow(self)
        if len(self.buffer) > 4 * LIMIT:
            self.wait_for_room()

    def wait_for_room(self) -> None:
        """Return when the writer has caught up; memory is bounded by that."""
        while len(self.buffer) > 2 * LIMIT and self.journal.writing:
            time.sleep(0.001)

    def end(self, status: str, outcome: str | None) -> None:
        """Enter how the run has ended; nothing where it was cut off."""
        if self.last is not None and status != DIED:
            return
        statement = "UPDATE runs SET ended=?, status=?, outcome=? WHERE id=?"
        self.journal.execute(statement, (time.time(), status, outcome, self.id))
        self.ended = True

    def cut(self, t: float, why: str) -> None:
        """End the journal of the run here, as if its process had died: it can be gone on with from here.

        What happens after this, such as that everything is interrupted, isn't written: whoever has the run stopped
        because of it, from whichever thread, does so when this has returned.
        """
        with self._cutting:
            if self.ended or self.last is not None:
                return
            self.last = Noted("run_ended", data={"status": DIED, "message": why})
            self.note(t, "/", self.last)
            self.end(DIED, None)
