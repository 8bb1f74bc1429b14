"""Motions that are stopped at some moment, what is measured of them, and how that is judged."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from patience import PATIENCE
from plain_client import swing

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory

AT_REST = 0.02
"""Joints slower than this are at rest [rad/s or m/s]: what is measured of simulated ones is never quite still."""
BEYOND = 0.15
"""Joints are at rest no later than this after what braking at their limits takes [s]."""
LOOK = 0.01
"""How often it is looked at where the joints are [s]."""
WAYS: dict[str, Callable[[Any, Operation[Any]], None]] = {
    "cancel": lambda port, operation: operation.cancel(),
    "stop": lambda port, operation: port.stop(),
    "pause": lambda port, operation: port.pause(),
}


@dataclass
class Stopped:
    """What was measured of a motion that was stopped.

    Attributes:
        times: of the measurements, shape (k,) [s].
        positions: shape (k, n).
        velocities: measured, or by differences of the positions where nobody measures them, shape (k, n).
        asked: when the stop was asked for, on the clock of the measurements [s].
        ended: when the operation had ended, on that clock; None in a pause.
        error: what it ended with.
    """

    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    asked: float
    ended: float | None = None
    error: BaseException | None = None

    @property
    def rest(self) -> float:
        """Since when the joints are at rest [s]."""
        moving = np.flatnonzero(np.abs(self.velocities).max(axis=1) > AT_REST)
        return float(self.times[min(moving[-1] + 1, len(self.times) - 1)]) if len(moving) else float(self.times[0])

    def beyond(self, limits: Any) -> float:
        """Return how much longer coming to rest took than braking at the joints' limits, from the ask on [s]."""
        at = int(np.clip(np.searchsorted(self.times, self.asked), 0, len(self.times) - 1))
        near = self.velocities[max(0, at - 2) : at + 3]
        needed = float((np.abs(near).max(axis=0) / limits).max())
        return max(self.rest, self.asked) - self.asked - needed

    def hardest(self, limits: Any) -> float:
        """Return the largest acceleration since the ask as part of the limits; for measurements without noise."""
        since = self.times >= self.asked - 1e-9
        change = np.diff(self.velocities[since], axis=0) / np.diff(self.times[since])[:, None]
        return float((np.abs(change) / limits).max(initial=0.0))


def smooth(rig: Any, seconds: float) -> Trajectory:
    """Return a way to the rig's goal from rest to rest, with velocities."""
    names = rig.port.joint_names
    points = swing(rig.port.state().ordered(names), rig.goal.ordered(names), seconds)
    times, positions, velocities = (np.array(column) for column in zip(*points, strict=True))
    return Trajectory(names, times, positions, velocities)


def go_elsewhere(rig: Any) -> None:
    """Have the next motion go to that end of the rig's way which is further off; beyond them joints may have limits."""
    here = rig.port.state()
    rig.goal = max(rig.ends, key=lambda end: np.abs(end.ordered(here.names) - here.position).max())


def stopped(rig: Any, begin: Callable[[], Operation[Any]], moment: float, way: str) -> Stopped:
    """Begin a motion, stop it some time later, and watch it until the joints stand and the operation has ended.

    Args:
        rig: whose motion; its `let_pass` lets time pass.
        begin: begins it.
        moment: so long after it began to move [s].
        way: of `WAYS`.
    """
    seen: list[JointState] = []

    def look() -> None:
        state = rig.port.state()
        if not seen or state.time > seen[-1].time:
            seen.append(state)

    def pass_on() -> None:
        rig.let_pass(LOOK)
        look()

    look()
    first = seen[0].position
    operation = begin()
    while not operation.done() and np.abs(seen[-1].position - first).max() < 1e-3:
        pass_on()
    began = seen[-1].time
    while not operation.done() and seen[-1].time < began + moment:
        pass_on()
    asked = _now(rig, seen[-1])
    WAYS[way](rig.port, operation)
    ended, since = None, time.monotonic()
    while ended is None:
        assert time.monotonic() < since + PATIENCE
        if operation.done() or (way == "pause" and _stands(seen, asked)):
            ended = _now(rig, seen[-1])
        else:
            pass_on()
    until = seen[-1].time + 0.5
    while seen[-1].time < until:
        pass_on()
    error = None
    if operation.done():
        try:
            operation.result()
        except CanceledError as canceled:
            error = canceled
    if way == "pause":
        rig.port.resume()
        operation.cancel()
        rig.wait(operation)
    return of_states(seen, asked, ended if way != "pause" else None, error)


def of_states(seen: Sequence[JointState], asked: float, ended: float | None, error: Any) -> Stopped:
    """Return what was seen; velocities are differences where all that are measured are 0."""
    times, positions = np.array([s.time for s in seen]), np.stack([s.position for s in seen])
    measured = [s.velocity for s in seen]
    known = all(v is not None for v in measured) and any(np.any(v) for v in measured)
    velocities = np.stack(measured) if known else np.gradient(positions, times, axis=0)  # type: ignore[arg-type]
    return Stopped(times, positions, velocities, asked, ended, error)


def _now(rig: Any, last: JointState) -> float:
    """Return the time on the clock of the measurements."""
    if rig.exact:
        return float(last.time)
    now = rig.port.state().time
    return time.time() if abs(now - time.time()) < 1000 else float(now)  # stamped by the wall, or by a simulation


def _stands(seen: Sequence[JointState], asked: float) -> bool:
    lately = [state.position for state in seen if state.time > seen[-1].time - 0.3]
    return bool(seen[-1].time > asked + 0.35 and np.ptp(lately, axis=0).max() < 1e-3)
