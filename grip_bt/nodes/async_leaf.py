"""Coroutines as work of leaves: each on an event loop of its own in a worker, cancelled with its leaf.

A pause of the run doesn't reach them, as it reaches no other code in workers; what they sleep by the run's clock does.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Mapping
from contextvars import ContextVar

from grip_bt.base.errors import DataError
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import LEFT, Operation
from grip_bt.base.ports import Context
from grip_bt.base.types import Value
from grip_bt.nodes.leaf import Leaf, OperationLeaf, Status
from grip_bt.task.catalog.manifest import Manifest


class _Coroutine:
    """One coroutine under way; `make` returns it, in the worker."""

    def __init__(self, make: Callable[[], Awaitable[Value]]):
        self._make = make
        self._lock = threading.Lock()
        self._canceled = False
        self._under_way: tuple[asyncio.AbstractEventLoop, asyncio.Task[Value]] | None = None

    def run(self) -> Value:
        """Run it to its end, in the worker; CanceledError where it was cancelled."""
        try:
            return asyncio.run(self._main())
        except asyncio.CancelledError:
            raise CanceledError("canceled") from None
        finally:
            with self._lock:
                self._under_way = None

    def cancel(self) -> None:
        """Cancel it where it awaits."""
        with self._lock:
            self._canceled = True
            if self._under_way is not None:
                loop, task = self._under_way
                loop.call_soon_threadsafe(task.cancel)

    async def _main(self) -> Value:
        task = asyncio.current_task()
        assert task is not None, "it runs in one"
        with self._lock:
            self._under_way = asyncio.get_running_loop(), task
            if self._canceled:
                raise CanceledError("canceled")
        return await self._make()


def run_coroutine(context: Context, make: Callable[[], Awaitable[Value]]) -> Operation[Value]:
    """Run a coroutine to its end in a worker of a run.

    Returns:
        What ends with it; cancelling it cancels the coroutine where it awaits, and it ends when what was awaited has.
        Code in workers that was awaited, and goes on although it was cancelled, keeps it busy.
    """

    async def main() -> Value:
        LEFT.set(whole.works_with)
        return await make()

    coroutine = _Coroutine(main)
    whole: Operation[Value] = Operation(on_cancel=coroutine.cancel)
    part = context.run_in_worker(coroutine.run)

    def ended() -> None:
        try:
            result = part.result()
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            whole.fail(error)
        else:
            whole.succeed(result)

    part.add_done_callback(ended)
    return whole


class End:
    """How a function ends that has outcomes of its own: `return End("heavy", weight=3.2)`.

    A failure may have a code, for `on: {failure.<code>: ...}`, and a message for people.
    """

    def __init__(self, outcome: str, /, *, code: str = "", message: str = "", **outputs: object):
        self.outcome, self.code, self.message, self.outputs = outcome, code, message, outputs


def finish(leaf: Leaf, result: object, labelled: bool) -> Status:
    """End an activation with what its code has returned: an `End`; else the one output, or a mapping of several.

    One that is `labelled` has outcomes of its own, so that it has to be an `End`.

    Raises:
        TypeError: it doesn't fit; it says what would.
    """
    face, names = leaf.manifest.id, list(leaf.manifest.outputs)
    if isinstance(result, End):
        if result.code:
            return leaf.fail(result.code, result.message, outcome=result.outcome, outputs=result.outputs)
        return leaf.end(result.outcome, **result.outputs)
    if labelled:
        raise TypeError(f"{face} has outcomes of its own: return End('outcome', ...), not {result!r}")
    if not names:
        return leaf.end()
    if len(names) == 1:
        return leaf.end(**{names[0]: result})
    if not isinstance(result, Mapping) or set(result) != set(names):
        raise TypeError(f"{face} has several outputs: return a mapping with the keys {names}")
    return leaf.end(**result)


_GIVEN: ContextVar[Mapping[str, Value] | None] = ContextVar("grip_given", default=None)
"""What the inputs were when the activation began; set within `run`, and in whatever it starts."""


class AsyncLeaf(OperationLeaf):
    """A leaf that is a coroutine. Authors override `run`, and `prepare` where there is something to look up."""

    def __init__(
        self, name: str, path: str, manifest: Manifest, params: Mapping[str, Value], meaning: Mapping[str, str]
    ):
        super().__init__(name, path, manifest, params, meaning)
        self._naps: list[tuple[float, Operation[None]]] = []
        self._told = ""

    async def run(self) -> Value:
        """Do the work of one activation, and return how it ends.

        An `ExpectedError` is a failure with its code; any other exception is a bug, and ends the run as `error`.
        Inputs are what they were when the activation began.
        """
        raise NotImplementedError(f"{type(self).__name__}.run")

    # --- for authors, within run ---

    def sleep(self, seconds: float) -> Operation[None]:
        """Return what ends after some seconds of the run's clock, to be awaited: simulated ones, without pauses."""
        due, nap = self.context.clock.now() + seconds, Operation[None]()
        self._naps.append((due, nap))
        self.context.wake_at(due)
        return nap

    def tell(self, message: str) -> None:
        """Say how it goes, for people: shown beside the node, and kept in the journal."""
        self._told = message
        self.context.wake()

    def read(self, port: str) -> Value:
        """Return an input: within `run`, what it was when the activation began."""
        given = _GIVEN.get()
        if given is None:
            return super().read(port)
        if port not in self.manifest.inputs:
            raise DataError(self.path, port, f"isn't an input of {self.manifest.id}")
        return given[port]

    def end(self, outcome: str = "success", /, **outputs: object) -> Status:
        """End the activation; not within `run`, which returns its end.

        Raises:
            TypeError: it was called within `run`, where nothing may be written: the node may be interrupted.
        """
        if _GIVEN.get() is not None:
            raise TypeError(
                f"{self.path}: within run(), return grip.End({outcome!r}, port=value), or End('failure', code=...);"
                " self.end and self.fail are for update()"
            )
        return super().end(outcome, **outputs)

    def start(self) -> Operation[Value]:
        self._naps.clear()
        self._told = ""
        given = {port: self.read(port) for port in self.manifest.inputs}

        async def main() -> Value:
            _GIVEN.set(given)
            return await self.run()

        return run_coroutine(self.context, main)

    def update(self) -> Status:
        """Wake what sleeps in the coroutine and whose time has come; then as every operation."""
        if self._naps:
            now = self.context.clock.now()
            for nap in [nap for nap in self._naps if nap[0] <= now or nap[1].done()]:
                self._naps.remove(nap)
                nap[1].succeed(None)
        return super().update()

    def waiting(self, operation: Operation[Value]) -> str:
        return self._told

    def finish(self, result: Value) -> Status:
        return finish(
            self, result, labelled=dict(self.manifest.outcomes) != {"success": "success", "failure": "failure"}
        )
