"""Bringing a compiled task to where a recorded run was, and going on from there for real.

The task is executed from its beginning with its own containers; only leaves don't do their work but end as they did
before, with what they wrote. Nobody waits meanwhile, and the clock shows recorded times. After the last recorded event,
in the middle of a tick if need be, leaves work again; one that was active then is resumed or started again.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Literal

from py_trees.common import Status

from grip_bt.base.errors import DivergedError
from grip_bt.base.ports import Clock
from grip_bt.base.values import Failure
from grip_bt.compilers import CompiledMachine, CompiledTree, Halted
from grip_bt.compilers.behaviour_state import BehaviourState
from grip_bt.compilers.binding import parts_of
from grip_bt.compilers.task_machine import TaskMachine
from grip_bt.nodes import Leaf
from grip_bt.nodes.container import KindNode
from grip_bt.nodes.node import AskedBefore
from grip_bt.task import model
from grip_bt.task.exploration import Labels
from grip_bt.task.kind_analysis import time_sense

from .journal_events import Event
from .pacing import Pacing
from .recording import Activation, RecordedClock, Recording

How = Literal["resume", "restart"]
_Mode = Literal["", "recorded", "open", "new"]
_IDLE_TICKS = 20
"""Ticks of a tree without any recorded event, after which the recording can't be followed."""
_SHORT_TIME = 0.05
"""How long [s] they may take to an interruption that the task makes by itself."""
_IDLE_TIME = 5.0
"""How long [s] the threads of a machine may take from one recorded event to the next."""


class ReExecution:
    """A recorded run in a task that was compiled anew.

    Args:
        compiled: the task; `install` is called after its `prepare`.
        how: leaf that was active at the end -> whether it is resumed; those not named are started again.
        results: leaf -> how its first activation ends that the recording doesn't have the end of: outcome and failure
            code, empty for none.

    Attributes:
        tell: told `(leaf, how)` as each active leaf goes on.
        pacing: of the run, from when on it is `live`.
        ask: asks the task to come to an end, as often as the recording says that somebody did.
    """

    def __init__(
        self,
        compiled: CompiledTree | CompiledMachine,
        events: Iterable[Event],
        value: Callable[[Event], object],
        clock: Clock,
        *,
        how: Mapping[str, How] | None = None,
        results: Mapping[str, Sequence[str]] | None = None,
    ):
        self._compiled, self.value = compiled, value
        self.how, self.results = dict(how or {}), dict(results or {})
        self.tell: Callable[[str, str], None] = lambda path, how: None
        self.recording = Recording(events, compiled.leaves.keys(), self._put)
        self.clock = RecordedClock(clock, self.recording)
        self.recording.on_complete = self._complete
        self.wake: Callable[[], None] = lambda: None
        self.pacing: Pacing | None = None
        self.ask: Callable[[], None] = lambda: None
        self._leaves: dict[str, _RecordedLeaf] = {}
        self._begun = False
        self._idle = 0
        self._seen, self._looked = 0, time.monotonic()
        self._settling = threading.Lock()

    @property
    def live(self) -> bool:
        return self.recording.complete

    def install(self, wake: Callable[[], None]) -> None:
        """Take over the leaves, and the clocks of nodes that decide by the time; after `prepare`."""
        self.wake = wake
        parts = parts_of(self._compiled)
        for path, leaf in self._compiled.leaves.items():
            node = parts[path].node
            assert isinstance(node, model.Leaf), "leaves are leaves of the document"
            self._leaves[path] = _RecordedLeaf(leaf, self, {v: port for port, v in node.out.items()})
        states = [*self._compiled.by_path.values()]
        # A state of a machine may stand for a whole tree, by the path of its root.
        for state in states:
            for node in [state, *(state.node.iterate() if isinstance(state, BehaviourState) else ())]:
                self._take_time(node)

    def _take_time(self, node: object) -> None:
        if isinstance(node, TaskMachine) and node.decide is not None:
            ends = {node.decide.answers.names[i]: meaning for i, _, meaning in node.decide.children.values()}
            kind, answers = node.decide.kind, node.decide.answers
        elif isinstance(node, KindNode):
            ends = {child.name: child.meaning for child in node.children}
            kind, answers = node.kind, node.answers
        else:
            return
        labels = Labels({name: list(meaning.items()) for name, meaning in ends.items()}, answers.exits, answers.edges)
        sense = time_sense(kind, labels)
        if sense == "before":
            answers.judge = partial(self.clock.over, answers.path, kind.codes)
        elif sense == "after":
            children = [model.join(answers.path, name) for name in ends]
            answers.judge = partial(self.clock.rested, answers.path, children)

    def _put(self, event: Event) -> None:
        cell = self._compiled.data[str(event.data.get("scope", ""))].cells[str(event.data["variable"])]
        cell.value = self.value(event)
        for written in cell.watchers:
            written()

    def _complete(self) -> None:
        self.clock.go()
        for _ in self.recording.requests:
            self.ask()
        self.wake()

    def turn(self) -> int:
        """Let leaves go that work by themselves; return when it is time to tick, which doesn't wait before `live`.

        Raises:
            Halted: the run was stopped.
        """
        if not self._begun:
            self._begun = True
            self.recording.begin()
        if self.live and self._leaves:
            with self._settling:
                for path in [path for path, leaf in self._leaves.items() if leaf.free]:
                    self._leaves.pop(path).release()
        if self.pacing is not None and self.live:
            return self.pacing.turn()
        if self.pacing is not None and self.pacing.stopped:
            raise Halted
        return 0

    def rest(self, seen: int) -> None:
        """Return when there may be something to look at.

        Raises:
            DivergedError: nothing that was recorded happens any more.
        """
        if self.live:
            if self.pacing is not None:
                self.pacing.rest(seen)
            return
        done, now = self.recording.done, time.monotonic()
        if done != self._seen:
            self._seen, self._looked, self._idle = done, now, 0
            return
        self._idle += 1
        machine = isinstance(self._compiled, CompiledMachine)
        if self._idle > _IDLE_TICKS and now - self._looked > machine * _SHORT_TIME and self.recording.set_aside():
            return
        if now - self._looked > _IDLE_TIME if machine else self._idle > _IDLE_TICKS:
            missing = self.recording.missing()
            raise DivergedError((missing or ["/"])[0].split()[0], "nothing", "; ".join(missing))
        if machine:
            time.sleep(0.0005)  # other threads come first; nothing is waited for


