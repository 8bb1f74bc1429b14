"""Running a compiled task, tree or machine, to its end."""

from __future__ import annotations

import logging
import threading
import traceback
from dataclasses import dataclass
from typing import Literal

from py_trees.common import Status

from grip_bt.compilers import CompiledMachine, CompiledTree, Halted, TaskEnd
from grip_bt.nodes.observer import Observer, Observers
from grip_bt.ports import Clock
from grip_bt.values import Failure

from .context import RunContext
from .journal import Journal
from .pacing import Pacing
from .plan import Plan
from .recorder import Recorder

_log = logging.getLogger(__name__)

ACKNOWLEDGE = 0.05
"""How long [s] a run may take to acknowledge a stop before its leaves are terminated from another thread."""

RunStatus = Literal["success", "failure", "error", "stopped"]


@dataclass(frozen=True)
class RunResult:
    """How a run has ended.

    Attributes:
        outcome: the task's outcome; None after a stop or an error.
        meaning: `success` or `failure`; None after a stop or an error.
        status: the meaning, or `error`, or `stopped`.
        failure: the reason of a failure.
        ticks: how often the task was ticked.
        duration: on the run's clock [s].
        error: what a leaf raised, in a NodeError that names it; the journal has the traceback.
    """

    outcome: str | None
    meaning: str | None
    status: RunStatus
    failure: Failure | None
    ticks: int
    duration: float
    error: Exception | None = None


class Runner:
    """Runs one compiled task once. `run` blocks; everything else may be called from any thread, before and during it.

    Attributes:
        run_id: the run's id in the journal; None without one.

    Args:
        compiled: what `to_tree` or `to_machine` made.
        context: what leaves are offered; its clock is the run's clock.
        clock: the run's clock; it is the context's.
        journal: where to write what happens.
        task_path: the task's file, for the journal.
        task_text: the document, for the journal.
        seed: of the simulation, for the journal.
        poll: how often leaves that wake nobody are looked at [s]; None for never.
    """

    def __init__(
        self,
        compiled: CompiledTree | CompiledMachine,
        context: RunContext,
        clock: Clock | None = None,
        journal: Journal | None = None,
        *,
        task_path: str = "",
        task_text: str = "",
        seed: int | None = None,
        poll: float | None = 0.05,
    ):
        if clock is not None and clock is not context.clock:
            raise ValueError("a run has one clock: make the context with it, RunContext(clock, ...)")
        self.compiled, self.context, self.journal = compiled, context, journal
        self.pacing = Pacing(context.waker, poll)
        self.run_id: str | None = None
        self._recorder: Recorder | None = None
        if journal is not None:
            log = journal.begin(compiled.task.name, task_path, task_text, compiled.target, seed)
            self.run_id, self._recorder = log.id, Recorder(log, context.clock)
        self._observers: list[Observer] = [] if self._recorder is None else [self._recorder]
        self._begun, self._ended = threading.Lock(), threading.Event()
        if self._recorder is not None:
            self.pacing.on_state(self._recorder.state)

    def observe(self, observer: Observer) -> None:
        """Have `observer` told of what the nodes do, after the journal; before `run`."""
        self._observers.append(observer)

    def pause(self) -> None:
        """Tick no more until `resume` or `step`."""
        self.pacing.pause()

    def resume(self) -> None:
        """Go on."""
        self.pacing.resume()

    def step(self) -> None:
        """Pause, and let one tick through."""
        self.pacing.step()

    def stop(self) -> None:
        """Halt: every running leaf is terminated at once, and the run ends as `stopped`.

        Where a leaf's `update` hangs, so that the run can't look, all active leaves are terminated from here after
        `ACKNOWLEDGE`; the run ends when that `update` returns. May be called from a signal handler.
        """
        self.pacing.stop()
        threading.Thread(target=self._insist, name="grip_stop", daemon=True).start()

    def _insist(self) -> None:
        if self._ended.wait(ACKNOWLEDGE):
            return
        for path, leaf in self.compiled.leaves.items():
            if leaf.active:
                try:
                    leaf.terminate(Status.INVALID)
                except Exception:  # noqa: BLE001 - the other leaves must be terminated all the same
                    _log.exception("terminate of %s", path)
                if self._recorder is not None:
                    self._recorder.message(path, "terminated from outside: the run doesn't acknowledge the stop")

    def request_preempt(self) -> None:
        """Ask the task to come to an end on its own terms; leaves that care end soon, and recovery still runs."""
        if isinstance(self.compiled, CompiledMachine):
            self.compiled.request_preempt()
        self.context.request_preempt()

    def run(self) -> RunResult:
        """Prepare every leaf, then run to the end. Returns in every case; nothing is left running.

        Raises:
            RuntimeError: it was run before.
        """
        if not self._begun.acquire(blocking=False):
            raise RuntimeError("a runner runs once; compile the task again for another run")
        if self._observers:
            self.compiled.observe(Observers(*self._observers) if len(self._observers) > 1 else self._observers[0])
        if self._recorder is not None:
            self._recorder.started()
        start = self.context.clock.now()
        try:
            result = self._attempt(start)
        finally:
            self._ended.set()
        if self._recorder is not None:
            self._recorder.finished(result.outcome, result.status)
        return result

    def _attempt(self, start: float) -> RunResult:
        try:
            self.compiled.prepare(self.context)
            end = self._execute()
        except Halted:
            return self._result(None, "stopped", start)
        except KeyboardInterrupt:
            self.stop()
            return self._result(None, "stopped", start)
        except Exception as error:  # noqa: BLE001 - a bug of a leaf is the run's result, not the runner's end
            if self._recorder is not None:
                self._recorder.error(error, "".join(traceback.format_exception(error)))
            return self._result(None, "error", start, error)
        finally:
            self.compiled.release()
        return self._result(end, "success" if end.meaning == "success" else "failure", start)

    def _execute(self) -> TaskEnd:
        if isinstance(self.compiled, CompiledTree):
            return self.compiled.execute(self.pacing, Plan(self.compiled.root).tick)
        return self.compiled.execute(self.pacing)

    def _result(
        self, end: TaskEnd | None, status: RunStatus, start: float, error: Exception | None = None
    ) -> RunResult:
        return RunResult(
            outcome=end.outcome if end else None,
            meaning=end.meaning if end else None,
            status=status,
            failure=end.failure if end else None,
            ticks=self.pacing.ticks,
            duration=self.context.clock.now() - start,
            error=error,
        )
