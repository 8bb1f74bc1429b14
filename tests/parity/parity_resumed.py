"""Random tasks that are killed after any event, and gone on with from what was recorded until then.

The world is what is outside: leaves' work and the clock live in it and outlast the process. A leaf that is resumed goes
on where it was, and a resumed run must do to the letter what one does that was not killed.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from parity_world import MAX_TURNS, ScriptedLeaf, World, catalog_of
from py_trees.common import Status

from grip_bt.base.errors import DivergedError, NodeError
from grip_bt.compilers import CompiledMachine, CompiledTree, Halted, to_machine, to_tree
from grip_bt.nodes.node import AskedBefore
from grip_bt.runtime import Event, ReExecution
from grip_bt.runtime.pacing import Pacing
from grip_bt.runtime.recording import PREEMPT, NewEvents
from grip_bt.task.model import Task


class Killed(BaseException):
    """The process is no more."""


@dataclass
class Outside(World):
    """The world of a run that may be killed after `kill_at` events; `seen` are those that were recorded."""

    kill_at: int | None = None
    dead: bool = False
    under_way: dict[str, dict[str, Any]] = field(default_factory=dict)
    seen: list[Event] = field(default_factory=list)
    asked: dict[tuple[str, int, str], str] = field(default_factory=dict)
    """Activation and its end -> whether the leaf was asked to end before it began, meanwhile, or not."""
    stopped: bool = False
    recording: threading.RLock = field(default_factory=threading.RLock)

    def turn(self) -> int:
        if self.dead:
            raise Killed
        return super().turn()

    def note(self, path: str, *event: Any) -> None:
        with self.recording:
            if self.dead:
                return
            kind, outcome, code, data = event[0], None, None, {}
            match event:
                case ("exit", outcome, code):
                    pass
                case ("message", text):
                    data = {"text": text}
                case ("write", variable, _, value):
                    data = {"variable": variable, "value": value}
            self.seen.append(Event(len(self.seen) + 1, self.clock.now(), 0.0, path, kind, outcome, code, data))
            if self.kill_at is not None and len(self.seen) >= self.kill_at:
                self.dead = True
                raise Killed


class LastingLeaf(ScriptedLeaf):
    """A scripted leaf whose work goes on outside, whatever becomes of the process that has asked for it."""

    world: Outside

    asked_before = False

    def initialise(self) -> None:
        self.asked_before = self.context.preempt_requested
        super().initialise()
        self.world.under_way[self.path] = {"k": self.k, "step": self.step, "ticks": self.ticks}

    def resume(self, began: float) -> None:
        work = self.world.under_way.get(self.path)
        if work is None:
            self.initialise()
        else:
            self.asked_before = self.context.preempt_requested
            self.k, self.step, self.ticks = work["k"], work["step"], work["ticks"]

    def update(self) -> Status:
        assert self.step is not None
        if self.world.dead:
            raise Killed
        if (seconds := self.step.get("advance", 0)) and "stops" not in self.step:
            self.world.clock.advance(seconds)
            self.world.under_way[self.path]["ticks"] = max(0, self.ticks - 1)
            ended = not self.ticks
            self.step = {**self.step, "advance": 0}
            if ended:
                self.world.under_way[self.path]["step"] = self.step
            try:
                self.observer.message(self.path, "time passes")
                return super().update()
            finally:
                if self.step is not None:
                    self.step = {**self.step, "advance": seconds}
        status = super().update()
        self.world.under_way[self.path]["ticks"] = self.ticks
        return status

    def _note(self, seen: dict[str, Any], outcome: str, code: str | None) -> None:
        super()._note(seen, outcome, code)
        asked = "before" if self.asked_before else "meanwhile" if self.context.preempt_requested else "not"
        if asked == "not" and isinstance(self.context, AskedBefore):
            asked = "soon"  # it ends in the tick in which it goes on, and would have seen a request in the next one
        self.world.asked[self.path, self.k, outcome] = asked

    def terminate(self, new_status: Status) -> None:
        if not self.world.dead:
            super().terminate(new_status)
            self.world.under_way.pop(self.path, None)


@dataclass
class Life:
    """What a run did."""

    end: tuple[Any, ...]
    events: list[Event]
    data: dict[Any, Any]
    asked: dict[tuple[str, int, str], str]
    whole: bool
    """Whether it came to its end, and not to that of our patience."""


class _Context:
    """What nodes are offered; the clock is that of the process."""

    def __init__(self, clock: Any):
        self.clock, self.preempt_requests = clock, 0

    @property
    def preempt_requested(self) -> bool:
        """Whether somebody asked the task to come to an end."""
        return self.preempt_requests > 0

    def wake(self) -> None:
        """Nothing waits here."""

    def wake_at(self, time: float) -> None:
        """Nothing waits here."""


class _Pacing(Pacing):
    """The world as the pacing of a run."""

    def __init__(self, world: Outside):
        self.world = world

    @property
    def stopped(self) -> bool:
        return self.world.stopped

    def turn(self) -> int:
        return self.world.turn()

    def rest(self, seen: int) -> None:
        """Go on at once."""

    def wake(self) -> None:
        """Nothing waits here."""


def _asking(compiled: CompiledTree | CompiledMachine, context: _Context) -> Callable[[], None]:
    """Return what asks the task to come to an end."""

    def ask() -> None:
        context.preempt_requests += 1
        if isinstance(compiled, CompiledMachine):
            compiled.request_preempt()

    return ask


def _compiled(case: dict[str, Any], world: Outside, target: str) -> CompiledTree | CompiledMachine:
    def make(path: str, node: Any, manifest: Any) -> LastingLeaf:
        leaf = LastingLeaf(path, path, manifest, dict(node.with_), dict(node.meaning))
        leaf.world = world
        return leaf

    compile_task = to_machine if target == "sm" else to_tree
    return compile_task(Task.model_validate(case["task"]), catalog_of(case), leaf_factory=make)


def _world(case: dict[str, Any], kill_at: int | None) -> Outside:
    return Outside(case["scripts"], case.get("preempt_at"), kill_at=kill_at)


def _life(world: Outside, compiled: CompiledTree | CompiledMachine, execute: Callable[[], Any]) -> Life | None:
    """Execute; None when the process was killed."""
    try:
        reached = execute()
        end: tuple[Any, ...] = (reached.outcome, reached.meaning, reached.failure.code if reached.failure else None)
    except Killed:
        return None
    except Halted:
        end = ("stopped",)
    except NodeError as error:
        if isinstance(error.cause, DivergedError):
            raise
        end = ("error", error.path, str(error.cause))
    except BaseException:
        if world.dead:  # smach wraps what is raised
            return None
        raise
    if world.dead:
        return None
    whole = not world.over_budget and world.turns <= MAX_TURNS and end != ("stopped",)
    return Life(end, world.seen, compiled.data.snapshot(), dict(world.asked), whole)


def live(case: dict[str, Any], target: str, kill_at: int | None = None) -> tuple[Life | None, Outside]:
    """Run a case, as a tree by py_trees itself or as a machine, until it ends or is killed."""
    world = _world(case, kill_at)
    compiled = _compiled(case, world, target)
    compiled.observe(world)
    context = _Context(world.clock)
    compiled.prepare(context)
    ask = _asking(compiled, context)

    def request_preempt() -> None:
        world.note("/", PREEMPT)
        ask()

    world.request_preempt = request_preempt
    return _life(world, compiled, lambda: compiled.execute(world)), world


def resume(case: dict[str, Any], target: str, world: Outside) -> Life | None:
    """Go on with a run that was killed, from its events, in a task that is compiled anew."""
    world.dead, world.kill_at = False, None
    compiled = _compiled(case, world, target)
    how: dict[str, Any] = dict.fromkeys(compiled.leaves, "resume")
    events = list(world.seen)
    told = {"part": "planner", "text": "planner: its process was ended"}  # what nobody repeats
    events.insert(len(events) // 2, Event(0, events[len(events) // 2].t, 0.0, "/", "message", None, None, told))
    re_execution = ReExecution(compiled, events, lambda event: event.data["value"], world.clock, how=how)
    compiled.observe(NewEvents(re_execution.recording, world))
    context = _Context(re_execution.clock)
    compiled.prepare(context)
    re_execution.ask = _asking(compiled, context)
    world.preempt_at = None if any(event.event == PREEMPT for event in events) else world.preempt_at
    world.request_preempt = lambda: (world.note("/", PREEMPT), re_execution.ask())
    re_execution.install(lambda: None)
    re_execution.pacing = _Pacing(world)
    life = _life(world, compiled, lambda: compiled.execute(re_execution))
    undone = {event.seq for event in re_execution.recording.undone}
    if life is not None:
        life.events = [event for event in life.events if event.seq not in undone]
    return life
