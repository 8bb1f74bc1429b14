"""Operations made of operations: what several leaves need to move an arm through a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from grip_bt.base.failures import CanceledError, ExpectedError, NoPlanError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Context, Scene
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import JointState, PathConstraint, Pose
from grip_bt.base.values.solids import Solid
from grip_bt.commanders.trajectory.limits import RestDetector

T = TypeVar("T")


def go(arm: Arm, goal: JointState | Pose | str, constraint: PathConstraint | None = None) -> Operation[JointState]:
    """Plan a free path from where the arm is now, one that keeps to a constraint if there is one, and follow it."""
    return arm.plan(goal, constraint=constraint).then(arm.execute)


def go_straight(
    arm: Arm, goals: Sequence[Pose], scene: Scene | None = None, ignore: Sequence[str] = ()
) -> Operation[JointState]:
    """Move the grasp frame along straight lines through `goals`; the plan doesn't see the objects named in `ignore`."""
    if scene is None or not ignore:
        return arm.plan_straight(goals).then(arm.execute)
    return without(scene, ignore, lambda: arm.plan_straight(goals)).then(arm.execute)


def without(scene: Scene, names: Sequence[str], plan: Callable[[], Operation[T]]) -> Operation[T]:
    """Start an operation for which the scene lacks some objects; they are back when it ends.

    Attached objects and names that aren't in the scene are left as they are.
    """
    taken = {name: scene.solid(name) for name in names if name in scene.names()}
    for name in taken:
        scene.remove(name)
    return _restoring(scene, taken, plan)


def widened(scene: Scene, names: Sequence[str], by: float, plan: Callable[[], Operation[T]]) -> Operation[T]:
    """Start an operation for which upright boxes, not attached ones, reach `by` [m] further, but not upwards.

    They are as before when it ends.
    """
    taken = {name: scene.solid(name) for name in names}
    for name in taken:
        size, pose = scene.box(name)
        scene.set_box(name, (size[0] + 2 * by, size[1] + 2 * by, size[2]), pose)
    return _restoring(scene, taken, plan)


def _restoring(scene: Scene, taken: dict[str, tuple[Solid, Pose]], plan: Callable[[], Operation[T]]) -> Operation[T]:
    def restore() -> None:
        for name, (solid, pose) in taken.items():
            scene.put(name, solid, pose)

    try:
        operation = plan()
    except BaseException:
        restore()
        raise
    operation.add_done_callback(restore)
    return operation


def first_of(attempts: Iterable[Callable[[], Operation[T]]]) -> Operation[T]:
    """Return an operation that makes one attempt after the other until one succeeds.

    It ends with the last attempt's error when all have failed. A cancelled attempt and an error that isn't expected
    end it.
    """
    return run_steps(_first_of(attempts))


def _first_of(attempts: Iterable[Callable[[], Operation[T]]]) -> Steps[T]:
    failed: ExpectedError = NoPlanError("there was nothing to try")
    for attempt in attempts:
        try:
            current = attempt()
            try:
                found: T = yield current
            except CanceledError:
                return current.result()  # where it was quicker
            return found
        except CanceledError:
            raise
        except ExpectedError as error:
            failed = error
    raise failed


LOOK = 0.05
"""How often it is looked at whether they are [s]."""


class Resting:
    """Looks at joints, at each tick and on until they are at rest; a leaf is woken for each look."""

    def __init__(self, context: Context, state: Callable[[], JointState]):
        self._context, self._state = context, state
        self._judge, self._rest = RestDetector(), False

    def reached(self) -> bool:
        """Tell whether the joints were measured at rest; where nothing is measured, they weren't."""
        now = self._context.clock.now()
        if not self._rest:
            try:
                state = self._state()
                self._rest = self._judge.see(state if state.time else replace(state, time=now))
            except SensorError:
                pass
            if not self._rest:
                self._context.wake_at(now + LOOK)
        return self._rest
