"""A run and a simulated world take turns, so that a seed gives the same run again, bit by bit.

Simulated time stands still while the run works: during ticks and callbacks, and while something is pending that isn't
physics: a plan, a component's answer, a frame, code in a worker. What ends is told to the run one thing after the
other, in the order in which they were asked for and not in the order in which they were quicker, each when the run has
reacted to the one before. Only when nothing is pending does the world go on, up to the next end of a motion or the next
moment that somebody waits for. Concurrent threads of a machine work one at a time, in the document's order.

A call holds time as long as who answers it thinks, which takes long on a busy machine. One that nobody works on holds
it for so long of ours as the next moment is away that the run waits for, and at least `GRACE`. Then time goes on
without it, and a time-out around it ends at its own moment of the run's clock.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from typing import Any, TypeVar

from grip_bt.base.operation import WAITS, Operation
from grip_bt.base.ports import Stepped
from grip_bt.runtime.clock import Waker
from grip_bt.runtime.pending import Patience, Pending, thought_of

T = TypeVar("T")
GRACE = 10.0
"""Least time for which a call holds simulated time [s of ours]."""
IDLE = 0.1
"""Where nobody is known to wait for anything, time passes as ours does, in parts of this [s]."""
LOOK = 0.005
"""Interval at which code that goes on although it was told to stop is looked at [s of ours]."""


@dataclass(eq=False)
class _Thread:
    """A thread of the run. `key` orders those of a machine as the document does."""

    key: tuple[int, ...]
    ready: Callable[[], bool] = lambda: True
    look_at: float | None = None
    branches: int = 0


_CALLER: ContextVar[Pending | None] = ContextVar("grip_caller", default=None)
"""For whom the code in this worker works."""


class Lockstep:
    """The turns of one run at a time and its simulated world.

    Before `begin` and after `end` it changes nothing: the world goes by itself, and ends come when they come.
    """

    def __init__(self, world: Stepped):
        self._world, self._now = world, world.clock.now
        self._on = False
        self._changed = threading.Condition()

    @property
    def on(self) -> bool:
        return self._on

    # --- for the runner ---

    def enter(self) -> None:
        """Have the run's clock show simulated time alone, until `leave`: from before the run's first event."""
        self._world.keep_to_simulated(True)

    def leave(self) -> None:
        """Let our time go on in the clock: after the run's last event."""
        self._world.keep_to_simulated(False)

    def begin(self, waker: Waker) -> None:
        """Take turns from now on; called by the run's thread, whose turn it is."""
        self._waker, self._changed = waker, waker.condition
        self._first = _Thread(())
        self._threads: dict[int, _Thread] = {threading.get_ident(): self._first}
        self._turn: _Thread | None = self._first
        self._waiting: list[_Thread] = []
        self._pending: list[Pending] = []
        self._busy: list[Pending] = []
        self._count, self._going, self._known = 0, False, -1
        self._driver: int | None = None
        WAITS.set(self._until_done)
        self._on = True
        waker.turns = self
        self._world.take_turns(partial(self.through, patient=True), self._stood)

    def end(self) -> None:
        """Let the world go by itself again; calls that have been answered end as cancelled. Harmless if repeated."""
        self._let_go(canceled=True)

    def _let_go(self, canceled: bool) -> None:
        with self._changed:
            if not self._on:
                return
            self._on = False
            ready = [pending for pending in sorted(self._pending, key=_key) if pending.finish is not None]
            self._changed.notify_all()
        self._world.go_freely()
        for pending in ready:
            pending.tell(canceled)

    def through(self, operation: Operation[T], *, holds: bool = True, patient: Patience = False) -> Operation[T]:
        """Return an operation for the run, which hears of its end in turn.

        Args:
            holds: whether time stands still until then.
            patient: see `Patience`.
        """
        return operation.in_turn(partial(self._hand_in, self._ask(holds, patient))) if self._on else operation

    def work(self, run: Callable[[Callable[[], T]], Operation[T]], work: Callable[[], T]) -> Operation[T]:
        """Run code in a worker; time stands still for it but while it waits for an operation itself."""
        if not self._on:
            return run(work)
        pending, begun = self._ask(holds=True, patient=False), threading.Event()

        def known() -> T:
            pending.patient = partial(thought_of, os.getpid(), threading.get_native_id())
            begun.set()
            caller, waits = _CALLER.set(pending), WAITS.set(partial(self._while_waiting, pending))
            try:
                return work()
            finally:
                _CALLER.reset(caller)
                WAITS.reset(waits)

        operation = run(known)
        begun.wait()  # or else it would depend on the threads whether code is begun that is interrupted soon
        return operation.in_turn(partial(self._hand_in, pending))

    def _ask(self, holds: bool, patient: Patience) -> Pending:
        caller = _CALLER.get()
        with self._changed:
            if caller is None:
                self._count += 1
                key: tuple[int, ...] = (self._count,)
            else:
                caller.count += 1
                key = (*caller.key, caller.count)
            pending = Pending(key, holds, patient, time.monotonic(), known=patient() if callable(patient) else {})
            self._pending.append(pending)
        return pending

    def _hand_in(self, pending: Pending, whole: Operation[object], finish: Callable[[], None]) -> None:
        with self._changed:
            if self._on and pending in self._pending:
                pending.whole, pending.finish = whole, finish
                self._changed.notify_all()
                return
        finish()

    @contextmanager
    def _while_waiting(self, pending: Pending, operation: Operation[object]) -> Iterator[None]:
        with self._changed:
            pending.waits.append(operation)
            pending.waited = True
            self._changed.notify_all()
        try:
            yield
        finally:
            with self._changed:
                pending.waits.remove(operation)

    # --- for the threads of the run ---

    def rest(self, seen: int, poll: float | None) -> None:
        self.rest_until(lambda: self._waker.wakes != seen, poll)

    def rest_until(self, over: Callable[[], bool], within: float | None) -> None:
        """Return when `over()`, which is asked whenever something has happened, or after `within` [s] on that clock."""
        thread = self._thread()
        look_at = None if within is None else self._now() + within
        thread.look_at = look_at
        thread.ready = lambda: over() or (look_at is not None and self._now() >= look_at)
        self._give_turn(thread)
        thread.look_at = None

    def fork(self, count: int) -> list[AbstractContextManager[object]]:
        if not self._on:
            return [nullcontext() for _ in range(count)]
        parent = self._thread()
        with self._changed:
            parent.branches = count
            branches = [_Thread((*parent.key, number)) for number in range(count)]
            self._waiting += branches
        return [self._branch(parent, thread) for thread in branches]

    @contextmanager
    def joined(self) -> Iterator[None]:
        if not self._on:
            yield
            return
        thread = self._thread()
        thread.ready = lambda: thread.branches == 0
        self._rest_from_now(thread)
        try:
            yield
        finally:
            self._take_turns(thread)

    @contextmanager
    def _branch(self, parent: _Thread, thread: _Thread) -> Iterator[None]:
        with self._changed:
            self._threads[threading.get_ident()] = thread
        WAITS.set(self._until_done)
        self._take_turns(thread)
        try:
            yield
        finally:
            with self._changed:
                parent.branches -= 1
                del self._threads[threading.get_ident()]
                if self._turn is thread:
                    self._turn = None
                self._changed.notify_all()

    @contextmanager
    def _until_done(self, operation: Operation[object]) -> Iterator[None]:
        """Go on until an operation has ended for which a thread of the run waits, blocking."""
        me = threading.get_ident()
        if self._on and me in self._threads and me != self._driver:  # a callback that waits has others wait
            thread = self._thread()
            thread.ready = operation.done
            self._give_turn(thread)
        yield

    def _thread(self) -> _Thread:
        return self._threads.get(threading.get_ident(), self._first)

    def _give_turn(self, thread: _Thread) -> None:
        self._rest_from_now(thread)
        self._take_turns(thread)

    def _rest_from_now(self, thread: _Thread) -> None:
        with self._changed:
            self._waiting.append(thread)
            if self._turn is thread:
                self._turn = None
            self._changed.notify_all()

    def _take_turns(self, thread: _Thread) -> None:
        """Return when it is this thread's turn; until then one of those that wait has the next thing happen."""
        while True:
            with self._changed:
                if not self._on or self._turn is thread:
                    return
                if self._turn is not None or self._driver is not None:
                    self._changed.wait()
                    continue
                action = self._next()
                if action is None:
                    continue
                self._driver = threading.get_ident()
            try:
                action()
            finally:
                with self._changed:
                    self._driver = None
                    self._changed.notify_all()

    def _next(self) -> Callable[[], None] | None:
        """Give a thread its turn, or wait a little, or return what is to be done; nothing of the run works."""
        waker = self._waker
        waker.ring()
        if any(not pending.busy for pending in self._busy):
            self._busy = [pending for pending in self._busy if pending.busy]
            waker.wake()
        ready = min((thread for thread in self._waiting if thread.ready()), key=_key, default=None)
        if ready is not None:
            self._waiting.remove(ready)
            self._turn = ready
            self._changed.notify_all()
            return None
        if self._known != self._world.sent:  # what was sent may have ended motions
            return partial(self._go, self._now(), waker.wakes)
        for pending in sorted(self._pending, key=_key):
            if pending.ready:
                self._pending.remove(pending)
                self._busy += [pending] if pending.busy else []
                return pending.tell
            if pending.holds_now():
                self._wait_for(pending, waker.due)
                return None
        moments = [t for t in (waker.due, *(thread.look_at for thread in self._waiting)) if t is not None]
        moving = any(pending.patient is True and not pending.holds for pending in self._pending)
        if (waker.due is None and not moving) or self._busy:  # what is looked at or waited for may not be simulated
            least = min([IDLE, *(moment - self._now() for moment in moments)])
            if self._changed.wait(least):
                return None
            moments.append(self._now() + least)
        return partial(self._go, min(moments, default=None), waker.wakes)

    def _wait_for(self, pending: Pending, due: float | None) -> None:
        left = None
        if pending.patient is not True:
            passed = time.monotonic() - pending.asked
            left = (GRACE if due is None else max(GRACE, due - self._now())) - passed
            if left <= 0:
                pending.look_again(passed)
                return
        if pending.busy:
            left = LOOK
        self._changed.wait(left)

    def _go(self, until: float | None, wakes: int) -> None:
        """Let the world go on up to a moment, or to the end of a motion, or until the run has something to do."""
        waker = self._waker
        self._going, before = True, self._now()
        told = until is not None and until <= before  # what ends now does so, whatever else happens meanwhile
        self._known = self._world.sent
        if not self._world.go(until):
            self._let_go(canceled=False)
            return
        with self._changed:
            while self._going and self._on:
                if told or (waker.wakes == wakes and not any(pending.ready for pending in self._pending)):
                    self._changed.wait()
                else:
                    told = True
                    self._world.stand()
            if until is not None and before < until and self._now() == before:
                self._changed.wait(IDLE)  # a world that was told to stand for good

    def _stood(self) -> None:
        """The world has gone as far as it should; all ends until then were handed in."""
        with self._changed:
            self._going = False
            self._changed.notify_all()


class InTurn:
    """A part of the robot, or a component, the ends of whose operations come in turn; see `Lockstep.through`.

    For its methods named in `waiting`, which wait for what happens outside, time goes on meanwhile.
    """

    def __init__(self, part: object, lockstep: Lockstep, patient: Patience = False, waiting: tuple[str, ...] = ()):
        self._part, self._lockstep, self._patient, self._events = part, lockstep, patient, waiting

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._part, name)
        return partial(self._call, name, found) if callable(found) else found

    def _call(self, name: str, method: Callable[..., object], *args: object, **named: object) -> Any:
        begun = method(*args, **named)
        if not isinstance(begun, Operation):
            return begun
        return self._lockstep.through(begun, holds=name not in self._events, patient=self._patient)


_key = attrgetter("key")
