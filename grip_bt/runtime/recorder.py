"""From what happens in a run to events of its journal."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from grip_bt.base.errors import NodeError
from grip_bt.base.ports import Clock
from grip_bt.base.values import Failure

from .journal_writer import preview
from .recording import PREEMPT
from .run_log import ENTER, INTERRUPTED, LIMIT, Noted, RunLog
from .value_codec import snapshot

__all__ = ["Recorder", "preview"]


class Recorder:
    """The observer that writes a journal. Called in the threads that tick; blocks only where the writer is far behind.

    Attributes:
        entered: `entered(path)`: an activation begins.
        ended: `ended(path, outcome, failure)`: an activation ended.
        interrupted: `interrupted(path)`: an activation was halted.
    """

    def __init__(self, log: RunLog, clock: Clock):
        self._append, self._note, self._now, self._log = log.append, log.note, clock.now, log
        self.entered: Callable[[str], None]
        self.ended: Callable[[str, str, Failure | None], None]
        self.interrupted: Callable[[str], None]
        log.follow(clock)
        make = _transitions if log.turns is None else _transitions_by_the_wall
        self.entered, self.ended, self.interrupted = make(log, clock.now, self._failed)

    # --- the run ---

    def started(self, facts: Mapping[str, Any] | None = None) -> None:
        """The run begins; `facts` are JSON about how."""
        self._append(self._now(), "/", "run_started", data=dict(facts) if facts else None)

    def resumed(self, t: float, facts: Mapping[str, Any]) -> None:
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

    def message(self, path: str, text: str) -> None:
        """A running node says how it goes."""
        self._append(self._now(), path, "message", data={"text": text})

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """A node wrote a variable; its value is kept as it is now."""
        data = {"variable": variable, "type": type_name}
        self._note(self._now(), path, Noted("write", data=data, written=(snapshot(value),)))

    def kept(self, path: str, part: str, state: Any) -> None:
        """The state of a part beside the task is this, when a node ends; see `runtime.keeping`."""
        self._note(self._now(), path, Noted("kept", data={"part": part}, written=(snapshot(state),)))

    def _failed(self, path: str, outcome: str, failure: Failure) -> None:
        data: dict[str, Any] = {"message": failure.message}
        if failure.data:
            data["data"] = dict(failure.data)
        self._append(self._now(), path, "exit", outcome, failure.code, data)


def _transitions(log: RunLog, now: Callable[[], float], failed: Callable[[str, str, Failure], None]) -> Any:
    """Return `entered`, `ended` and `interrupted`: functions without attributes to look up, of one C call each."""
    buffer, extend, monotonic, limit = log.buffer, log.buffer.extend, time.monotonic, log.stride * LIMIT

    def entered(path: str) -> None:
        extend((path, ENTER, monotonic(), now()))

    def ended(path: str, outcome: str, failure: Failure | None) -> None:
        if failure is None:
            extend((path, outcome, monotonic(), now()))
        else:
            failed(path, outcome, failure)
        if len(buffer) > limit:
            log.wait_for_room()

    def interrupted(path: str) -> None:
        extend((path, INTERRUPTED, monotonic(), now()))

    return entered, ended, interrupted


def _transitions_by_the_wall(log: RunLog, _: Callable[[], float], failed: Callable[[str, str, Failure], None]) -> Any:
    """Likewise where the run's clock is the wall's."""
    buffer, extend, monotonic, limit = log.buffer, log.buffer.extend, time.monotonic, log.stride * LIMIT

    def entered(path: str) -> None:
        extend((path, ENTER, monotonic()))

    def ended(path: str, outcome: str, failure: Failure | None) -> None:
        if failure is None:
            extend((path, outcome, monotonic()))
        else:
            failed(path, outcome, failure)
        if len(buffer) > limit:
            log.wait_for_room()

    def interrupted(path: str) -> None:
        extend((path, INTERRUPTED, monotonic()))

    return entered, ended, interrupted
