"""Coroutines as work of leaves: each on an event loop of its own in a worker, cancelled with its leaf, held in a pause.

While the run is paused, the loop stands still: what a coroutine awaits may end meanwhile, but the coroutine itself goes
on afterwards, and `asyncio`'s own time leaves the pause out. Code between two `await`s runs to the next one.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine
from typing import Any

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import LEFT, Operation
from grip_bt.base.ports import Context


class _Loop(asyncio.SelectorEventLoop):
    """An event loop whose time leaves out how long it was held."""

    held = 0.0

    def time(self) -> float:
        """Return its time [s]."""
        return super().time() - self.held


class HeldCoroutine:
    """One coroutine under way; implements `grip_bt.base.ports.Pausable`.

    Args:
        make: called in the worker, returns the coroutine.
    """

    def __init__(self, make: Callable[[], Coroutine[Any, Any, Any]]):
        self._make = make
        self._lock = threading.Lock()
        self._free = threading.Event()
        self._free.set()
        self._canceled = False
        self._loop: _Loop | None = None
        self._task: asyncio.Task[Any] | None = None

    def run(self) -> Any:
        """Run it to its end; for the worker.

        Raises:
            CanceledError: it was cancelled.
        """
        try:
            with asyncio.Runner(loop_factory=_Loop) as runner:
                return runner.run(self._main())
        except asyncio.CancelledError:
            raise CanceledError("canceled") from None
        finally:
            with self._lock:
                self._loop = None

    def pause(self) -> None:
        """Hold it where it awaits next."""
        with self._lock:
            if self._canceled or not self._free.is_set():
                return
            self._free.clear()
            if self._loop is not None:
                self._loop.call_soon_threadsafe(self._stand)

    def resume(self) -> None:
        """Let it go on."""
        self._free.set()

    def cancel(self) -> None:
        """Cancel it where it awaits; one that is held goes on for that."""
        with self._lock:
            self._canceled = True
            if self._loop is not None and self._task is not None:
                self._loop.call_soon_threadsafe(self._task.cancel)
        self._free.set()

    async def _main(self) -> Any:
        with self._lock:
            loop = asyncio.get_running_loop()
            assert isinstance(loop, _Loop), "the runner has made it"
            self._loop, self._task = loop, asyncio.current_task()
        self._stand()
        if self._canceled:
            raise CanceledError("canceled")
        return await self._make()

    def _stand(self) -> None:
        """Stand still in the loop's own thread until it goes on."""
        loop = self._loop
        if loop is not None and not self._free.is_set():
            began = loop.time()
            self._free.wait()
            loop.held += loop.time() - began


def run_coroutine(context: Context, make: Callable[[], Coroutine[Any, Any, Any]]) -> Operation[Any]:
    """Run a coroutine to its end in a worker.

    Args:
        context: of the run; the coroutine stands still while that is paused.
        make: returns the coroutine.

    Returns:
        What ends with it; cancelling it cancels the coroutine where it awaits, and it ends when what was awaited has.
        Code in workers that was awaited, and goes on although it was cancelled, keeps it busy.
    """

    async def main() -> Any:
        LEFT.set(whole.works_with)
        return await make()

    coroutine = HeldCoroutine(main)
    whole: Operation[Any] = Operation(on_cancel=coroutine.cancel)
    let_go = context.hold_with(coroutine)
    part = context.run_in_worker(coroutine.run)

    def ended() -> None:
        let_go()
        try:
            result = part.result()
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            whole.fail(error)
        else:
            whole.succeed(result)

    part.add_done_callback(ended)
    return whole
