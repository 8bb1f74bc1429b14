"""The base of every leaf: a py_trees behaviour that ends with a named outcome and may say why it failed.

Authors override up to four verbs: `prepare`, `initialise`, `update`, which never blocks, and `terminate`. A leaf that
waits calls `self.context.wake()` from any thread when there is something to look at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status as Status

from grip_bt.base.errors import DataError, NodeError, NotStoppedError
from grip_bt.base.failures import CanceledError, ExpectedError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Context
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.types import Value
from grip_bt.base.values import Failure
from grip_bt.task.catalog.manifest import Manifest

from .node import STATUS, AskedContext, Asker, Node

STOPPING = 60.0
"""How long a leaf waits at most for what was told to stop, before it begins something that moves [s]. Actions and
controllers have shorter limits of their own; this is for calls that can't be stopped, and code that doesn't return."""


class Leaf(Node):
    """A node of the catalogue in a tree.

    Attributes:
        params: the literals of `with:`, defaults filled in.
        outcome: the label of the last end, None while running or after an interruption.
        failure: why it failed, None otherwise.
        context: what the run offers; set before `prepare`.
        inputs_read: port -> value, what this activation has read.
        waits: whether `still_to_stop` tells of anything; as `Manifest.may_move` where it is None.
        watched: input ports whose variables' writes are counted in `writes`.
    """

    context: Context
    waits: ClassVar[bool | None] = None
    watched: ClassVar[tuple[str, ...]] = ()
    _since: float | None = None
    _left: Operation[Value] | None = None

    def __init__(
        self, name: str, path: str, manifest: Manifest, params: Mapping[str, Value], meaning: Mapping[str, str]
    ):
        super().__init__(name)
        self.path, self.manifest, self.params = path, manifest, dict(params)
        self.meaning = {**manifest.outcomes, **meaning} if meaning else manifest.outcomes
        self.inputs_read: dict[str, Value] = {}
        self.writes = dict.fromkeys(self.watched, 0)
        self.askers: list[Asker] = []
        self.readers: dict[str, Callable[[], Any]] = {}
        self.writers: dict[str, Callable[[Any], None]] = {}

    # --- for authors ---

    def prepare(self) -> None:
        """Connect and verify, once, before the first tick. `self.context` is there."""

    def read(self, port: str) -> Value:
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

    def note_write(self, port: str) -> None:
        self.writes[port] += 1

    def running(self, message: str = "") -> Status:
        """Say that the work goes on; `message` is shown to people."""
        if message and message != self.feedback_message:
            self.observer.message(self.path, message)
        self.feedback_message = message
        return Status.RUNNING

    def end(self, outcome: str = "success", /, **outputs: object) -> Status:
        """End with an outcome and write the outputs.

        Raises:
            DataError: an output isn't declared.
            ValueError: the outcome isn't declared.
        """
        meaning = self.meaning.get(outcome)
        if meaning is None:
            raise ValueError(f"{self.path}: {outcome!r} isn't an outcome of {self.manifest.id}: {list(self.meaning)}")
        for port in outputs:
            if port not in self.manifest.outputs:
                raise DataError(self.path, port, f"isn't an output of {self.manifest.id}")
        for port, value in outputs.items():
            if port in self.writers:
                self.writers[port](value)
        self.outcome = outcome
        return STATUS[meaning]

    def fail(
        self,
        code: str,
        message: str = "",
        /,
        *,
        outcome: str | None = None,
        outputs: Mapping[str, object] | None = None,
        **data: object,
    ) -> Status:
        """End with a failure outcome and a reason; `data` goes into the failure, `outputs` to the ports.

        Without an `outcome`, it is `failure`, or the first that means it.

        Raises:
            ValueError: no outcome of this node means failure; it tells the reason.
        """
        self.failure = Failure(code, message, data)
        self.feedback_message = str(self.failure)
        return self.end(outcome or self._failing(), **(outputs or {}))

    def _failing(self) -> str:
        meant = [outcome for outcome, meaning in self.meaning.items() if meaning == "failure"]
        if not meant:
            raise ValueError(f"it failed ({self.failure}), but no outcome of {self.manifest.id} means failure")
        return "failure" if "failure" in meant else meant[0]

    def still_to_stop(self) -> Sequence[str]:
        """Return what was told to stop and hasn't, where this may move something and has to wait for that.

        Raises:
            NotStoppedError: that takes longer than `STOPPING`, or nobody could say that it has stopped.
        """
        waits = self.manifest.may_move if self.waits is None else self.waits
        paths = self.context.unfinished() if waits else ()
        if not paths:
            return ()
        now = self.context.clock.now()
        if self._since is None:
            self._since = now
            self.context.wake_at(now + STOPPING)
        if now >= self._since + STOPPING:
            raise NotStoppedError(paths, f"hasn't stopped for {STOPPING:g} s")
        return paths

    # --- for runs that are gone on with ---

    def resume(self, began: float) -> None:
        """Go on with an activation of a process that died; in place of `initialise`, with the policy `resume`.

        Args:
            began: when it began, on the run's clock [s], which goes on where it stood.
        """
        self.initialise()

    def replay_begun(self) -> None:
        """Take note that an activation of that process begins; requests to end are those that there were then.

        One that hadn't ended goes on, or begins again, afterwards.
        """

    def replay_ended(self, outcome: str | None) -> None:
        """Take note of an activation of that process, which isn't repeated; requests to end are those of its end.

        Args:
            outcome: how it ended; None after an interruption.
        """

    @property
    def zombie(self) -> bool:
        """Whether work of an interrupted activation is still under way although it was asked to stop."""
        return self._left is not None and self._left.lingers

    @property
    def unended(self) -> bool:
        return self._left is not None and not self._left.done()

    @property
    def given_up(self) -> str:
        """Why nobody can say whether an interrupted operation has ended; empty where that isn't so."""
        return "" if self._left is None else self._left.given_up

    # --- py_trees' side ---

    def setup(self, *, context: Context, **_: object) -> None:
        self.context = AskedContext(context, lambda: self._asked_by(context)) if self.askers else context
        self.prepare()

    def _asked_by(self, context: Context) -> bool:
        return context.preempt_requested or any(asker.asked for asker in self.askers)

    def tick(self) -> Iterator[Behaviour]:
        """Tick once, in an activation that begins with this tick or has begun before.

        Raises:
            NodeError: the leaf raised; it was terminated.
        """
        try:
            if self.status != Status.RUNNING:
                self.inputs_read = {}
                self.begin()
            yield from super().tick()
            if self.status == Status.INVALID:
                raise TypeError("update() has to return SUCCESS, FAILURE or RUNNING")
        except Exception as error:
            self._abandon(error)
            raise NodeError(self.path, error) from error

    def conclude(self, status: Status) -> None:
        if self.outcome is None:
            self.outcome = "success" if status is Status.SUCCESS else "failure"
        if STATUS.get(self.meaning.get(self.outcome, "")) != status:
            raise ValueError(
                f"update() returned {status.name}, but {self.manifest.id} ends with {dict(self.meaning)};"
                " return self.end(outcome)"
            )

    def _abandon(self, error: Exception) -> None:
        try:
            self.stop(Status.INVALID)
        except Exception as second:  # noqa: BLE001 - the first error is the one to report
            self.status = Status.INVALID
            error.add_note(f"and terminate() raised {type(second).__name__}: {second}")


