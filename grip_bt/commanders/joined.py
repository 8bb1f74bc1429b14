"""Several parts of a robot as one: operations that end together, plans of several arms, executors of one group."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Executor
from grip_bt.base.values import JointState, Plan, Trajectory


def require_joints(names: Sequence[str], allowed: Sequence[str], arm: str) -> None:
    """Verify that an arm has the joints that are named. Raises UnknownNameError: it lacks one."""
    for name in names:
        if name not in allowed:
            raise UnknownNameError("joint", name, allowed, where=f"arm {arm!r}")


def same_joints(position: ArrayLike, names: Sequence[str]) -> Array:
    """Return a copy of the positions of these joints, shape (n,).

    Raises:
        ValueError: they are of another number of joints.
    """
    row = np.array(position, dtype=float)
    if row.shape != (len(names),):
        raise ValueError(f"the state is of another robot: this one has the joints {', '.join(names)}, not {row.shape}")
    return row


K = TypeVar("K")
T = TypeVar("T")


def all_of(starts: Mapping[K, Callable[[], Operation[T]]]) -> Operation[dict[K, T]]:
    """Start operations and return one that succeeds, with each one's result, when all have succeeded.

    When one fails, the others are cancelled; the whole ends with the first error when all have ended, so that nothing
    moves any more then. Cancelling the whole cancels them all. What can't be started counts as failed.

    Args:
        starts: name -> function that starts its operation.
    """
    parts: dict[K, Operation[T]] = {}
    lock, left, errors = threading.Lock(), len(starts), list[BaseException]()

    def cancel() -> None:
        for part in list(parts.values()):
            part.cancel()

    def ended(part: Operation[T]) -> None:
        nonlocal left
        try:
            part.result()
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            with lock:
                errors.append(error)
                first = len(errors) == 1
            if first:
                cancel()
        with lock:
            left -= 1
            last = left == 0
        if last and errors:
            whole.fail(errors[0])
        elif last:
            whole.succeed({name: each.result() for name, each in parts.items()})

    whole: Operation[dict[K, T]] = Operation(on_cancel=cancel)
    for name, start in starts.items():
        try:
            parts[name] = start() if not errors else Operation.failed(errors[0])
        except Exception as error:  # noqa: BLE001 - the others must be cancelled, then the owner raises it
            parts[name] = Operation.failed(error)
        if errors or whole.cancel_asked:  # another one has failed while this one was being started
            parts[name].cancel()
        parts[name].add_done_callback(partial(ended, parts[name]))
    if not starts:
        whole.succeed({})
    return whole


def execute_together(parts: Mapping[str, tuple[Arm, Plan]]) -> Operation[dict[str, JointState]]:
    """Execute plans of several arms at once; the quicker ones are slowed down, so that all end at the same time.

    Each plan was made with the other arms where they were then. Before anything moves, the common motion is checked as
    a whole, what the hands hold included.

    Args:
        parts: name -> arm and its plan.

    Returns:
        What was measured at the end, by name. It ends with PathInvalidError, and nothing has moved, where the arms
        would meet.
    """
    longest = max((plan.trajectory.duration for _, plan in parts.values()), default=0.0)
    slowed = {
        name: (arm, replace(plan, trajectory=plan.trajectory.stretched(longest))) for name, (arm, plan) in parts.items()
    }
    starts = {name: partial(arm.execute, plan) for name, (arm, plan) in slowed.items()}
    if len(slowed) < 2:
        return all_of(starts)
    first = next(iter(slowed.values()))[0]
    return first.check_together([plan for _, plan in slowed.values()]).then(lambda _: all_of(starts))


class JoinedExecutor:
    """Several executors as one, for a group that spans several arms: a trajectory's columns go to whoever moves them.

    Implements `ports.Executor`.

    Args:
        parts: executors of different joints; the order of joints is theirs, one after the other.
    """

    def __init__(self, *parts: Executor):
        self._parts = parts
        self.joint_names = tuple(name for part in parts for name in part.joint_names)
        if len(set(self.joint_names)) != len(self.joint_names):
            raise ValueError(f"two executors move the same joint: {sorted(self.joint_names)}")

    def state(self) -> JointState:
        return _merged([part.state() for part in self._parts])

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        if set(trajectory.names) != set(self.joint_names):
            raise ValueError(f"the trajectory moves {trajectory.names}, these executors {self.joint_names}")
        starts = {k: partial(part.execute, trajectory.of(part.joint_names)) for k, part in enumerate(self._parts)}
        return all_of(starts).then(lambda ends: Operation.finished(_merged([ends[k] for k in starts])))

    def stop(self) -> None:
        for part in self._parts:
            part.stop()


def _merged(states: list[JointState]) -> JointState:
    def joined(parts: list[Array | None]) -> Array | None:
        known = [part for part in parts if part is not None]
        return np.concatenate(known) if len(known) == len(parts) else None

    names = tuple(name for state in states for name in state.names)
    time = min(state.time for state in states)
    position = np.concatenate([state.position for state in states])
    velocity, effort = joined([state.velocity for state in states]), joined([state.effort for state in states])
    return JointState(names, position, velocity, effort, time)
