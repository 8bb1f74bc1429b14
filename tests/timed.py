"""A clock that a test moves, and fakes of an arm and a hand whose motions take time by it."""

from __future__ import annotations

import heapq
import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import chain, repeat
from typing import Any

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import CanceledError, ConstraintBrokenError, ExpectedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.commanders.fake import FakeArm, FakeExecutor, FakeHand
from grip_bt.commanders.pausing import PausableExecutor
from grip_bt.commanders.planning.requests import (
    CheckTrajectory,
    ChooseGrasp,
    PlanServoStep,
    PlanStraight,
    PlanThrough,
    PlanTo,
    Request,
)
from grip_bt.commanders.steering import spliced
from grip_bt.commanders.trajectory.stopping import accelerations_of, jerks_of, stop_ramp

Script = Iterable[ExpectedError | None]
"""One entry per request: an error to fail with, or None to do as asked; None for ever after."""
BRAKING = 40.0
"""How hard a timed hand's fingers brake, as those of an Allegro hand [rad/s^2]."""


class ManualClock:
    """Moves only when it is told to, so that a time-out of 30 s is tested in no time."""

    def __init__(self, start: float = 0.0):
        self._time = start
        self._lock = threading.Lock()
        self._listeners: list[Callable[[], None]] = []

    def now(self) -> float:
        return self._time

    def advance(self, seconds: float) -> None:
        """Let `seconds` [s] pass, and have those woken who wait for the time; ValueError where they are negative."""
        if seconds < 0:
            raise ValueError(f"time doesn't go back: {seconds} s")
        with self._lock:
            self._time += seconds
            listeners = list(self._listeners)
        for listener in listeners:
            listener()

    def on_advance(self, listener: Callable[[], None]) -> None:
        with self._lock:
            self._listeners.append(listener)


class OnClock:
    """Time of a clock that somebody moves; what has come due happens in order, within the move.

    Args:
        clock: the clock.
    """

    def __init__(self, clock: ManualClock):
        self._clock = clock
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        clock.on_advance(self._run)

    def now(self) -> float:
        return self._clock.now()

    def stamp(self) -> float:
        return self._clock.now()

    def after(self, delay: float, action: Callable[[], None]) -> None:
        self._count += 1
        heapq.heappush(self._due, (self._clock.now() + delay, self._count, action))

    def _run(self) -> None:
        # A hair of tolerance: sums of clock steps aren't exact.
        while self._due and self._due[0][0] <= self._clock.now() + 1e-9:
            heapq.heappop(self._due)[2]()


@dataclass
class _Motion:
    trajectory: Trajectory
    begin: float
    operation: Operation[JointState]
    failure: Exception | None = None
    braking: bool = False

    @property
    def end(self) -> float:
        return self.trajectory.duration / (2 if self.failure and not self.braking else 1)


