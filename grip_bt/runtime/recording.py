"""What the journal knows of a run, as that which a second execution of the same task has to do again.

Results of leaves come from here; everything else follows from them, since containers only depend on their children,
their variables and the time. Each event that happens again is ticked off. A leaf ends again when everything that came
before its end has happened again: so siblings end in the same order, in trees and in the threads of a machine.
"""

from __future__ import annotations

import threading
from collections import defaultdict, deque
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field

from grip_bt.base.errors import DivergedError
from grip_bt.base.ports import Clock, Pausable
from grip_bt.base.values import Failure
from grip_bt.nodes.node import Observer

from .journal_events import Event

NODES = ("enter", "exit", "interrupted", "write")
"""Kinds of events that happen again; others say something about them, but for messages of containers: a parallel says
that it was decided."""
PREEMPT = "preempt_requested"
"""Kind of the events that tell of requests to come to an end."""


@dataclass
class Activation:
    """One activation of a node.

    Attributes:
        end: how it ended, an `exit` or `interrupted`; None when the recording ends first.
    """

    began: int
    end: Event | None = None
    ended: int = -1
    writes: list[int] = field(default_factory=list)

    @property
    def result(self) -> Event | None:
        """Its end, when it ended by itself."""
        return self.end if self.end is not None and self.end.event == "exit" else None


class Recording:
    """The events of a run that are to happen again; may be used from several threads.

    Attributes:
        events: of nodes, in order.
        complete: whether all of them have happened again.
        current: node -> its recorded activation that is under way.
        end_time: the last time of the run that the journal knows [s].
        requests: numbers (`seq`) of the requests to come to an end.
        under_way: leaf -> the event at which its activation began that hadn't ended.
        undone: events that don't count: writes of such activations, which are made again, and those of `set_aside`.
        on_complete: called once, in the thread of the last event.

    Args:
        events: of one run, in order.
        put: sets a variable that somebody set by hand, given the event; see `write` events with `set`.
    """

    def __init__(
        self, events: Iterable[Event], leaves: Collection[str], put: Callable[[Event], None] = lambda event: None
    ):
        events = list(events)
        self.events = [
            e  # what a part of the robot told doesn't happen again
            for e in events
            if e.event in NODES or (e.event == "message" and e.path not in leaves and "part" not in e.data)
        ]
        self.requests = tuple(event.seq for event in events if event.event == PREEMPT)
        self._put = put
        self._lock = threading.RLock()
        self._over = [False] * len(self.events)
        self._next = 0
        self.done = 0
        self.complete = False
        self.on_complete: Callable[[], None] = lambda: None
        self._expected: dict[str, deque[int]] = defaultdict(deque)
        self._to_come: dict[str, deque[Activation]] = defaultdict(deque)
        self.current: dict[str, Activation] = {}
        self._times = threading.local()
        self._latest = self.events[0].t if self.events else 0.0
        self.end_time = max((event.t for event in events if event.event in (*NODES, "message", "state")), default=0.0)
        self._read(frozenset(leaves))

    def _read(self, leaves: Collection[str]) -> None:
        open_: dict[str, Activation] = {}
        self.undone: list[Event] = []
        for number, event in enumerate(self.events):
            path = event.path
            if event.data.get("set"):
                continue
            self._expected[path].append(number)
            if event.event == "enter":
                open_[path] = Activation(number)
                self._to_come[path].append(open_[path])
            elif path in open_:
                if event.event == "message":
                    pass
                elif event.event == "write":
                    open_[path].writes.append(number)
                else:
                    open_[path].end, open_[path].ended = event, number
                    del open_[path]
        for path, activation in open_.items():
            # What a leaf wrote without having ended, it writes again.
            for number in activation.writes if path in leaves else ():
                self._expected[path].remove(number)
                self._over[number] = True
                self.undone.append(self.events[number])
        self.under_way = {path: self.events[a.began] for path, a in open_.items() if path in leaves}

    def set_aside(self) -> bool:
        """Leave out the rest, if it is nothing but interruptions; return whether it is.

        A task that is stopped, or a node of which raised, is interrupted from outside. Where the process died during
        that, the journal doesn't say why.
        """
        with self._lock:
            left = [n for n in range(self._next, len(self.events)) if not self._over[n]]
            if not left or any(self.events[n].event != "interrupted" for n in left):
                return False
            for number in left:
                path = self.events[number].path
                activation = self.current.get(path)
                if activation is not None and activation.ended == number:
                    activation.end, activation.ended = None, -1
                    self.under_way[path] = self.events[activation.began]
                self.undone.append(self.events[number])
                self._expected[path].clear()
                self._over[number] = True
            self._advance()
            return True

    def begin(self) -> None:
        with self._lock:
            self._advance()

    def happened(self, path: str, event: str, detail: str | None = None, code: str | None = None) -> bool:
        """Tick off the next event of a node; return False when the recording has no more of it: the event is new.

        `detail` is the outcome of an end, or the variable that is written.

        Raises:
            DivergedError: the recording has something else there.
        """
        with self._lock:
            if self.complete or not self._expected[path]:
                return False
            number = self._expected[path][0]
            recorded = self.events[number]
            was = recorded.data.get("variable") if event == "write" else recorded.outcome
            if (recorded.event, was, recorded.code) != (event, detail, code):
                raise DivergedError(path, _words(event, detail, code), _words(recorded.event, was, recorded.code))
            self._expected[path].popleft()
            self._tick_off(number)
            return True

    def _tick_off(self, number: int) -> None:
        event = self.events[number]
        if event.event == "enter":
            self.current[event.path] = self._to_come[event.path].popleft()
        elif event.event not in ("write", "message"):
            self.current.pop(event.path, None)
        self._times.last = self._latest = event.t
        self._over[number] = True
        self.done += 1
        self._advance()

    def _advance(self) -> None:
        while self._next < len(self.events):
            event = self.events[self._next]
            if not self._over[self._next]:
                if not event.data.get("set"):
                    return
                self._put(event)
            self._next += 1
        if not self.complete:
            self.complete = True
            self.on_complete()

    def time(self) -> float:
        """Return when this thread's last event took place, on the run's clock [s]."""
        return float(getattr(self._times, "last", self._latest))

    def said_before(self, path: str, seq: int) -> bool:
        """Tell whether the last thing that a container said was before an event."""
        said = next((event.seq for event in reversed(self.events) if (event.path, event.event) == (path, "message")), 0)
        return 0 < said < seq

    def may_end(self, path: str) -> bool:
        """Tell whether a leaf ends now: all that came before its end has happened again."""
        with self._lock:
            activation = self.current.get(path)
            if activation is None or activation.result is None:
                return False
            own = set(activation.writes)
            return all(self._over[n] or n in own for n in range(self._next, activation.ended))

    def halted(self, path: str, codes: Collection[str]) -> bool | float:
        """Tell whether a container halts what runs below it now, and fails with one of some codes.

        Where the recording ends in the middle of that, it may be this container or one around it: the time of the
        first interruption [s] is returned, to be compared with the deadline.
        """
        with self._lock:
            activation = self.current.get(path)
            if activation is None:
                return False
            if activation.end is None:
                event = self.events[self._next] if self._next < len(self.events) else None
                return event.t if event is not None and _halted_below(event, path) else False
            left = (self.events[n] for n in range(self._next, activation.ended) if not self._over[n])
            result = activation.result
            return result is not None and result.code in codes and all(_halted_below(event, path) for event in left)

    def refused(self, path: str, children: Sequence[str]) -> bool | None:
        """Tell whether a container ends now without a child having run; None when that isn't known."""
        with self._lock:
            activation = self.current.get(path)
            if activation is None:
                return None
            for child in children:
                number = next(iter(self._expected[child]), -1)
                if number > activation.began and (activation.end is None or number < activation.ended):
                    return False
            return True if activation.result is not None else None

    def missing(self, most: int = 3) -> list[str]:
        with self._lock:
            left = [self.events[n] for n in range(self._next, len(self.events)) if not self._over[n]][:most]
        return [f"{event.path} {_words(event.event, event.outcome, event.code)} (event {event.seq})" for event in left]


