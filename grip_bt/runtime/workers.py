"""Blocking code in daemon threads. A worker that never returns keeps neither the process nor other work waiting."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from grip_bt.base.operation import Operation

T = TypeVar("T")


class Workers:
    """A small pool that starts its threads, at most `limit`, when they are needed.

    Code can't be interrupted: when its operation is cancelled, the operation ends at once and stays `busy` until the
    code returns. Its thread doesn't count any more and ends then, so that what hangs takes no place in the pool.
    """

    def __init__(self, limit: int = 4):
        self._limit = limit
        self._queue: queue.SimpleQueue[tuple[Operation[Any], Callable[[], Any]]] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._threads = self._waiting = 0

    def run(self, work: Callable[[], T]) -> Operation[T]:
        """Run `work()` in a worker; an operation that is cancelled before it began isn't begun."""
        operation: Operation[T] = Operation()
        with self._lock:
            self._queue.put((operation, work))
            self._waiting += 1
            self._staff()
        return operation

    def _staff(self) -> None:
        """Start a thread when there is more work than free threads; with the lock held."""
        if self._waiting > 0 and self._threads < self._limit:
            self._threads += 1
            threading.Thread(target=self._serve, name="grip_worker", daemon=True).start()

    def _serve(self) -> None:
        while True:
            with self._lock:
                if self._waiting == 0:
                    self._threads -= 1
                    return
                operation, work = self._queue.get_nowait()
                self._waiting -= 1
                operation.busy = not operation.done()
            if operation.busy and not self._do(operation, work):
                return

    def _do(self, operation: Operation[Any], work: Callable[[], object]) -> bool:
        """Do one piece of work; return whether this thread still belongs to the pool."""
        left_alone = threading.Event()
        working = threading.Lock()
        over = False

        def ended_early() -> None:
            with working:
                if over:
                    return
                left_alone.set()
            with self._lock:
                self._threads -= 1
                self._staff()

        operation.add_done_callback(ended_early)
        result, error = None, None
        try:
            result = work()
        except BaseException as raised:  # noqa: BLE001 - handed to the owner, who raises it
            error = raised
        with working:
            over = True
        operation.busy = False
        if error is not None:
            operation.fail(error)
        else:
            operation.succeed(result)
        return not left_alone.is_set()
