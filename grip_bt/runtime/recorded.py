"""Leaves and clocks of a run that happens again: as they were recorded, then by themselves."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

from py_trees.common import Status

from grip_bt.base.ports import Clock, Pausable
from grip_bt.base.values import Failure
from grip_bt.nodes import Leaf
from grip_bt.nodes.node import AskedBefore
from grip_bt.runtime.journal_events import Event
from grip_bt.runtime.recording import Activation, Recording

if TYPE_CHECKING:
    from grip_bt.runtime.re_execution import ReExecution

_Mode = Literal["", "recorded", "open", "new"]


class RecordedLeaf:
    """Stands in the way of a leaf's life cycle, in the leaf itself: its class, ports and place stay as they are.

    Args:
        leaf: which.
        re_execution: the run.
        ports: variable -> the output port that is bound to it.
    """

    def __init__(self, leaf: Leaf, re_execution: ReExecution, ports: Mapping[str, str]):
        self._leaf, self._re_execution, self._ports = leaf, re_execution, ports
        self._recording = re_execution.recording
        self._mode: _Mode = ""
        self._released = False
        self._told: Activation | None = None
        for name in ("initialise", "update", "terminate"):
            setattr(leaf, name, getattr(self, name))

    @property
    def free(self) -> bool:
        """Whether it needs nobody to stand in its way any more."""
        return self._released or (self._mode == "" and self._leaf.path not in self._re_execution.results)

    def release(self) -> None:
        """Get out of the way."""
        if not self._released:
            self._released = True
            for name in ("initialise", "update", "terminate"):
                delattr(self._leaf, name)

    # --- the leaf's life cycle ---

    def initialise(self) -> None:
        """An activation begins: one that the recording has, or has the beginning of, or a new one."""
        activation = self._recording.activation(self._leaf.path)
        if activation is not None:
            self._mode = "recorded" if activation.end is not None else "open"
        else:
            self._mode = "new"

    def update(self) -> Status:
        """End as recorded, wait for the others to come so far, or work."""
        if self._mode == "recorded":
            activation = self._recording.activation(self._leaf.path)
            assert activation is not None, "it is under way"
            if self._recording.may_end(self._leaf.path):
                return self._end_again(activation)
            if activation.end is None:
                self._mode = "open"
        elif self._re_execution.live:
            return self._go_on()
        self._re_execution.wake()
        return self._leaf.running()

    def terminate(self, new_status: Status) -> None:
        """An activation ends in which the leaf hasn't worked; it is told when it won't."""
        mode, self._mode = self._mode, ""
        if mode not in ("recorded", "open"):
            return
        activation = self._recording.activation(self._leaf.path)
        end = activation.end if activation is not None else None
        self._re_execution.tell_begun(end.seq if end is not None else None)
        with _asked_until(self._leaf, end.seq if end is not None else None, self._recording):
            self._leaf.replay_ended(self._leaf.outcome)

    def untold(self) -> Activation | None:
        """Return the recorded activation under way, if the leaf hasn't been told of it."""
        activation = self._recording.activation(self._leaf.path)
        return None if activation is self._told else activation

    def tell_begun(self, activation: Activation) -> None:
        """Tell the leaf that a recorded activation begins."""
        self._told = activation
        with _asked_until(self._leaf, self._recording.events[activation.began].seq, self._recording):
            self._leaf.replay_begun()

    def _end_again(self, activation: Activation) -> Status:
        end = activation.result
        assert end is not None, "a leaf that may end has an end"
        for number in activation.writes:
            event = self._recording.events[number]
            self._leaf.writers[self._ports[str(event.data["variable"])]](self._re_execution.restored(event))
        return self._ended(str(end.outcome), _failure_of(end))

    def _ended(self, outcome: str, failure: Failure | None) -> Status:
        self._leaf.failure = failure
        if failure is not None:
            self._leaf.feedback_message = str(failure)
        return self._leaf.end(outcome)

    def _go_on(self) -> Status:
        path, leaf = self._leaf.path, self._leaf
        result = self._re_execution.results.pop(path, None)
        if result is not None:
            self._mode = "recorded"
            self._re_execution.tell(path, "result")
            outcome, code = result
            return self._ended(outcome, Failure(code, "set by hand", {}) if code else None)
        self._re_execution.tell_begun(None)
        mode, how = self._mode, self._re_execution.how.get(path, "restart")
        self.release()
        if mode != "open":
            leaf.initialise()
            return leaf.update()
        began = self._recording.under_way[path]
        self._re_execution.tell(path, how)
        with _asked_until(leaf, began.seq, self._recording):
            if how == "resume":
                leaf.resume(began.t)
            else:
                leaf.initialise()
            return leaf.update()


