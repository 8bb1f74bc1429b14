"""Motions that are held in a pause and gone on with, over executors and hands that can only stop.

Controllers of ROS, for one, know no pause: a motion is cancelled, so that the joints hold, and what is left of it is
begun again from where they are measured to be, along the same path.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Generic, TypeVar

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import CanceledError, ExecutionAbortedError, ExpectedError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor, HandPort, Steerable, TouchPoints
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import JointState, Trajectory
from grip_bt.base.values.joints import ContactPoint

from .steering import spliced
from .trajectory.stopping import ANY, accelerations_of, eased_down, jerks_of, smooth_start

J = TypeVar("J")
SHORTEST = 0.1
"""A rest of a motion takes no less than this [s]."""
ASIDE = 0.1
"""Joints that are further from the path than this [rad or m] were moved by something else meanwhile."""
_ASIDE_PART = 0.1
"""What part of the joints' accelerations brings them back to the path."""
_GRID, _DOUBT = 0.005, 0.01
"""Spacing of the search for where on its path a motion is [s]; what a second that it is early or late weighs [rad]."""


def rest_of(
    trajectory: Trajectory, measured: Array, passed: float, acceleration: Array, jerk: Array | None = None
) -> Trajectory:
    """Return what is left of a trajectory that was stopped: the same path, from rest.

    It begins at the point of the path that is nearest to where the joints are, by their distance and by the time, and
    comes up to its speed as quickly as the joints' limits allow. What the joints are off the path fades meanwhile.

    Args:
        measured: where its joints are, in its order.
        passed: how long it had been under way [s].
        acceleration: limits of its joints, shape (n,) [rad/s^2 or m/s^2].
        jerk: likewise [rad/s^3 or m/s^3]; None for any.

    Raises:
        ExecutionAbortedError: the joints are too far from the path.
    """
    times = np.linspace(0.0, trajectory.duration, max(2, int(trajectory.duration / _GRID)))
    away = np.abs(trajectory.sampled(times)[0] - measured).max(axis=1)
    nearest = int((away + _DOUBT * np.abs(times - passed)).argmin())
    if away[nearest] > ASIDE:
        raise ExecutionAbortedError(
            f"the joints moved during the pause: they are {away[nearest]:.3f} off its path",
            error=float(away[nearest]),
        )
    begin = float(times[nearest])
    aside = measured - trajectory.at(begin)
    jerk = np.full(len(aside), ANY) if jerk is None else jerk
    fading = max(
        SHORTEST,
        float(np.sqrt(6 * np.abs(aside) / (_ASIDE_PART * acceleration)).max()),
        float(np.cbrt(60 * np.abs(aside) / (_ASIDE_PART * jerk)).max()),
    )
    return eased_down(_fading(smooth_start(trajectory, begin, acceleration, jerk), aside, fading), acceleration, jerk)


def _fading(rest: Trajectory, aside: Array, within: float) -> Trajectory:
    """Return a trajectory that begins aside of its path, shape (n,), and is on it after a time [s], smoothly."""
    if rest.duration == 0.0:
        still = np.zeros((2, len(aside)))
        rest = Trajectory(rest.names, np.array([0.0, within]), np.tile(rest.positions, (2, 1)), still, still)
    rest = rest.stretched(within)
    assert rest.velocities is not None
    assert rest.accelerations is not None
    part = np.clip(rest.times / within, 0.0, 1.0)
    return Trajectory(
        rest.names,
        rest.times,
        rest.positions + np.outer(1 - 10 * part**3 + 15 * part**4 - 6 * part**5, aside),
        rest.velocities - np.outer(30 * (part - part**2) ** 2 / within, aside),
        rest.accelerations - np.outer(60 * part * (1 - part) * (1 - 2 * part) / within**2, aside),
    )


class _Motion(Generic[J]):
    """One motion, in as many parts as it takes."""

    def __init__(self, job: J, do: Callable[[J], Operation[JointState]]):
        self.job, self.do = job, do
        self.part: Operation[JointState] | None = None
        self.held = self.parted = False
        self.began = self.passed = 0.0
        self.goes_on: Operation[None] = Operation.finished(None)


