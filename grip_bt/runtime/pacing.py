"""When a run ticks: on a wake, at a time somebody asked for, by polling or at a rate, and as its controls say."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Literal

from grip_bt.compilers import Halted
from grip_bt.compilers.behaviour_state import alone
from grip_bt.runtime.clock import Waker

State = Literal["running", "paused", "stopping"]


class Pacing:
    """The pacer of a run; its commands may be given from any thread.

    Attributes:
        poll: how long [s] to wait at most before the next tick, for leaves that wake nobody; None waits for a wake.
        rate: ticks a second of the run's clock, however many wakes there are; None ticks on wakes.
        ticks: how many there were; a machine's concurrent states count each of theirs.
        begun: thread -> when [s, monotonic] the tick that it is in has begun; for the watch-dog.
    """

    def __init__(self, waker: Waker, poll: float | None = 0.05, rate: float | None = None):
        if rate is not None and not rate > 0:
            raise ValueError(f"a rate is a number of ticks a second, more than 0: {rate}")
        self.poll, self.rate, self.ticks = poll, rate, 0
        self.begun: dict[int, float] = {}
        self._waker = waker
        self._next = 0.0
        self._gate = threading.Condition()
        self._paused = self.stopped = False
        self._steps = self._holding = self._releases = 0
        self._listeners: list[Callable[[State], None]] = []

    @property
    def state(self) -> State:
        return "stopping" if self.stopped else "paused" if self._paused else "running"

    @property
    def holding(self) -> bool:
        """Whether somebody holds in the middle of a tick."""
        return self._holding > 0

    def on_state(self, listener: Callable[[State], None]) -> None:
        """Call `listener(state)` at each change, in the thread that asked for it."""
        self._listeners.append(listener)

    # --- for the run ---

    def turn(self) -> int:
        with self._gate:
            while self._paused and not self._steps and not self.stopped:
                self._gate.wait()
            if self.stopped:
                raise Halted
            if self._paused:
                self._steps -= 1
            self.ticks += 1
        self.begun[threading.get_ident()] = time.monotonic()
        return self._waker.wakes

    def rest(self, seen: int) -> None:
        self.begun.pop(threading.get_ident(), None)
        if self._paused or self.stopped:
            return
        if self.rate is None:
            self._waker.wait(seen, self.poll)
        else:
            self._keep_time(self.rate)

    def fork(self, count: int) -> list[AbstractContextManager[object]]:
        turns = self._waker.turns
        return alone(count) if turns is None else turns.fork(count)

    def joined(self) -> AbstractContextManager[object]:
        turns = self._waker.turns
        return alone(1)[0] if turns is None else turns.joined()

    def _keep_time(self, rate: float) -> None:
        """Wait for the next multiple of the period; ticks that came too late are left out, not made up for."""
        now = self._waker.now()
        self._next = max(self._next + 1.0 / rate, now) if self._next else now + 1.0 / rate
        while not self._paused and not self.stopped:
            seen = self._waker.wakes
            if self._waker.now() >= self._next:
                return
            self._waker.wake_at(self._next)
            self._waker.wait(seen, None)

    def hold(self, tell: Callable[[], None] = lambda: None) -> None:
        """Pause here, in the middle of a tick, until the next command; one that comes during `tell` counts already.

        Raises:
            Halted: the command is a stop.
        """
        me = threading.get_ident()
        self.begun.pop(me, None)
        with self._gate:
            seen = self._releases
            self._holding += 1
        try:
            tell()
            self._change(paused=True, unless_released=seen)
            with self._gate:
                while self._releases == seen and not self.stopped:
                    self._gate.wait()
                if self.stopped:
                    raise Halted
        finally:
            with self._gate:
                self._holding -= 1
        self.begun[me] = time.monotonic()

    def wake(self) -> None:
        self._waker.wake()

    # --- for whoever controls it ---

    def pause(self) -> None:
        """Tick no more until `resume` or `step`; a tick under way ends first."""
        self._change(paused=True)

    def resume(self) -> None:
        self._change(paused=False)

    def step(self) -> None:
        """Pause, and let one tick through; where one is held in its middle, let that one end."""
        self._change(paused=True, steps=1)

    def stop(self) -> None:
        """Halt: everything that runs is interrupted, at once, and nothing recovers."""
        self._change(stopped=True)

    def _change(
        self, paused: bool | None = None, steps: int = 0, stopped: bool = False, unless_released: int | None = None
    ) -> None:
        with self._gate:
            if unless_released not in (None, self._releases):
                return
            before = self.state
            if paused is not None:
                self._paused = paused
            if steps or paused is False:
                self._releases += 1
            self._steps = 0 if not self._paused or self._holding else self._steps + steps
            self.stopped = self.stopped or stopped
            after = self.state
            self._gate.notify_all()
        self._waker.wake()
        if after != before:
            for listener in list(self._listeners):
                listener(after)
