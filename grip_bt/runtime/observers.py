"""Observers of a run: they write its journal, keep state beside the task, and tell the parent."""

from __future__ import annotations

import mmap
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from grip_bt.base.errors import NodeError
from grip_bt.base.ports import Clock
from grip_bt.base.value_codec import snapshot
from grip_bt.base.values import Failure
from grip_bt.nodes.node import Observer
from grip_bt.runtime.journal import ENTER, ENTRIES, INTERRUPTED, LIMIT, DetailedEvent, RunLog


class Recorder(Observer):
    """The observer that writes a journal; blocks the threads that tick only where the writer is far behind."""

    def __init__(self, log: RunLog, clock: Clock):
        self._append, self._note, self._now, self._log = log.append, log.note, clock.now, log
        self._extend = log.buffer.extend

    def say(self, event: str, path: str = "/", /, **data: object) -> None:
        """Note an event of the run, or about a node; `data` is JSON."""
        self._append(self._now(), path, event, data=data or None)

    def resumed(self, t: float, facts: Mapping[str, object]) -> None:
        self._append(t, "/", "run_resumed", data=dict(facts))

    def error(self, error: BaseException, trace: str) -> None:
        path, cause = (error.path, error.cause) if isinstance(error, NodeError) else ("/", error)
        self.say("error", path, type=type(cause).__name__, message=str(cause), traceback=trace)

    def finished(self, outcome: str | None, status: str, rest: str = "") -> None:
        data = {"status": status, "rest": rest} if rest else {"status": status}
        self._append(self._now(), "/", "run_ended", outcome, data=data)
        self._log.end(status, outcome)

    def lost(self, why: str) -> None:
        self._log.cut(self._now(), why)

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
        self.say("message", path, text=text)

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """A node wrote a variable; its value is kept as it is now."""
        data = {"variable": variable, "type": type_name}
        self._note(self._now(), path, DetailedEvent("write", data=data, written=(snapshot(value),)))

    def kept(self, path: str, part: str, state: object) -> None:
        """The state of a part beside the task is this, when a node ends; see `runtime.observers`."""
        self._note(self._now(), path, DetailedEvent("kept", data={"part": part}, written=(snapshot(state),)))


KEPT = "kept"
"""The event; its data has `part` and, as a write has, the state."""


class SideState(Protocol):
    """A part of a run whose state is kept."""

    def changed(self) -> Any:
        """Return its state as a value that the journal can restore; None where it is what it was at the last call.

        Called in the thread that ticks: it takes microseconds, or a few milliseconds for what has just moved.
        """

    def restore(self, state: object) -> None:
        """Bring it into a state that `changed` has returned, in another process.

        Raises:
            GripError: it can't be brought there; it says why.
        """


class SideStateObserver(Observer):
    """An observer that notes the states of parts; told before the journal's.

    Args:
        note: `note(path, part, state)` enters one into the journal.
        leaves: leaf -> names of the parts that its work may change.
    """

    def __init__(
        self,
        note: Callable[[str, str, Any], None],
        parts: Mapping[str, SideState],
        leaves: Mapping[str, tuple[str, ...]],
    ):
        self._note, self._parts, self._leaves = note, parts, leaves

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        self.interrupted(path)

    def interrupted(self, path: str) -> None:
        for name in self._leaves.get(path, ()):
            state = self._parts[name].changed()
            if state is not None:
                self._note(path, name, state)


_BEAT = 0.1
"""How often the count goes on [s]."""
_COUNT, _LAST, _FLAGS = 0, 1, 8
LARGEST = 1 << 20
"""Size of the shared memory [bytes]; nodes beyond that aren't told apart."""


class Heartbeat(Observer):
    """The run's end: an observer of its nodes, in shared memory of at least `LARGEST` bytes."""

    def __init__(self, memory: int, paths: Sequence[str]):
        shared = mmap.mmap(memory, LARGEST)
        room = LARGEST - _FLAGS - 1
        self._words, self._flags = memoryview(shared)[:_FLAGS].cast("I"), memoryview(shared)[_FLAGS:]
        self._numbers: Mapping[str, int] = {path: min(i, room) for i, path in enumerate(paths)}
        self._words[_LAST] = room
        self._flags[: len(paths)] = bytes(min(len(paths), room + 1))  # of a run before
        self._over = threading.Event()

    def start(self) -> None:
        threading.Thread(target=self._beat, name="grip_heartbeat", daemon=True).start()

    def stop(self) -> None:
        self._over.set()

    def _beat(self) -> None:
        while not self._over.wait(_BEAT):
            self._words[_COUNT] = (self._words[_COUNT] + 1) & 0xFFFFFFFF

    def entered(self, path: str) -> None:
        number = self._numbers[path]
        self._words[_LAST] = number
        self._flags[number] = 1

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        self._flags[self._numbers[path]] = 0

    def interrupted(self, path: str) -> None:
        self._flags[self._numbers[path]] = 0


class HeartbeatReader:
    """The parent's end, which outlives the run; of the same file descriptor."""

    def __init__(self, memory: int):
        self._shared = mmap.mmap(memory, LARGEST)

    @property
    def count(self) -> int:
        return int.from_bytes(self._shared[:4], "little")

    def where(self, paths: Sequence[str]) -> tuple[str, list[str]]:
        """Return the node that was entered last, and the deepest nodes that were active, in the task's order."""
        last = int.from_bytes(self._shared[4:8], "little")
        active = [path for i, path in enumerate(paths) if i < LARGEST - _FLAGS - 1 and self._shared[_FLAGS + i]]
        deepest = [p for p in active if not any(q != p and (p == "/" or q.startswith(p + "/")) for q in active)]
        return (paths[last] if last < len(paths) else "/"), deepest


class WakeOnWrite(Observer):
    """An observer that has the run look again after each write, since nobody polls for what it may change."""

    def __init__(self, context: Any):
        self._wake = context.wake

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        self._wake()