class RecordedClock:
    """Shows the time of the last recorded event until `go`, and from then on that time and what has passed since."""

    def __init__(self, clock: Clock, recording: Recording):
        self._clock, self._recording = clock, recording
        self._since: float | None = None
        if hasattr(clock, "on_advance"):
            self.on_advance = clock.on_advance

    def now(self) -> float:
        if self._since is None:
            return self._recording.time()
        return self._recording.end_time + (self._clock.now() - self._since)

    def go(self) -> None:
        self._since = self._clock.now()

    def pause(self) -> None:
        if isinstance(self._clock, Pausable):
            self._clock.pause()

    def resume(self) -> None:
        if isinstance(self._clock, Pausable):
            self._clock.resume()

    def over(self, path: str, codes: Collection[str], at: float) -> bool:
        """Tell a container that halts its child at a time and fails with one of `codes` whether that time has come.

        It has where it did so.
        """
        if self._since is not None:
            return self.now() >= at
        halted = self._recording.halted(path, codes)
        return halted if isinstance(halted, bool) else halted >= at

    def rested(self, path: str, children: Sequence[str], at: float) -> bool:
        """Tell a container that runs a child from a time on whether that time has come: it has where it did so."""
        refused = None if self._since is not None else self._recording.refused(path, children)
        return self.now() >= at if refused is None else not refused


class NewEvents(Observer):
    """An observer that passes on only what the recording doesn't have."""

    def __init__(self, recording: Recording, inner: Observer):
        self._happened, self._inner = recording.happened, inner

    def entered(self, path: str) -> None:
        if not self._happened(path, "enter"):
            self._inner.entered(path)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        if not self._happened(path, "exit", outcome, failure.code if failure is not None else None):
            self._inner.ended(path, outcome, failure)

    def interrupted(self, path: str) -> None:
        if not self._happened(path, "interrupted"):
            self._inner.interrupted(path)

    def message(self, path: str, text: str) -> None:
        if not self._happened(path, "message"):
            self._inner.message(path, text)

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        if not self._happened(path, "write", variable):
            self._inner.wrote(path, variable, type_name, value)


def _halted_below(event: Event, path: str) -> bool:
    below = "" if path == "/" else path if path.endswith("/") else f"{path}/"  # the root of a subtask ends with one
    return event.event == "interrupted" and event.path != path and event.path.startswith(below)


def _words(event: str, detail: str | None, code: str | None) -> str:
    return event + (f" {detail}" if detail else "") + (f".{code}" if code else "")