class _RecordedLeaf:
    """Stands in the way of a leaf's life cycle, in the leaf itself: its class, ports and place stay as they are.

    `ports` has the output port that is bound to each variable.
    """

    def __init__(self, leaf: Leaf, re_execution: ReExecution, ports: Mapping[str, str]):
        self._leaf, self._re_execution, self._ports = leaf, re_execution, ports
        self._recording = re_execution.recording
        self._mode: _Mode = ""
        self._released = False
        for name in ("initialise", "update", "terminate"):
            setattr(leaf, name, getattr(self, name))

    @property
    def free(self) -> bool:
        return self._released or (self._mode == "" and self._leaf.path not in self._re_execution.results)

    def release(self) -> None:
        if not self._released:
            self._released = True
            for name in ("initialise", "update", "terminate"):
                delattr(self._leaf, name)

    def initialise(self) -> None:
        activation = self._recording.current.get(self._leaf.path)
        if activation is None:
            self._mode = "new"
            return
        self._mode = "recorded" if activation.end is not None else "open"
        with _asked_until(self._leaf, self._recording.events[activation.began].seq, self._recording):
            self._leaf.replay_begun()

    def update(self) -> Status:
        if self._mode == "recorded":
            activation = self._recording.current.get(self._leaf.path)
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
        activation = self._recording.current.get(self._leaf.path)
        end = activation.end if activation is not None else None
        with _asked_until(self._leaf, end.seq if end is not None else None, self._recording):
            self._leaf.replay_ended(self._leaf.outcome)

    def _end_again(self, activation: Activation) -> Status:
        end = activation.result
        assert end is not None, "a leaf that may end has an end"
        for number in activation.writes:
            event = self._recording.events[number]
            self._leaf.writers[self._ports[str(event.data["variable"])]](self._re_execution.value(event))
        data = end.data.get("data", {})
        why = str(end.data.get("message", "")), data if isinstance(data, dict) else {}
        return self._ended(str(end.outcome), Failure(end.code, *why) if end.code is not None else None)

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
