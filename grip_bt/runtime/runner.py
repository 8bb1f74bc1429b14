"""Running a compiled task, tree or machine, to its end."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from py_trees.behaviour import Behaviour

from grip_bt.base.errors import GripError, NodeError, NotStoppedError
from grip_bt.compilers import CompiledMachine, CompiledTree, Halted, Pacer, TaskEnd
from grip_bt.compilers.scopes import Scopes
from grip_bt.nodes.foreign import Foreign
from grip_bt.nodes.leaf import STOPPING
from grip_bt.nodes.node import SILENT, Observer, Observers
from grip_bt.runtime.motion_end import Rest, ended
from grip_bt.runtime.observers import Recorder, SideState, SideStateObserver, WakeOnWrite

from .context import RunContext
from .debugger import Debugger
from .engine import TickEngine, make_ticker
from .journal import Journal, RunLog
from .lockstep import Lockstep
from .pacing import Pacing, State
from .re_execution import ReExecution
from .recording import PREEMPT, NewEvents
from .result import RunResult, RunStatus, own_labels
from .stopping import (
    EndedObserver,
    Zombie,
    code_running,
    in_background,
    join_all,
    left_working,
    lock_out,
    still_moving,
    terminate_outside,
)
from .tick_watchdog import Watchdog

INSIST = 0.03
"""How long [s] after a stop the run may take to end by itself before leaves are terminated from another thread."""
ABANDON = 0.08
"""How long [s] after a stop what hangs is left behind; the robot holds, all of it, within 0.1 s."""
LAST_MOMENT = 0.05
"""How long [s] code that works for cancelled operations may take to return when a run was stopped, before it is called
a zombie."""
REST = 5.0
"""How long [s] after a stop the robot may take to come to rest, as measured, until the run says that it can't tell."""


def _engine_of(root: Behaviour) -> TickEngine:
    # Our nodes keep their methods; somebody's own behaviours may do what they like.
    return TickEngine(root, fixed=not any(isinstance(node, Foreign) for node in root.iterate()))


def _nothing_to_disturb(fault: str) -> None:
    raise GripError("faults happen in simulated worlds, which this run doesn't have")


