"""One steered motion: begun, gone on with step by step, and ended, over any executor."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor, Steerable
from grip_bt.base.values import JointState, Trajectory

from .steering import HOLD, SAMPLING

STEP = 0.4
"""How long a step lasts before it comes to rest, where executors know no going on [s]."""

Twist = tuple[Sequence[float], Sequence[float]]
"""Linear [m/s] and angular [rad/s] velocity of the grasp frame in world."""
PlanStep = Callable[[JointState, Twist, float], Operation[Trajectory]]
"""Where the joints are, and how fast; the twist; for how long it is held [s] -> a step that is free to its end."""


class SteeredMotion:
    """Steers an arm.

    Args:
        executor: what moves the joints. Where it isn't steerable, each step comes to rest.
        plan_step: plans a step.
    """

    def __init__(self, executor: Executor, plan_step: PlanStep):
        self._executor, self._plan_step = executor, plan_step
        self._steerable = executor if isinstance(executor, Steerable) and executor.steerable else None
        self._lock = threading.Lock()
        self._run: _Run | None = None

    def steer(self, twist_at: Callable[[JointState], Twist]) -> Operation[JointState]:
        """Begin to move, or go on; to be called every 0.1 s or so, or the arm comes to rest.

        Args:
            twist_at: returns the twist that is wanted where the joints will be when the step begins.

        Returns:
            The whole motion, from rest to rest: the same operation as long as it goes on.
        """
        with self._lock:
            run = self._run
            fresh = run is None or run.whole.done()
            if fresh:
                run = self._run = _Run(self._executor, self._steerable, self._plan_step)
        assert run is not None
        if fresh:
            run.begin(twist_at)
        else:
            run.go_on(twist_at)
        return run.whole


class _Run:
    """One motion from rest to rest."""

    def __init__(self, executor: Executor, steerable: Steerable | None, plan_step: PlanStep):
        self._executor, self._steerable, self._plan_step = executor, steerable, plan_step
        self._lock = threading.Lock()
        self._last: Trajectory | None = None
        self._last_began = 0.0
        self._planning: Operation[Trajectory] | None = None
        self._motion: Operation[JointState] | None = None
        self._error: BaseException | None = None
        self.whole: Operation[JointState] = Operation(on_cancel=self._cancel)

    def begin(self, twist_at: Callable[[JointState], Twist]) -> None:
        """Plan the first step, from where the joints are measured to be, and follow it."""
        try:
            start = self._executor.state()
            start = replace(start, velocity=np.zeros(len(start.names)))
            self._planning = self._plan_step(start, twist_at(start), HOLD if self._steerable else STEP)
        except BaseException as error:
            self.whole.fail(error)
            raise
        self._planning.add_done_callback(self._first_planned)

    def go_on(self, twist_at: Callable[[JointState], Twist]) -> None:
        """Plan the next step, if the last one has begun, and it isn't under way already."""
        with self._lock:
            if self._steerable is None or self._planning is not None or self._last is None or self._error is not None:
                return
            passed = self._steerable.passed()
            if passed is None or not self._last_began <= passed < self._last_began + HOLD:
                return
            waiting: Operation[Trajectory] = Operation()
            self._planning = waiting
        row = round(HOLD / SAMPLING)
        last, at = self._last, self._last_began + HOLD
        assert last.velocities is not None
        start = JointState(last.names, last.positions[row], last.velocities[row])
        try:
            planning = self._plan_step(start, twist_at(start), HOLD)
        except BaseException:
            with self._lock:
                self._planning = None
            raise
        with self._lock:
            if self._planning is waiting:
                self._planning = planning
        planning.add_done_callback(partial(self._next_planned, planning, at))

    def _first_planned(self) -> None:
        planning, self._planning = self._planning, None
        assert planning is not None
        try:
            step = planning.result()
            if self.whole.cancel_asked:
                raise CanceledError("the motion was stopped")
            self._last, self._last_began = step, 0.0
            self._motion = self._executor.execute(step)
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            self.whole.fail(error)
            return
        self._motion.add_done_callback(self._ended)
        if self.whole.cancel_asked:
            self._motion.cancel()

    def _next_planned(self, planning: Operation[Trajectory], at: float) -> None:
        assert self._steerable is not None
        try:
            step = planning.result()
            amended = not self.whole.cancel_asked and self._steerable.amend(step, at)
            with self._lock:
                if amended:
                    self._last, self._last_began = step, at
        except BaseException as error:  # noqa: BLE001 - told when the arm has come to rest
            self._error = error
        finally:
            with self._lock:
                self._planning = None

    def _ended(self) -> None:
        motion = self._motion
        assert motion is not None
        try:
            measured = motion.result()
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            self.whole.fail(error)
            return
        if self._error is not None:
            self.whole.fail(self._error)
        else:
            self.whole.succeed(measured)

    def _cancel(self) -> None:
        for part in (self._planning, self._motion):
            if part is not None:
                part.cancel()


def velocity_of(state: JointState, names: Sequence[str]) -> Array:
    """Return the velocities of joints, shape (n,); zero where they aren't known [rad/s]."""
    if state.velocity is None:
        return np.zeros(len(names))
    known = dict(zip(state.names, map(float, state.velocity), strict=True))
    return np.array([known.get(name, 0.0) for name in names])
