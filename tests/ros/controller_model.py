"""A joint trajectory controller of ros2_control and the way to it, without ROS and without a clock that runs."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from itertools import count

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from grip_bt.base.failures import ExecutionAbortedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory
from grip_bt.ros.controllers.following import Following


class ModelTime:
    """Time that goes from one thing that happens to the next; implements `following.Time`."""

    def __init__(self):
        self.time, self._queue, self._order = 0.0, [], count()

    def now(self) -> float:
        return self.time

    def after(self, delay: float, action: Callable[[], None]) -> None:
        heapq.heappush(self._queue, (self.time + max(0.0, delay), next(self._order), action))

    def run(self, until: float) -> None:
        while self._queue and self._queue[0][0] <= until:
            self.time, _, action = heapq.heappop(self._queue)
            action()
        self.time = until


class ModelController:
    """Follows goals as joint_trajectory_controller does: a new one from the position and velocity of that moment.

    Args:
        clock: its time.
        delay: returns what the next message takes on its way [s].
    """

    def __init__(self, names: tuple[str, ...], clock: ModelTime, delay: Callable[[], float]):
        self.names, self._clock, self._delay = names, clock, delay
        self._latest: Operation | None = None
        start = CubicHermiteSpline([0.0, 1e-3], np.zeros((2, len(names))), np.zeros((2, len(names))))
        self.curves = [(0.0, start)]
        """When each goal came, and the joints by the time since the clock's beginning."""

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        return self.at(self._clock.now())

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and velocities at a time that isn't before the last goal came, each shape (n,)."""
        curve = next(curve for came, curve in reversed(self.curves) if came <= time)
        if time > curve.x[-1]:
            return curve(curve.x[-1]), np.zeros(len(self.names))
        return curve(time), curve(time, 1)

    def velocities(self, step: float) -> np.ndarray:
        """Return how fast the joints were all the time, shape (k, n)."""
        ends = [*(came for came, _ in self.curves[1:]), self._clock.now()]
        parts = []
        for (came, curve), end in zip(self.curves, ends, strict=True):
            moved = min(end, curve.x[-1])
            parts.append(curve(np.linspace(came, moved, max(2, int((moved - came) / step))), 1))
        return np.concatenate(parts)

    def send(self, trajectory: Trajectory, ahead: float, accepted: Callable[[], None]) -> Operation:
        """Have a goal come after a while, and hear of it after another while; it is `following.Send`."""
        goal: Operation = Operation(on_cancel=lambda: None)
        self._clock.after(self._delay(), lambda: self._come(goal, trajectory, ahead, accepted))
        return goal

    def _come(self, goal: Operation, trajectory: Trajectory, ahead: float, accepted: Callable[[], None]) -> None:
        before, self._latest = self._latest, goal
        if before is not None:
            self._clock.after(self._delay(), lambda: before.fail(ExecutionAbortedError("a newer goal")))
        now, (position, velocity) = self._clock.now(), self.state()
        first = 0 if ahead > 0 else 1
        times = np.array([now, *(now + ahead + trajectory.times[first:])])
        positions = np.vstack([position, trajectory.positions[first:]])
        self.curves.append((now, CubicHermiteSpline(times, positions, [velocity, *trajectory.velocities[first:]])))
        answer = self._delay()
        self._clock.after(answer, accepted)
        end = max(times[-1] - now, answer) + self._delay()
        self._clock.after(end, lambda: goal.succeed(None) if self._latest is goal else None)


class ModelExecutor:
    """Implements `ports.Steerable` and what a stream asks of an executor, over the model."""

    steerable = True

    def __init__(self, controller: ModelController, clock: ModelTime):
        self._controller, self._clock = controller, clock
        self._following: Following | None = None
        self.amended = 0

    @property
    def joint_names(self):
        return self._controller.names

    def state(self) -> JointState:
        position, velocity = self._controller.state()
        return JointState(self._controller.names, position, velocity)

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        self._following = Following(self._controller.send, trajectory, self._clock)
        self._following.begin()
        return self._following.whole.then(lambda _: Operation.finished(self.state()))

    def stop(self) -> None:
        """Never asked here."""

    def passed(self) -> float | None:
        return None if self._following is None else self._following.passed()

    def amend(self, tail: Trajectory, at: float) -> bool:
        assert self._following is not None
        amended = self._following.amend(tail, at)
        self.amended += amended
        return amended