class Runner:
    """Runs one compiled task once. `run` blocks; everything else may be called from any thread, before and during it.

    The task is ticked in a thread of its own, so that code that hangs in a leaf keeps nobody waiting: `run` returns
    when the task has ended or, after a stop, when everything was terminated that can be.

    Args:
        journal: where to write what happens, with the task's path and text, the seed, and `facts` about how it is run.
        poll: how often leaves that wake nobody are looked at [s]; None for never.
        rate: ticks a second of the run's clock, instead of on wakes; None for on wakes.
        watchdog: how long one tick may take [s] before the run ends as an error; None for ever.
        log: goes on with this run of the journal; None for a new one.
        re_execution: what happened before, which happens again first; its clock is the context's.

    Attributes:
        inject: has something go wrong, `NAME: {fault: KIND}` as in a world's file; raises GripError.
    """

    def __init__(
        self,
        compiled: CompiledTree | CompiledMachine,
        context: RunContext,
        journal: Journal | None = None,
        *,
        task_path: str = "",
        task_text: str = "",
        seed: int | None = None,
        poll: float | None = 0.05,
        rate: float | None = None,
        watchdog: float | None = None,
        log: RunLog | None = None,
        re_execution: ReExecution | None = None,
        facts: Mapping[str, object] | None = None,
    ):
        self.compiled, self.context, self.journal = compiled, context, journal
        self.pacing = Pacing(context.waker, poll, rate)
        self.debugger = Debugger(compiled, self.pacing, self._observe_debugger)
        self.run_id: str | None = None
        self.inject: Callable[[str], None] = _nothing_to_disturb
        self._recorder: Recorder | None = None
        self._re_execution, self._facts = re_execution, {**(facts or {}), **own_labels(compiled)}
        if journal is not None:
            if log is None:
                log = journal.begin(compiled.task.name, task_path, task_text, compiled.target, seed)
            self.run_id, self._recorder = log.id, Recorder(log, context.clock)
        self._observers: list[Observer] = [] if self._recorder is None else [self._recorder]
        self._debugged = self._stale = False
        self._watchdog = Watchdog(self.pacing, compiled.leaves, watchdog, self._hung) if watchdog else None
        self._lost = False
        self._begun = threading.Lock()
        self._ending = threading.Lock()  # held by who ends the run: its own thread, or who leaves that behind
        self._returned, self._ended = threading.Event(), threading.Event()
        self._thread: int | None = None
        self._start = 0.0
        self._result: RunResult | None = None
        self.pacing.on_state(lambda state: self._say("state", state=state))
        self._lockstep = context.lockstep if re_execution is None else None
        self.pacing.on_state(self._hold_parts)

    def observe(self, observer: Observer) -> None:
        self._observers.append(observer)

    def keep(self, parts: Mapping[str, SideState], leaves: Mapping[str, tuple[str, ...]]) -> None:
        """Have the journal keep the states of parts beside the task; before `run`.

        Args:
            leaves: leaf -> names of the parts that its work may change.
        """
        if self._recorder is not None and parts:
            self._observers.insert(0, SideStateObserver(self._recorder.kept, parts, leaves))

    def pause(self) -> None:
        """Tick no more until `resume` or `step`; the run's clock stands still, and motions are held, where they can."""
        self.debugger.forget_step()
        self.pacing.pause()

    def resume(self) -> None:
        self.debugger.forget_step()
        self.pacing.resume()

    def step(self, how: str = "tick") -> None:
        self.debugger.step(how)

    def stop(self) -> None:
        """Halt: every running leaf is terminated at once, the robot holds, and the run ends as `stopped`.

        Where a leaf hangs, so that the run can't look, all active leaves are terminated from here after `INSIST`; after
        `ABANDON`, what still hangs is left behind as a zombie. The run has ended when the robot was measured to be at
        rest, at most `REST` later: `RunResult.rest` tells. May be called from a signal handler.
        """
        called = time.monotonic()
        self.pacing.stop()
        in_background("stop", lambda: self._insist(called))

    def lose(self, why: str) -> None:
        """Stop, since whoever controls the run has gone without a stop; the run can be resumed.

        The journal ends here, as if the process had died; what is interrupted from now on isn't in it.
        """
        self._lost = True
        if self._recorder is not None:
            self._recorder.lost(why)
        self.stop()

    def request_preempt(self) -> None:
        """Ask the task to come to an end on its own terms; leaves that care end soon, and recovery still runs."""
        self._say(PREEMPT)
        self._ask()

    def _ask(self) -> None:
        self.context.request_preempt()
        if isinstance(self.compiled, CompiledMachine):
            self.compiled.request_preempt()
            self.context.wake()

    def _hold_parts(self, state: State) -> None:
        if state == "paused":
            self.context.pause()
        elif state == "stopping":
            if self._lockstep is not None:
                self._lockstep.end()
            self.context.release()
        else:
            self.context.resume()

    def run(self) -> RunResult:
        """Prepare every leaf, then run to the end. Returns in every case; nothing is left running but zombies.

        Raises:
            RuntimeError: it was run before.
        """
        if not self._begun.acquire(blocking=False):
            raise RuntimeError("a runner runs once; compile the task again for another run")
        if self._lockstep is not None:
            self._lockstep.enter()
            self._observers.append(WakeOnWrite(self.context))
        self._install()
        if self._recorder is not None:
            if self._re_execution is None:
                self._recorder.say("run_started", **self._facts)
            else:
                self._recorder.resumed(self._re_execution.recording.end_time, self._facts)
                self._re_execution.tell = lambda path, how: self._say("went_on", path, how=how)
        if self._re_execution is not None:
            self._re_execution.ask, self._re_execution.pacing = self._ask, self.pacing
        self._start = self.context.clock.now()
        threading.Thread(target=self._work, name="grip_run", daemon=True).start()
        while not self._ended.is_set():
            try:
                self._ended.wait()
            except KeyboardInterrupt:
                self.stop()
        assert self._result is not None, "a run that has ended has a result"
        return self._result

    def tell(self, part: str, text: str) -> None:
        """Have the journal say what a part of the robot tells while the task runs; from any thread."""
        if self._thread is not None and not self._returned.is_set():
            self._say("message", part=part, text=f"{part}: {text}")

    def _say(self, event: str, path: str = "/", /, **data: object) -> None:
        if self._recorder is not None:
            self._recorder.say(event, path, **data)

    def dismiss(self) -> None:
        """Have the journal say of a new run that wasn't begun, and won't be, that it was stopped."""
        if self._begun.acquire(blocking=False) and self._recorder is not None and self._re_execution is None:
            self._recorder.finished(None, "stopped")

    def _work(self) -> None:
        self._thread = threading.get_ident()
        if self._watchdog is not None:
            self._watchdog.start()
        result = self._attempt()
        self._returned.set()
        if self._ending.acquire(blocking=False):
            self._finish(result)

    def _attempt(self) -> RunResult:
        try:
            self.compiled.prepare(self.context)
            if self._re_execution is not None:
                self._re_execution.install(self.context.wake)
            if self._lockstep is not None:
                self._take_turns(self._lockstep)
            end = self._execute()
            self._let_stop()
        except Halted:
            return self._made(None, "stopped")
        except BaseException as error:  # noqa: BLE001 - a bug of a leaf is the run's result, not the runner's end
            if self._recorder is not None and not self._ending.locked():
                self._recorder.error(error, "".join(traceback.format_exception(error)))
            return self._made(None, "error", error)
        finally:
            if self._lockstep is not None:
                self._lockstep.end()
            self.compiled.release()
        return self._made(end, "success" if end.meaning == "success" else "failure")

    def _take_turns(self, lockstep: Lockstep) -> None:
        """Take turns with the simulated world; a leaf is polled where it isn't known to wake the run."""
        own = (type(leaf).update.__module__ for leaf in self.compiled.leaves.values())
        foreign = any(isinstance(node, Foreign) for node in self.compiled.by_path.values())
        if not foreign and all(name.startswith("grip_bt.") for name in own):
            self.pacing.poll = None
        lockstep.begin(self.context.waker)

    def _let_stop(self) -> None:
        """Let simulated time go on until what was told to stop has stopped; `_seen_out` says what hasn't."""
        if self._lockstep is not None:
            with suppress(NotStoppedError):
                self._lockstep.rest_until(lambda: self.pacing.stopped or not self.context.unfinished(), STOPPING)

    def _execute(self) -> TaskEnd:
        """Execute the task; one that happens again by py_trees' own ticks, since its leaves are replaced meanwhile."""
        again = self._re_execution
        pacer: Pacer = self.pacing if again is None else again
        if isinstance(self.compiled, CompiledMachine):
            return self.compiled.execute(pacer, make_ticker if again is None else None)
        root = self.compiled.root
        tick = root.tick_once if again is not None else self.compiled.ticker() or _engine_of(root).tick

        def tick_observed() -> None:
            if self._stale:
                self._stale = False
                self._install()
            tick()

        return self.compiled.execute(pacer, tick_observed)

    def _install(self) -> None:
        observers = [*self._observers, *([self.debugger] if self._debugged else [])]
        observer = Observers(*observers) if len(observers) > 1 else observers[0] if observers else SILENT
        self.compiled.observe(
            observer if self._re_execution is None else NewEvents(self._re_execution.recording, observer)
        )

    def _observe_debugger(self, needed: bool) -> None:
        """Have the debugger told of the nodes, or not; a tree is told between ticks."""
        if needed != self._debugged:
            self._debugged = needed
            if isinstance(self.compiled, CompiledTree):
                self._stale = True
            else:
                self._install()

    def _insist(self, called: float) -> None:
        if self._returned.wait(called + INSIST - time.monotonic()):
            return
        if self._thread is None:
            return  # not begun; it ends when it begins
        threads = terminate_outside(self.compiled.leaves) + self._hold_robot()
        for path in [path for path, leaf in self.compiled.leaves.items() if leaf.active]:
            self._say("message", path, text="terminated externally: the run did not respond to the stop")
        join_all(threads, called + ABANDON)
        if not self._returned.wait(called + ABANDON - time.monotonic()) and self._ending.acquire(blocking=False):
            self._abandon(self._made(None, "stopped"))

    def _hung(self, error: NodeError, trace: str) -> None:
        barked = time.monotonic()
        self.pacing.stop()
        join_all(terminate_outside(self.compiled.leaves) + self._hold_robot(), barked + ABANDON)
        if not self._ending.acquire(blocking=False):
            return
        if self._recorder is not None:
            self._recorder.error(error, trace)
        self._abandon(self._made(None, "error", error))

    def _abandon(self, result: RunResult) -> None:
        """End the run without its thread: what comes back from there is held off everything."""
        leaves = self.compiled.leaves
        hanging = code_running(leaves) or ({"/": "the run itself"} if not left_working(leaves) else {})
        self.compiled.observe(EndedObserver())
        lock_out(leaves)
        self._finish(result, [Zombie(path, where) for path, where in hanging.items()])

    def _finish(self, result: RunResult, hanging: Sequence[Zombie] = ()) -> None:
        if self._watchdog is not None:
            self._watchdog.stop()
        if result.outcome is not None:
            result = self._seen_out(result)
        zombies: list[Zombie] = []
        if result.outcome is None:
            result = replace(result, rest=self._see_off())
            named = {zombie.path for zombie in hanging} | set(result.rest.unconfirmed)
            workers = [zombie for zombie in left_working(self.compiled.leaves) if zombie.path not in named]
            zombies = [*hanging, *workers]
        self._result = replace(result, zombies=tuple(zombies))
        for zombie in zombies:
            self._say("zombie", zombie.path, where=zombie.where)
        if self._recorder is not None:
            self._recorder.finished(result.outcome, result.status, str(result.rest))
        if self._lockstep is not None:
            self._lockstep.leave()
        self._ended.set()

    def _seen_out(self, result: RunResult) -> RunResult:
        """Return the result when all that was told to stop has stopped; an error where it hasn't, or can't be known."""
        try:
            left = ended(self.context.unfinished, STOPPING, lambda: self.pacing.stopped)
            if not left:
                return result
            if self.pacing.stopped:
                return self._made(None, "stopped")
            raise NotStoppedError(left, "the task has ended, and it hasn't")
        except NotStoppedError as error:
            if self._recorder is not None:
                self._recorder.error(error, str(error))
            return self._made(None, "error", error)

    def _see_off(self) -> Rest:
        """After a stop or an error: hold the robot, and return what was measured when everything had ended."""
        began, leaves = time.monotonic(), self.compiled.leaves
        join_all(self._hold_robot(), began + LAST_MOMENT)
        left = ended(lambda: still_moving(leaves), REST)
        rest = self.context.rest(max(began + REST - time.monotonic(), 0.0))
        ended(lambda: [zombie for zombie in left_working(leaves) if zombie.path not in left], LAST_MOMENT)
        why = {path: leaf.given_up for path, leaf in leaves.items() if leaf.given_up}
        why |= dict.fromkeys(left, f"its work hasn't ended for {REST:g} s")
        return replace(rest, unconfirmed={**why, **rest.unconfirmed})

    def _hold_robot(self) -> list[threading.Thread]:
        return [in_background(f"hold of {part.name}", part.stop) for part in self.context.moving()]

    def _made(self, end: TaskEnd | None, status: RunStatus, error: BaseException | None = None) -> RunResult:
        if self._lost and end is None:
            status, error = "died", None
        return RunResult(
            outcome=end.outcome if end else None,
            meaning=end.meaning if end else None,
            status=status,
            failure=end.failure if end else None,
            ticks=self.pacing.ticks,
            duration=self.context.clock.now() - self._start,
            error=error,
            data={name: v for (path, name), v in self.compiled.data.snapshot().items() if path == Scopes.TASK},
            run=self.run_id or "",
            journal=None if self.journal is None else self.journal.file,
        )
