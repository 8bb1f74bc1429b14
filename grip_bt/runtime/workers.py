"""Blocking code in daemon threads. A worker that never returns doesn't keep the process from ending."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from grip_bt.operation import Operation

T = TypeVar("T")


class Workers:
    """A small pool that starts its threads when they are needed.

    Args:
        limit: how many threads there are at most.
    """

    def __init__(self, limit: int = 4):
        self._limit = limit
        self._queue: queue.SimpleQueue[tuple[Operation[Any], Callable[[], Any]]] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._threads = self._free = 0

    def run(self, work: Callable[[], T]) -> Operation[T]:
        """Run `work()` in a worker; an operation that is cancelled before it began isn't begun."""
        operation: Operation[T] = Operation()
        with self._lock:
            if self._free <= 0 and self._threads < self._limit:
                self._threads += 1
                name = f"grip_worker_{self._threads}"
                threading.Thread(target=self._serve, name=name, daemon=True).start()
            else:
                self._free -= 1
        self._queue.put((operation, work))
        return operation

    def _serve(self) -> None:
        while True:
            operation, work = self._queue.get()
            if not operation.done():
                try:
                    operation.succeed(work())
                except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
                    operation.fail(error)
            del operation, work
            with self._lock:
                self._free += 1