class TimedExecutor(FakeExecutor):
    """Joints that move as trajectories say, by a schedule.

    Args:
        script: what becomes of each motion: None reaches its end, an error ends it half-way.
        accelerations: joint -> limit, for braking; see `trajectory.stopping.accelerations_of`.
        jerks: joint -> limit, likewise; any where it names none.
    """

    def __init__(
        self,
        start: JointState,
        schedule: OnClock,
        script: Script = (),
        accelerations: Mapping[str, float] | None = None,
        jerks: Mapping[str, float] | None = None,
    ):
        super().__init__(start)
        self._script = chain(script, repeat(None))
        self._schedule = schedule
        self._limits = accelerations_of(start.names, accelerations or {}), jerks_of(start.names, jerks or {})
        self._motion: _Motion | None = None

    def state(self) -> JointState:
        position, velocity = self._position, np.zeros(len(self.joint_names))
        if self._motion is not None:
            (position,), (velocity,), _ = self._motion.trajectory.sampled(np.array([self._progress(self._motion)]))
        return JointState(self.joint_names, position, velocity, time=self._schedule.stamp())

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        if trajectory.names == self.joint_names:
            self.put_back(self.state().position)
        return super().execute(trajectory)

    execute_steered = execute

    def _move(self, trajectory: Trajectory) -> Operation[JointState]:
        operation: Operation[JointState] = Operation(on_cancel=lambda: self._brake(motion))
        self._motion = motion = _Motion(trajectory, self._schedule.now(), operation, next(self._script))
        self._finish_after(motion)
        return operation

    def stop(self) -> None:
        if self._motion is not None:
            self._brake(self._motion)

    def put_back(self, position: Array) -> None:
        """End a motion under way as cancelled, and have the joints at a position."""
        motion, self._motion = self._motion, None
        super().put_back(position)
        if motion is not None:
            motion.operation.fail(CanceledError("replaced by another motion"))

    def _progress(self, motion: _Motion) -> float:
        return self._schedule.now() - motion.begin

    def passed(self) -> float | None:
        motion = self._motion
        return None if motion is None or motion.braking else self._progress(motion)

    def amend(self, tail: Trajectory, at: float) -> bool:
        motion = self._motion
        if motion is None or motion.braking or self._progress(motion) > min(at, motion.end) + 1e-9:
            return False
        motion.trajectory = spliced(motion.trajectory, tail, at)
        self.executed.append(tail)
        return True

    def _finish_after(self, motion: _Motion) -> None:
        """Finish when the motion has come to its end, however much later that is by then."""

        def look() -> None:
            if self._progress(motion) < motion.end - 1e-9:
                self._finish_after(motion)
            else:
                self._finish(motion)

        self._schedule.after(max(0.0, motion.end - self._progress(motion)), look)

    def _brake(self, motion: _Motion) -> None:
        if self._motion is motion and not motion.braking:
            ramp = stop_ramp(motion.trajectory, self._progress(motion), *self._limits)
            motion.trajectory, motion.begin, motion.braking = ramp, self._schedule.now(), True
            self._finish_after(motion)

    def _finish(self, motion: _Motion) -> None:
        if self._motion is not motion:
            return
        error = CanceledError("the motion was stopped") if motion.braking else motion.failure
        self._position = self.state().position if error is not None else np.array(motion.trajectory.positions[-1])
        self._motion = None
        if error is not None:
            motion.operation.fail(error)
        else:
            motion.operation.succeed(self.state())


_VERBS: Mapping[type[Request], str] = {
    PlanTo: "plan",
    PlanStraight: "plan_straight",
    PlanThrough: "plan_through",
    CheckTrajectory: "plan_from_trajectory",
    PlanServoStep: "plan_step",
    ChooseGrasp: "choose_grasp",
}


class _Scripted:
    """A planner that fails as scripts say; a constraint that is broken comes first."""

    def __init__(self, planner: Any, scripts: Mapping[str, Script]):
        for verb in scripts:
            if verb not in _VERBS.values():
                raise UnknownNameError("verb of a fake arm", verb, (*_VERBS.values(), "execute"))
        self._planner = planner
        self._scripts = {verb: chain(scripts.get(verb, ()), repeat(None)) for verb in _VERBS.values()}

    def submit(self, request: Request) -> Operation[Any]:
        made = self._planner.submit(request)
        if type(request) not in _VERBS:
            return made
        try:
            made.result()
        except ConstraintBrokenError:
            return made
        except ExpectedError:
            pass
        failure = next(self._scripts[_VERBS[type(request)]])
        return made if failure is None else Operation.failed(failure)


class TimedArm(FakeArm):
    """A fake arm whose motions take time, can be held, and fail as scripts say.

    Args:
        script: verb (`plan`, `plan_straight`, `plan_through`, `plan_from_trajectory`, `plan_step`, `choose_grasp`,
            `execute`) -> what becomes of each such request; `plan_step` is asked while the arm is steered.
    """

    def __init__(
        self,
        name: str = "right",
        home: Pose | None = None,
        schedule: OnClock | None = None,
        script: Mapping[str, Script] | None = None,
        **more: Any,
    ):
        schedule, scripts = schedule or OnClock(ManualClock()), dict(script or {})
        execute = scripts.pop("execute", ())

        def joints(start: JointState) -> Any:
            self.timed = TimedExecutor(start, schedule, execute)
            self._held = PausableExecutor(self.timed, now=schedule.now)
            return self._held

        super().__init__(name, home, executor=joints, **more)
        self._planner = _Scripted(self._planner, scripts)

    def pause(self) -> None:
        self._held.pause()

    def resume(self) -> None:
        self._held.resume()


class TimedHand(FakeHand):
    """A fake hand whose fingers take time."""

    def __init__(self, start: JointState, schedule: OnClock, thing: JointState | None = None, **more: Any):
        limits = dict.fromkeys(start.names, BRAKING)
        super().__init__(start, thing, executor=lambda at: TimedExecutor(at, schedule, accelerations=limits), **more)
