"""Bringing a compiled task to where a recorded run was, and going on from there for real.

The task is executed from its beginning with its own containers; only leaves don't do their work but end as they did
before, with what they wrote. Nobody waits meanwhile, and the clock shows recorded times. After the last recorded event,
in the middle of a tick if need be, leaves work again; one that was active then is resumed or started again.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal

from py_trees.behaviour import Behaviour
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
from grip_bt.nodes.node import Observer
from grip_bt.runtime.recorded import RecordedClock, RecordedLeaf, recorded_limit, recorded_rest
from grip_bt.task import model
from grip_bt.task.exploration import Labels
from grip_bt.task.kind_analysis import time_sense

from .journal_events import Event
from .pacing import Pacing
from .recording import Recording

How = Literal["resume", "restart"]
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
        events: what is to happen again.
        value: restores what a `write` event wrote.
        clock: the run's clock from then on.
        how: leaf that was active at the end -> whether it is resumed; those not named are started again.
        results: leaf -> how its first activation ends that the recording doesn't have the end of: outcome and failure
            code, empty for none.
        tell: told `(leaf, how)` as each active leaf goes on.

    Attributes:
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
        tell: Callable[[str, str], None] = lambda path, how: None,
    ):
        self._compiled, self._value = compiled, value
        self.how, self.results, self.tell = dict(how or {}), dict(results or {}), tell
        self.recording = Recording(events, compiled.leaves.keys(), self._put)
        self.clock = RecordedClock(clock, self.recording)
        self.recording.on_complete = self._complete
        self.wake: Callable[[], None] = lambda: None
        self.ask: Callable[[], None] = lambda: None
        self._leaves: dict[str, RecordedLeaf] = {}
        self._begun = False
        self._idle = 0
        self._seen, self._looked = 0, time.monotonic()
        self._settling = threading.Lock()
        self._listening: list[RecordedLeaf] = []
        self._telling = threading.Lock()

    @property
    def live(self) -> bool:
        """Whether everything that was recorded has happened again."""
        return self.recording.complete

    @property
    def settled(self) -> bool:
        """Whether every leaf works by itself again."""
        return self.live and not self._leaves

    def install(self, wake: Callable[[], None]) -> None:
        """Take over the leaves, and the clocks of nodes that decide by the time; after `prepare`.

        Args:
            wake: has the task ticked soon.
        """
        self.wake = wake
        parts = parts_of(self._compiled)
        for path, leaf in self._compiled.leaves.items():
            node = parts[path].node
            assert isinstance(node, model.Leaf), "leaves are leaves of the document"
            self._leaves[path] = RecordedLeaf(leaf, self, {v: port for port, v in node.out.items()})
            if type(leaf).replay_begun is not Leaf.replay_begun:
                self._listening.append(self._leaves[path])
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
            answers.judge = recorded_limit(self.clock, self.recording, answers.path, kind.codes)
        elif sense == "after":
            children = [model.join(answers.path, name) for name in ends]
            answers.judge = recorded_rest(self.clock, self.recording, answers.path, children)

    def restored(self, event: Event) -> Any:
        """Return what an event wrote."""
        return self._value(event)

    def tell_begun(self, seq: int | None) -> None:
        """Tell leaves that care which recorded activations have begun before an event, in order; None for all."""
        if not self._listening:
            return
        with self._telling:
            begun = [(activation, leaf) for leaf in self._listening if (activation := leaf.untold()) is not None]
            for activation, leaf in sorted(begun, key=lambda pair: pair[0].began):
                if seq is None or self.recording.events[activation.began].seq < seq:
                    leaf.tell_begun(activation)

    def _put(self, event: Event) -> None:
        cell = self._compiled.data[str(event.data.get("scope", ""))].cells[str(event.data["variable"])]
        cell.value = self._value(event)
        for written in cell.watchers:
            written()

    def _complete(self) -> None:
        self.clock.go()
        for _ in self.recording.requests:
            self.ask()
        self.wake()

    # --- as a pacer ---

    def turn(self) -> None:
        """A tick is about to begin: let leaves go that work by themselves."""
        if not self._begun:
            self._begun = True
            self.recording.begin()
        if self.live and self._leaves:
            with self._settling:
                for path in [path for path, leaf in self._leaves.items() if leaf.free]:
                    self._leaves.pop(path).release()

    def rest(self) -> None:
        """A tick has ended.

        Raises:
            DivergedError: nothing that was recorded happens any more.
        """
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

    def make_ticker(self, make: Callable[[Any], Callable[[], object]]) -> Callable[[Any], Callable[[], object]]:
        """Return what makes ticks: those of py_trees as long as leaves are taken over, those of `make` after it."""

        def made(node: Behaviour) -> Callable[[], object]:
            quick: list[Callable[[], object]] = []

            def tick() -> object:
                if not quick and self.settled and not node.status == Status.RUNNING:
                    quick.append(make(node))
                return quick[0]() if quick else node.tick_once()

            return tick

        return made


class ReExecutionPacer:
    """The pacer of a run that is executed again first: until then it doesn't wait.

    Args:
        pacing: the run's own.
        re_execution: what happens again.
    """

    def __init__(self, pacing: Pacing, re_execution: ReExecution):
        self._pacing, self._re_execution = pacing, re_execution

    def turn(self) -> int:
        """Return when it is time to tick.

        Raises:
            Halted: the run was stopped.
        """
        self._re_execution.turn()
        if self._re_execution.live:
            return self._pacing.turn()
        if self._pacing.stopped:
            raise Halted
        return 0

    def rest(self, seen: int) -> None:
        """Return when there may be something to look at."""
        if self._re_execution.live:
            self._pacing.rest(seen)
        else:
            self._re_execution.rest()

    def wake(self) -> None:
        """Have every `rest` return."""
        self._pacing.wake()


class NewEvents:
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
