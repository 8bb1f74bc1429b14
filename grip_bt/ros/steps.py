"""Several calls, one after the other, written as one function: a generator that yields operations.

What a function here yields is an `Operation`; it goes on with its result, or with its error, when that ends, in the
thread that ended it. So such a function reads like blocking code and blocks nobody.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Generator
from typing import Any, TypeVar

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation

T = TypeVar("T")
Steps = Generator[Operation[Any], Any, T]
"""A function of several calls; its return value is the whole's result."""


class _Walk:
    """One run of such a function. Cancelling it cancels the call under way, and no other is begun."""

    def __init__(self, steps: Steps[Any]):
        self.whole: Operation[Any] = Operation(on_cancel=self._cancel)
        self._steps = steps
        self._part: Operation[Any] | None = None

    def start(self) -> None:
        self._go_on(lambda: next(self._steps))

    def _go_on(self, step: Callable[[], Operation[Any]]) -> None:
        try:
            part = step()
        except StopIteration as end:
            self.whole.succeed(end.value)
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            self.whole.fail(error)
        else:
            self._part = part
            if self.whole.cancel_asked:
                part.cancel()
            part.add_done_callback(lambda: self._ended(part))

    def _ended(self, part: Operation[Any]) -> None:
        try:
            result = part.result()
        except BaseException as raised:  # noqa: BLE001 - the function decides
            error = raised
            self._go_on(lambda: self._steps.throw(error))
            return
        if self.whole.cancel_asked:
            self._go_on(lambda: self._steps.throw(CanceledError("canceled")))
        else:
            self._go_on(lambda: self._steps.send(result))

    def _cancel(self) -> None:
        if self._part is not None:
            self._part.cancel()


def walk(steps: Steps[T]) -> Operation[T]:
    """Begin a function of several calls; the operation ends with what it returns or raises."""
    walked = _Walk(steps)
    walked.start()
    return walked.whole


class Line:
    """Begins one operation after the other, each when the one before has ended: for a server with one state."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: deque[tuple[Operation[None], Operation[Any]]] = deque()
        self._busy = False

    def join(self, begin: Callable[[], Operation[T]]) -> Operation[T]:
        """Have `begin` called when it is its turn; cancelling before that ends it at once."""
        turn: Operation[None] = Operation(on_cancel=lambda: self._leave(turn))
        began: Operation[Any] = turn.then(lambda _: begin())
        with self._lock:
            self._waiting.append((turn, began))
        self._next()
        return began

    def _leave(self, turn: Operation[None]) -> None:
        with self._lock:
            waits = any(one is turn for one, _ in self._waiting)
            self._waiting = deque(pair for pair in self._waiting if pair[0] is not turn)
        if waits:
            turn.fail(CanceledError("canceled before its turn"))

    def _next(self) -> None:
        with self._lock:
            if self._busy or not self._waiting:
                return
            turn, began = self._waiting.popleft()
            self._busy = True
        began.add_done_callback(self._freed)
        turn.succeed(None)

    def _freed(self) -> None:
        with self._lock:
            self._busy = False
        self._next()
