"""From what happens in a run to events of its journal."""

from __future__ import annotations

import reprlib
from typing import Any

from grip_bt.errors import NodeError
from grip_bt.ports import Clock
from grip_bt.values import Failure

from .journal import RunLog

_repr = reprlib.Repr()
_repr.maxstring, _repr.maxother, _repr.maxlist, _repr.maxtuple = 60, 100, 3, 4


def preview(value: Any) -> str:
    """Return a value in at most 120 characters, for people; big values are cut before they are formatted."""
    text = _repr.repr(value)
    return text if len(text) <= 120 else text[:117] + "..."


class Recorder:
    """The observer that writes a journal. Called in the threads that tick; it never blocks."""

    def __init__(self, log: RunLog, clock: Clock):
        self._append, self._now, self._log = log.append, clock.now, log

    # --- the run ---

    def started(self) -> None:
        """The run begins."""
        self._append(self._now(), "/", "run_started")

    def state(self, state: str) -> None:
        """It runs, pauses or is being stopped."""
        self._append(self._now(), "/", "state", data={"state": state})

    def error(self, error: Exception, trace: str) -> None:
        """A node raised."""
        path, cause = (error.path, error.cause) if isinstance(error, NodeError) else ("/", error)
        data = {"type": type(cause).__name__, "message": str(cause), "traceback": trace}
        self._append(self._now(), path, "error", data=data)

    def finished(self, outcome: str | None, status: str) -> None:
        """The run has ended."""
        self._append(self._now(), "/", "run_ended", outcome, data={"status": status})
        self._log.end(status, outcome)

    # --- its nodes ---

    def entered(self, path: str) -> None:
        """An activation begins."""
        self._append(self._now(), path, "enter")

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """An activation ended."""
        if failure is None:
            self._append(self._now(), path, "exit", outcome)
        else:
            self._append(self._now(), path, "exit", outcome, failure.code, {"message": failure.message})

    def interrupted(self, path: str) -> None:
        """An activation was halted."""
        self._append(self._now(), path, "interrupted")

    def message(self, path: str, text: str) -> None:
        """A running node says how it goes."""
        self._append(self._now(), path, "message", data={"text": text})

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """A node wrote a variable."""
        data = {"variable": variable, "type": type_name, "preview": preview(value)}
        self._append(self._now(), path, "write", data=data)
