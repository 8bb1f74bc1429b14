"""A request under way: the one shape in which slow things (motions, plans, calls, captures) come to a task.

An operation never blocks its owner. It ends exactly once, with a result or with an error, from any thread; whoever
waits is called back. Cancelling is a request: the operation ends soon afterwards, with `CanceledError` or with the
result that was quicker.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, nullcontext, suppress
from contextvars import ContextVar
from typing import Any, Generic, TypeVar

from grip_bt.base.failures import CanceledError

STOPPED = "stopped"
"""In the data of an error: False where what it ended wasn't confirmed to have stopped."""
T = TypeVar("T")
U = TypeVar("U")

WAITS: ContextVar[Callable[[Operation[Any]], AbstractContextManager[object]] | None]
WAITS = ContextVar("grip_waits", default=None)
"""In code that works for a run: entered while that code waits for an operation, so that the run doesn't wait for it."""
LEFT: ContextVar[Callable[[Operation[Any]], None] | None] = ContextVar("grip_left", default=None)
"""In a coroutine of a leaf: told of what was cancelled there, and may be `busy` although it has ended."""


class Operation(Generic[T]):
    """Something that will have a result.

    Args:
        on_cancel: called once, by the first `cancel()` before the end; it asks the work to stop and returns at once.
            Without it, cancelling ends the operation at once.
    """

    def __init__(self, on_cancel: Callable[[], None] | None = None):
        self._on_cancel = on_cancel
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._result: T | None = None
        self._error: BaseException | None = None
        self._callbacks: list[Callable[[], object]] = []
        self._cancel_asked = False
        self._progress: Callable[[], Any] = lambda: None
        self._parts: list[Operation[Any]] = []
        self._working = False

    @classmethod
    def finished(cls, result: T) -> Operation[T]:
        """Return an operation that has already ended with `result`."""
        operation: Operation[T] = cls()
        operation.succeed(result)
        return operation

    @classmethod
    def failed(cls, error: BaseException) -> Operation[T]:
        """Return an operation that has already ended with `error`."""
        operation: Operation[T] = cls()
        operation.fail(error)
        return operation

    # --- for the owner ---

    def done(self) -> bool:
        """Tell whether it has ended."""
        return self._ended.is_set()

    def result(self) -> T:
        """Return the result, or raise the error that ended it; RuntimeError where it hasn't ended."""
        if not self.done():
            raise RuntimeError("the operation hasn't ended; wait for done() or add a callback")
        if self._error is not None:
            raise self._error
        return self._result  # type: ignore[return-value]

    def wait(self, timeout: float | None = None) -> bool:
        """Block until it ends, at most `timeout` [s]; for scripts and tests, never for a leaf's `update`."""
        if self._ended.is_set():
            return True
        with _waiting(self):
            return self._ended.wait(timeout)

    def wait_here(self, timeout: float | None = None) -> bool:
        """Likewise for what is answered in no time, by whom the run itself doesn't work; the run stands still."""
        return self._ended.wait(timeout)

    def __await__(self) -> Generator[Any, None, T]:
        """Wait for it in a coroutine, and return its result or raise its error.

        Where the coroutine is cancelled there, this is cancelled too, and the coroutine goes on when it has ended: what
        moves has stopped then. Where nobody can say that, the error that says so is raised.
        """
        import asyncio  # here: this module is imported by everything, asyncio by few

        asked: asyncio.CancelledError | None = None
        with nullcontext() if self.done() else _waiting(self):
            while True:
                try:
                    yield from self._ended_in(asyncio.get_running_loop())
                    break
                except asyncio.CancelledError as error:
                    asked = error
                    self.cancel()
        if asked is None or self.given_up:
            return self.result()
        left = LEFT.get()
        if left is not None:
            left(self)
        raise asked

    def _ended_in(self, loop: Any) -> Any:
        ended = loop.create_future()

        def end() -> None:
            if not ended.done():
                ended.set_result(None)

        def tell() -> None:
            with suppress(RuntimeError):  # the loop is closed: nobody waits any more
                loop.call_soon_threadsafe(end)

        self.add_done_callback(tell)
        return ended

    def cancel(self) -> None:
        """Ask it to stop. Returns at once; harmless when it was asked before or has ended."""
        with self._lock:
            if self._cancel_asked or self._ended.is_set():
                return
            self._cancel_asked = True
        if self._on_cancel is None:
            self.fail(CanceledError("canceled"))
        else:
            self._on_cancel()

    @property
    def busy(self) -> bool:
        """Whether code that can't be interrupted works for it, also after its end; set by whoever runs that code."""
        return self._working or any(part.busy for part in self._parts)

    @busy.setter
    def busy(self, works: bool) -> None:
        self._working = works

    @property
    def lingers(self) -> bool:
        """Whether something still works for it although it was asked to stop."""
        return self._cancel_asked and (self.busy or not self.done())

    @property
    def given_up(self) -> str:
        """Why it ended without a word of who worked for it, who may still work; empty where that isn't so."""
        return str(self._error) if getattr(self._error, "data", {}).get(STOPPED) is False else ""

    @property
    def cancel_asked(self) -> bool:
        """Whether `cancel` was called."""
        return self._cancel_asked

    @property
    def progress(self) -> Any:
        """What the work last said of how far it is; None when it said nothing."""
        return self._progress()

    def add_done_callback(self, callback: Callable[[], object]) -> None:
        """Call `callback()` when it ends, from the thread that ended it; at once if it has ended."""
        with self._lock:
            if not self._ended.is_set():
                self._callbacks.append(callback)
                return
        callback()

    # --- for whoever does the work ---

    def works_with(self, part: Operation[Any]) -> None:
        """Be busy as long as `part` is."""
        self._parts.append(part)

    def report(self, progress: Any) -> None:
        """Say how far it is, for who looks at `progress`; nobody is woken."""
        self._progress = lambda: progress

    def progress_through(self, convert: Callable[[Any], Any]) -> None:
        """Have `progress` converted whenever somebody looks at it."""
        inner = self._progress
        self._progress = lambda: convert(inner())

    def succeed(self, result: T) -> bool:
        """End it with a result; False when it had ended already."""
        return self._end(result, None)

    def fail(self, error: BaseException) -> bool:
        """End it with an error; False when it had ended already."""
        return self._end(None, error)

    def _end(self, result: T | None, error: BaseException | None) -> bool:
        with self._lock:
            if self._ended.is_set():
                return False
            self._result, self._error = result, error
            self._ended.set()
            callbacks, self._callbacks = self._callbacks, []
        errors: list[BaseException] = []
        for callback in callbacks:
            try:
                callback()
            except BaseException as error:  # noqa: BLE001 - one that raises must not keep the others waiting
                errors.append(error)
        if errors:
            raise errors[0]
        return True

    def then(self, step: Callable[[T], Operation[U]]) -> Operation[U]:
        """Return an operation that goes on with `step(result)` when this one succeeds.

        `step` runs in the thread that ended this one and must not block. An error of either part, or one raised by
        `step`, ends the whole; cancelling the whole cancels the part that is under way. The whole's progress is that
        of this one.
        """
        part: list[Operation[U]] = []
        whole: Operation[U] = Operation(on_cancel=lambda: (part[0] if part else self).cancel())
        whole._parts, whole._progress = [self], lambda: self.progress

        def first_ended() -> None:
            if self._error is not None:
                whole.fail(self._error)
                return
            if whole.cancel_asked:
                whole.fail(CanceledError("canceled"))
                return
            try:
                second = step(self.result())
            except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
                whole.fail(error)
                return
            part.append(second)
            whole.works_with(second)
            if whole.cancel_asked:
                second.cancel()
            second.add_done_callback(lambda: _copy_end(second, whole))

        self.add_done_callback(first_ended)
        return whole

    def in_turn(self, hand_in: Callable[[Operation[T], Callable[[], None]], None]) -> Operation[T]:
        """Return this operation for somebody to whom its end comes when it is its turn.

        Args:
            hand_in: called when this one has ended, in the thread that ended it, with what was returned and what ends
                that.
        """
        whole: Operation[T] = Operation(on_cancel=self.cancel)
        whole._parts, whole._progress = [self], lambda: self.progress
        self.add_done_callback(lambda: hand_in(whole, lambda: _copy_end(self, whole)))
        return whole


def _waiting(operation: Operation[Any]) -> AbstractContextManager[object]:
    waits = WAITS.get()
    return nullcontext() if waits is None else waits(operation)


def _copy_end(source: Operation[T], target: Operation[T]) -> None:
    if source._error is not None:
        target.fail(source._error)
    else:
        target.succeed(source._result)  # type: ignore[arg-type]