@contextmanager
def _asked_until(leaf: Leaf, seq: int | None, recording: Recording) -> Iterator[None]:
    """Show a leaf only the requests to come to an end that there had been before an event; None for all.

    So it takes one that came after it began as its own, and not as one that is already being obeyed.
    """
    if seq is None and recording.complete:
        yield
        return
    count = len(recording.requests) if seq is None else sum(number < seq for number in recording.requests)
    above = any(asker.asked and (seq is None or recording.said_before(asker.path, seq)) for asker in leaf.askers)
    now = getattr(leaf.context, "preempt_requests", 0)  # some may be new, and not in the recording
    if recording.complete and count == now and above == any(a.asked for a in leaf.askers):
        yield
        return
    context, leaf.context = leaf.context, AskedBefore(leaf.context, count, above)
    try:
        yield
    finally:
        leaf.context.over = True  # who kept it sees what there is now
        leaf.context = context
        context.wake()


def _failure_of(end: Event) -> Failure | None:
    if end.code is None:
        return None
    data: Any = end.data.get("data", {})
    return Failure(end.code, str(end.data.get("message", "")), data if isinstance(data, dict) else {})


class RecordedClock:
    """Shows the time of the last recorded event until `go`, and from then on that time and what has passed since.

    Args:
        clock: what goes on then.
        recording: the recorded events.
    """

    def __init__(self, clock: Clock, recording: Recording):
        self._clock, self._recording = clock, recording
        self._since: float | None = None

    def now(self) -> float:
        """Return the time [s]."""
        if self._since is None:
            return self._recording.time()
        return self._recording.end_time + (self._clock.now() - self._since)

    def go(self) -> None:
        """Let time pass."""
        self._since = self._clock.now()

    @property
    def going(self) -> bool:
        """Whether it does."""
        return self._since is not None

    def pause(self) -> None:
        """Stand still, where the clock can."""
        if isinstance(self._clock, Pausable):
            self._clock.pause()

    def resume(self) -> None:
        if isinstance(self._clock, Pausable):
            self._clock.resume()

    def on_advance(self, listener: Callable[[], None]) -> None:
        """Call `listener()` after each advance, where the clock says when it moves."""
        listen: Any = getattr(self._clock, "on_advance", None)
        if listen is not None:
            listen(listener)


def recorded_limit(
    clock: RecordedClock, recording: Recording, path: str, codes: Collection[str]
) -> Callable[[float], bool]:
    """Return what tells a container that halts its child at a time whether that has come: it has where it did so.

    Args:
        clock: the run's.
        recording: the recorded events.
        path: the container's.
        codes: with which it fails then.
    """

    def judge(at: float) -> bool:
        if clock.going:
            return clock.now() >= at
        halted = recording.halted(path, codes)
        return halted if isinstance(halted, bool) else halted >= at

    return judge


def recorded_rest(
    clock: RecordedClock, recording: Recording, path: str, children: Sequence[str]
) -> Callable[[float], bool]:
    """Return what tells a container that runs a child from a time on whether that has come: it has where it did so."""

    def judge(at: float) -> bool:
        refused = None if clock.going else recording.refused(path, children)
        return clock.now() >= at if refused is None else not refused

    return judge
