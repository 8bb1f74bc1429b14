"""The base of every leaf: a py_trees behaviour that ends with a named outcome and may say why it failed.

Authors override up to four verbs, in py_trees' own life cycle:

* `prepare` - once per run, before the first tick: connect, verify. (`setup` of py_trees calls it.)
* `initialise` - each activation.
* `update` - never blocks; returns `self.running()`, `self.end(outcome, port=value)` or `self.fail(code, message)`.
* `terminate` - cancel what is under way; py_trees calls it at the end of each activation and when it is interrupted.

A leaf that waits calls `self.context.wake()` from any thread when there is something to look at.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, TypeVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.catalog.manifest import Manifest
from grip_bt.errors import DataError, ExpectedError
from grip_bt.operation import Operation
from grip_bt.ports import Context
from grip_bt.values import Failure

T = TypeVar("T")
_STATUS = {"success": Status.SUCCESS, "failure": Status.FAILURE}


class Leaf(Behaviour):
    """A node of the catalogue in a tree.

    Attributes:
        path: the node's path in the task.
        manifest: its face.
        params: the literals of `with:`, defaults filled in.
        outcome: the label of the last end, None while running or after an interruption.
        failure: why it failed, None otherwise.
        context: what the run offers; set before `prepare`.
        inputs_read: port -> value, what this activation has read.
    """

    context: Context
    resumable: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        path: str,
        manifest: Manifest,
        params: Mapping[str, Any],
        meaning: Mapping[str, str],
    ):
        super().__init__(name=name)
        self.path, self.manifest, self.params = path, manifest, dict(params)
        self.meaning = {**manifest.outcomes, **meaning}
        self.outcome: str | None = None
        self.failure: Failure | None = None
        self.inputs_read: dict[str, Any] = {}
        self.readers: dict[str, Callable[[], Any]] = {}
        self.writers: dict[str, Callable[[Any], None]] = {}

    # --- for authors ---

    def prepare(self) -> None:
        """Connect and verify, once, before the first tick. `self.context` is there."""

    def read(self, port: str) -> Any:
        """Return the value of the variable bound to an input port; None for an optional port that isn't bound.

        Raises:
            DataError: the port isn't declared, or its variable hasn't been written.
        """
        if port not in self.manifest.inputs:
            raise DataError(self.path, port, f"isn't an input of {self.manifest.id}")
        reader = self.readers.get(port)
        value = None if reader is None else reader()
        self.inputs_read[port] = value
        return value

    def running(self, message: str = "") -> Status:
        """Say that the work goes on; `message` is shown to people."""
        self.feedback_message = message
        return Status.RUNNING

    def end(self, outcome: str = "success", /, **outputs: Any) -> Status:
        """End with an outcome and write the outputs.

        Raises:
            DataError: an output isn't declared.
            ValueError: the outcome isn't declared.
        """
        if outcome not in self.meaning:
            raise ValueError(f"{self.path}: {outcome!r} isn't an outcome of {self.manifest.id}: {list(self.meaning)}")
        for port in outputs:
            if port not in self.manifest.outputs:
                raise DataError(self.path, port, f"isn't an output of {self.manifest.id}")
        for port, value in outputs.items():
            if port in self.writers:
                self.writers[port](value)
        self.outcome = outcome
        return _STATUS[self.meaning[outcome]]

    def fail(self, code: str, message: str = "", *, outcome: str = "failure", **data: Any) -> Status:
        """End with a failure outcome and a reason."""
        self.failure = Failure(code, message, data)
        self.feedback_message = str(self.failure)
        return self.end(outcome)

    # --- py_trees' side ---

    def setup(self, **kwargs: Any) -> None:
        """Take the run's context and prepare."""
        self.context = kwargs["context"]
        self.prepare()

    def tick(self) -> Any:
        """Tick once; a new activation forgets the last one's outcome first."""
        if self.status != Status.RUNNING:
            self.outcome, self.failure, self.inputs_read = None, None, {}
        return super().tick()

    def stop(self, new_status: Status) -> None:
        """End an activation; an interrupted one has no outcome."""
        if new_status == Status.INVALID:
            self.outcome, self.failure = None, None
        super().stop(new_status)


class OperationLeaf(Leaf):
    """A leaf that starts one operation and waits for it without polling.

    Authors override `start` and, where the result is more than success, `finish`.
    """

    operation: Operation[Any] | None = None

    def start(self) -> Operation[Any]:
        """Begin the work of this activation."""
        raise NotImplementedError(f"{type(self).__name__}.start")

    def finish(self, result: Any) -> Status:
        """Turn the operation's result into an outcome."""
        return self.end()

    def update(self) -> Status:
        """Start, wait, finish; an `ExpectedError` becomes a failure with its code."""
        try:
            if self.operation is None:
                self.operation = self.start()
                self.operation.add_done_callback(self.context.wake)
            if not self.operation.done():
                return self.running()
            return self.finish(self.operation.result())
        except ExpectedError as error:
            return self.fail(error.code, error.message, **error.data)

    def terminate(self, new_status: Status) -> None:
        """Cancel what is under way."""
        operation, self.operation = self.operation, None
        if operation is not None and not operation.done():
            operation.cancel()