class _InParts(Generic[J]):
    """One motion at a time, done in parts: `do` does one, `rest` is what is left of a job after a time [s]."""

    def __init__(
        self,
        port: Executor | HandPort,
        do: Callable[[J], Operation[JointState]],
        rest: Callable[[J, float], J],
        now: Callable[[], float] = time.monotonic,
    ):
        self.joint_names, self._port, self._do, self._rest, self._now = port.joint_names, port, do, rest, now
        self._lock = threading.RLock()  # a part that ends while it is changed is heard of in the middle of that
        self._paused = False
        self._motion: _Motion[J] | None = None
        self._whole: Operation[JointState] = Operation.failed(CanceledError("nothing was begun"))

    def state(self) -> JointState:
        return self._port.state()

    def _begin(self, job: J, do: Callable[[J], Operation[JointState]] | None = None) -> Operation[JointState]:
        """Begin a motion, by `do`; one under way is cancelled. In a pause it waits for the end of that."""
        self._whole.cancel()
        motion = _Motion(job, do or self._do)
        with self._lock:
            self._motion = motion
        self._whole = whole = run_steps(self._parts(motion))
        if motion.part is None and whole.done():  # what can't be begun is a mistake of whoever asks
            whole.result()
        return whole

    def stop(self) -> None:
        self._whole.cancel()
        self._port.stop()

    def pause(self) -> None:
        with self._lock:
            self._paused = True
            motion = self._motion
        if motion is not None:
            self._hold(motion)

    def resume(self) -> None:
        with self._lock:
            self._paused = False
            motion = self._motion
        if motion is not None:
            motion.goes_on.succeed(None)

    def _untouched(self) -> _Motion[J] | None:
        """Return the motion under way, if it never was held; with the lock."""
        motion = self._motion
        return motion if motion is not None and motion.part is not None and not motion.parted else None

    def _parts(self, motion: _Motion[J]) -> Steps[JointState]:
        while True:
            with self._lock:
                motion.goes_on = Operation() if self._paused else Operation.finished(None)
            yield motion.goes_on
            if motion.parted:
                motion.job, motion.do = self._rest(motion.job, motion.passed), self._do
            part = motion.do(motion.job)
            with self._lock:
                motion.part, motion.began, motion.held = part, self._now(), False
                paused = self._paused
            if paused:
                self._hold(motion)
            try:
                return (yield part)
            except CanceledError:
                if not motion.held:
                    raise
                with self._lock:
                    motion.part = None

    def _hold(self, motion: _Motion[J]) -> None:
        with self._lock:
            part = motion.part
            if part is None or motion.held:
                return
            motion.held = motion.parted = True
            motion.passed = self._now() - motion.began
        part.cancel()


class PausableExecutor(_InParts[Trajectory]):
    """Implements `grip_bt.base.ports.Executor`, `Steerable` and `Pausable` over an executor that can be stopped.

    It is steerable where that executor is; a motion that was held in its middle isn't changed any more, but goes on to
    its end. One that is held ends with ExecutionAbortedError where something else moved the joints meanwhile.

    Args:
        executor: moves the joints, and can stop them.
        accelerations: joint -> limit [rad/s^2 or m/s^2]; see `trajectory.stopping.accelerations_of`.
        now: the executor's time [s].
        jerks: joint -> limit [rad/s^3 or m/s^3], with which a motion is gone on with.
    """

    def __init__(
        self,
        executor: Executor,
        accelerations: Mapping[str, float] | None = None,
        now: Callable[[], float] = time.monotonic,
        jerks: Mapping[str, float] | None = None,
    ):
        super().__init__(executor, executor.execute, self._left, now)
        self._accelerations, self._jerks = accelerations or {}, jerks or {}
        self._steered = executor if isinstance(executor, Steerable) else None

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        return self._begin(trajectory)

    def execute_steered(self, trajectory: Trajectory) -> Operation[JointState]:
        return self._begin(trajectory, None if self._steered is None else self._steered.execute_steered)

    @property
    def steerable(self) -> bool:
        return self._steered is not None and self._steered.steerable

    def passed(self) -> float | None:
        with self._lock:
            untouched = self._untouched() is not None
        return self._steered.passed() if self._steered is not None and untouched else None

    def amend(self, tail: Trajectory, at: float) -> bool:
        with self._lock:
            motion = self._untouched()
            if self._steered is None or motion is None or not self._steered.amend(tail, at):
                return False
            motion.job = spliced(motion.job, tail, at)
            return True

    def _left(self, trajectory: Trajectory, passed: float) -> Trajectory:
        names = trajectory.names
        try:
            measured = self.state().ordered(names)
        except ExpectedError as error:
            raise ExecutionAbortedError(f"the motion was paused, and {error.message}", cause=error.code) from None
        accelerations, jerks = accelerations_of(names, self._accelerations), jerks_of(names, self._jerks)
        return rest_of(trajectory, measured, passed, accelerations, jerks)


class PausableHand(_InParts[tuple[JointState, float, float | None, float | None]]):
    """Implements `grip_bt.base.ports.HandPort` and `Pausable` over a hand that can be stopped."""

    def __init__(self, hand: HandPort):
        super().__init__(
            hand, lambda job: hand.move(*job), lambda job, passed: (job[0], max(job[1] - passed, SHORTEST), *job[2:])
        )
        self.contacts = hand.contacts
        self.contact_points: Callable[[], Sequence[ContactPoint]] = (
            hand.contact_points if isinstance(hand, TouchPoints) else tuple
        )

    def move(
        self, posture: JointState, duration: float, torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        return self._begin((posture, duration, torque_limit, force))
