"""Several calls, one after the other, written as one function: a generator that yields operations.

What a function here yields is an `Operation`; it goes on with its result, or with its error, when that ends, in the
thread that ended it. So such a function reads like blocking code and blocks nobody.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from functools import partial
from typing import Any, TypeVar

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation

T = TypeVar("T")
Steps = Generator[Operation[Any], Any, T]
"""A function of several calls; its return value is the operation's result."""


def run_steps(steps: Steps[T]) -> Operation[T]:
    """Begin a function of several calls; the operation ends with what it returns or raises.

    Cancelling it cancels the call under way, and no other is begun.
    """
    under_way: Operation[object] | None = None

    def cancel() -> None:
        if under_way is not None:
            under_way.cancel()

    def advance(step: Callable[[], Operation[object]]) -> None:
        nonlocal under_way
        while True:  # calls that end at once don't deepen the stack, so their number doesn't matter
            try:
                inner = under_way = step()
            except StopIteration as end:
                operation.succeed(end.value)
                return
            except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
                operation.fail(error)
                return
            operation.works_with(inner)
            if operation.cancel_asked:
                inner.cancel()
            step = partial(following, inner)
            if not inner.done():
                inner.add_done_callback(partial(advance, step))
                return

    def following(inner: Operation[object]) -> Operation[object]:
        try:
            result = inner.result()
        except BaseException as error:  # noqa: BLE001 - the function decides
            return steps.throw(error)
        return steps.throw(CanceledError("canceled")) if operation.cancel_asked else steps.send(result)

    operation: Operation[T] = Operation(on_cancel=cancel)
    advance(lambda: next(steps))
    return operation


class Sequencer:
    """Begins one operation after the other, each when the one before has ended: for a server with one state."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: Operation[None] = Operation.finished(None)

    def submit(self, begin: Callable[[], Operation[T]]) -> Operation[T]:
        """Have `begin` called when it is its turn; cancelling before that ends it at once."""

        def leave() -> None:
            turn.fail(CanceledError("canceled before its turn"))

        turn, over = Operation[None](leave), Operation[None]()

        def end() -> None:
            over.succeed(None)

        def start() -> None:
            turn.succeed(None)

        with self._lock:
            before, self._last = self._last, over
        began: Operation[T] = turn.then(lambda _: begin())
        began.add_done_callback(lambda: before.add_done_callback(end))
        before.add_done_callback(start)
        return began
