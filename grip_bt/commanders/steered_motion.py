"""An arm steered: one motion from rest to rest, a step at a time, each planned while the last one is held."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor, Steerable
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import JointState, Trajectory

from .steering import HOLD, SAMPLING

STEP = 0.4
"""How long a step lasts before it comes to rest, where executors can't extend a motion [s]."""

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
            if run is None or fresh:
                run = self._run = _Run(self._executor, self._plan_step, twist_at)
        if not fresh:
            run.go_on(twist_at)
        return run.whole


class _Run:
    """One motion from rest to rest."""

    def __init__(self, executor: Executor, plan_step: PlanStep, twist_at: Callable[[JointState], Twist]):
        self._executor, self._plan_step = executor, plan_step
        self._steerable = executor if isinstance(executor, Steerable) and executor.steerable else None
        self._lock, self._planning = threading.Lock(), False
        self._last: tuple[Trajectory, float] | None = None
        self._error: BaseException | None = None
        self.whole = run_steps(self._steps(twist_at))

    def _steps(self, twist_at: Callable[[JointState], Twist]) -> Steps[JointState]:
        """Plan the first step, from where the joints are measured to be, and follow it and what becomes of it."""
        start = self._executor.state()
        start = replace(start, velocity=np.zeros(len(start.names)))
        step: Trajectory = yield self._plan_step(start, twist_at(start), HOLD if self._steerable else STEP)
        self._last = step, 0.0
        execute = self._steerable.execute_steered if self._steerable else self._executor.execute
        measured: JointState = yield execute(step)
        if self._error is not None:
            raise self._error
        return measured

    def go_on(self, twist_at: Callable[[JointState], Twist]) -> None:
        """Plan the next step, if the last one has begun, and it isn't under way already."""
        with self._lock:
            if self._steerable is None or self._planning or self._last is None or self._error is not None:
                return
            passed, (last, began) = self._steerable.passed(), self._last
            if passed is None or not began <= passed < began + HOLD:
                return
            self._planning = True
        row = round(HOLD / SAMPLING)
        assert last.velocities is not None
        start = JointState(last.names, last.positions[row], last.velocities[row])
        try:
            planning = self._plan_step(start, twist_at(start), HOLD)
        except BaseException:
            self._planning = False
            raise
        planning.add_done_callback(partial(self._next_planned, self._steerable, planning, began + HOLD))

    def _next_planned(self, steerable: Steerable, planning: Operation[Trajectory], at: float) -> None:
        try:
            step = planning.result()
            if not self.whole.cancel_asked and steerable.amend(step, at):
                self._last = step, at
        except BaseException as error:  # noqa: BLE001 - told when the arm has come to rest
            self._error = error
        self._planning = False


def velocity_of(state: JointState, names: Sequence[str]) -> Array:
    """Return the velocities of joints, shape (n,); zero where they aren't known [rad/s]."""
    if state.velocity is None:
        return np.zeros(len(names))
    known = dict(zip(state.names, map(float, state.velocity), strict=True))
    return np.array([known.get(name, 0.0) for name in names])