class OperationLeaf(Leaf):
    """A leaf that starts one operation and waits for it without polling.

    Authors override `start` and, where the result is more than success, `finish`. A preempt request that arrives
    while the operation is under way cancels it; when it has really ended, the leaf fails with the code `preempted`,
    or ends with the result that was quicker. A leaf that begins after the request is part of the recovery and runs as
    usual.

    What may move something (`Manifest.may_move`) begins only when everything that was told to stop has stopped: until
    then the leaf runs without having started, at most `STOPPING`, which ends the run with NotStoppedError.
    """

    operation: Operation[Value] | None = None
    _preempted_before: bool = False

    def start(self) -> Operation[Value] | Steps[Value]:
        """Begin the work of this activation: an operation, or a generator of operations, one after the other."""
        raise NotImplementedError(f"{type(self).__name__}.start")

    def finish(self, result: Value) -> Status:
        """Turn the operation's result into an outcome: by default success, with it as the one output, if any."""
        outputs = list(self.manifest.outputs)
        return self.end(**({outputs[0]: result} if len(outputs) == 1 else {}))

    def waiting(self, operation: Operation[Value]) -> str:
        """Say how far the work is, for people; called at each tick while it is under way."""
        return ""

    def outputs_of_failure(self) -> dict[str, Value]:
        return {}

    def update(self) -> Status:
        """Start, wait, finish; an `ExpectedError` becomes a failure with its code."""
        try:
            if self.operation is None:
                held_back = self._held_back()
                if held_back is not None:
                    return held_back
                begun = self.start()
                self.operation = begun if isinstance(begun, Operation) else run_steps(begun)
                self.operation.add_done_callback(self.context.wake)
            if not self.operation.done():
                return self._wait(self.operation)
            return self.finish(self.operation.result())
        except CanceledError as error:
            code = "preempted" if self._preempted_now() else error.code
            return self._fail_for(code, error)
        except ExpectedError as error:
            return self._fail_for(error.code, error)

    def terminate(self, new_status: Status) -> None:
        operation, self.operation, self._since = self.operation, None, None
        if operation is not None and not operation.done():
            operation.cancel()
            self._note_left(operation)

    def _note_left(self, operation: Operation[Value]) -> None:
        self._left = operation
        if self.manifest.may_move:
            self.context.left(self.path, operation)

    def _held_back(self) -> Status | None:
        """Return how the leaf stands while something else has still to stop; None when it may begin."""
        if self._since is None:
            self._preempted_before = self.context.preempt_requested
        paths = self.still_to_stop()
        if not paths:
            return None
        if self._preempted_now():
            return self._fail_for("preempted", CanceledError("asked to end before it began"))
        return self.running(f"waits for {', '.join(paths)} to stop")

    def _preempted_now(self) -> bool:
        return self.context.preempt_requested and not self._preempted_before

    def _wait(self, operation: Operation[Value]) -> Status:
        if not self._preempted_now():
            return self.running(self.waiting(operation))
        operation.cancel()
        return self.running("stopping, since the task was asked to end")

    def _fail_for(self, code: str, error: ExpectedError) -> Status:
        if self.operation is not None and self.operation.given_up:
            self._note_left(self.operation)
        self.failure = Failure(code, error.message, dict(error.data))
        self.feedback_message = str(self.failure)
        return self.end(self._failing(), **self.outputs_of_failure())
