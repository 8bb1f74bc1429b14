"""When a run ticks: on a wake, at a time somebody asked for, by polling, and as run / pause / step / stop say."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Literal

from grip_bt.compilers import Halted

from .waker import Waker

State = Literal["running", "paused", "stopping"]


class Pacing:
    """The pacer of a run; its commands may be given from any thread.

    Attributes:
        poll: how long [s] to wait at most before the next tick, for leaves that wake nobody; None waits for a wake.
        ticks: how many there were; a machine's concurrent states count each of theirs.
    """

    def __init__(self, waker: Waker, poll: float | None = 0.05):
        self.poll, self.ticks = poll, 0
        self._waker = waker
        self._gate = threading.Condition()
        self._paused = self._stopped = False
        self._steps = 0
        self._listeners: list[Callable[[State], None]] = []

    @property
    def state(self) -> State:
        """What it does now."""
        return "stopping" if self._stopped else "paused" if self._paused else "running"

    @property
    def stopped(self) -> bool:
        """Whether a stop was asked for."""
        return self._stopped

    def on_state(self, listener: Callable[[State], None]) -> None:
        """Call `listener(state)` at each change, in the thread that asked for it."""
        self._listeners.append(listener)

    # --- for the run ---

    def turn(self) -> int:
        """Return when it is time to tick.

        Raises:
            Halted: the run was stopped.
        """
        with self._gate:
            while self._paused and not self._steps and not self._stopped:
                self._gate.wait()
            if self._stopped:
                raise Halted
            if self._paused:
                self._steps -= 1
            self.ticks += 1
        return self._waker.wakes

    def rest(self, seen: int) -> None:
        """Return when there may be something to look at."""
        if not self._paused and not self._stopped:
            self._waker.wait(seen, self.poll)

    def wake(self) -> None:
        """Have every `rest` return."""
        self._waker.wake()

    # --- for whoever controls it ---

    def pause(self) -> None:
        """Tick no more until `resume` or `step`; a tick under way ends first."""
        self._change(paused=True)

    def resume(self) -> None:
        """Go on."""
        self._change(paused=False)

    def step(self) -> None:
        """Pause, and let one tick through."""
        self._change(paused=True, steps=1)

    def stop(self) -> None:
        """Halt: everything that runs is interrupted, at once, and nothing recovers."""
        self._change(stopped=True)

    def _change(self, paused: bool | None = None, steps: int = 0, stopped: bool = False) -> None:
        with self._gate:
            before = self.state
            if paused is not None:
                self._paused = paused
            self._steps = self._steps + steps if self._paused else 0
            self._stopped = self._stopped or stopped
            after = self.state
            self._gate.notify_all()
        self._waker.wake()
        if after != before:
            for listener in list(self._listeners):
                listener(after)
