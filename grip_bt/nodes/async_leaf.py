"""A leaf whose activation is one coroutine: `async def run(self)`.

    @grip.leaf("shop/fetch", codes=("time_out",))
    class Fetch(grip.AsyncLeaf):
        \"\"\"Go where something was seen, and look again.\"\"\"

        seen: grip.Input[Pose]
        found: grip.Output[Pose]

        async def run(self):
            arm = self.context.arm("")
            await arm.execute(await arm.plan(self.seen))
            self.tell("settling")
            await self.sleep(0.5)
            return look()

Operations are awaited; when the node is interrupted the coroutine is cancelled, and with it what it awaits. What it
returns is the end of the activation, as of a function: a value, a mapping of outputs, or `grip.End`.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar
from typing import Any

from grip_bt.base.errors import DataError
from grip_bt.base.operation import Operation

from .coroutines import run_coroutine
from .leaf import OperationLeaf, Status
from .results import finish

_GIVEN: ContextVar[Mapping[str, Any] | None] = ContextVar("grip_given", default=None)
"""What the inputs were when the activation began; set within `run`, and in whatever it starts."""


class AsyncLeaf(OperationLeaf):
    """A leaf that is a coroutine. Authors override `run`, and `prepare` where there is something to look up."""

    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)
        self._naps: list[tuple[float, Operation[None]]] = []

    async def run(self) -> Any:
        """Do the work of one activation, and return how it ends.

        An `ExpectedError` is a failure with its code; any other exception is a bug, and ends the run as `error`.
        Inputs are what they were when the activation began.
        """
        raise NotImplementedError(f"{type(self).__name__}.run")

    # --- for authors, within run ---

    def sleep(self, seconds: float) -> Operation[None]:
        """Return what ends after so many seconds of the run's clock, to be awaited: simulated ones, without pauses."""
        due, nap = self.context.clock.now() + seconds, Operation[None]()
        self._naps.append((due, nap))
        self.context.wake_at(due)
        return nap

    def tell(self, message: str) -> None:
        """Say how it goes, for people: shown beside the node, and kept in the journal."""
        if self.operation is not None:
            self.operation.report(message)
        self.context.wake()

    def read(self, port: str) -> Any:
        """Return an input: within `run`, what it was when the activation began."""
        given = _GIVEN.get()
        if given is None:
            return super().read(port)
        if port not in self.manifest.inputs:
            raise DataError(self.path, port, f"isn't an input of {self.manifest.id}")
        return given[port]

    def end(self, outcome: str = "success", /, **outputs: Any) -> Status:
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

    # --- the activation ---

    def start(self) -> Operation[Any]:
        """Read the inputs and start the coroutine."""
        self._naps.clear()
        given = {port: self.read(port) for port in self.manifest.inputs}

        async def main() -> Any:
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

    def waiting(self, operation: Operation[Any]) -> str:
        """Say what the coroutine has told last."""
        return str(operation.progress or "")

    def finish(self, result: Any) -> Status:
        """Hand out what `run` has returned."""
        return finish(
            self, result, labelled=dict(self.manifest.outcomes) != {"success": "success", "failure": "failure"}
        )
