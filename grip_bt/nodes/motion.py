"""Operations made of operations: what several leaves need to move an arm through a scene; and what a motion keeps to.

Tasks say it by the parameter `keep`, or by a bound `PathConstraint`:

keep: {orientation: now, tolerance: [0.1, 0.1, free]}
keep: {box: {position: [0.5, 0, 0.4], size: [0.4, 0.8, 0.3]}}
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from grip_bt.base.errors import listing, nearest
from grip_bt.base.failures import CanceledError, ExpectedError, NoPlanError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Context, Scene
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.types import Value
from grip_bt.base.values import JointState, PathConstraint, Pose
from grip_bt.base.values.solids import Solid
from grip_bt.commanders.trajectory.limits import RestDetector

from .leaf import Leaf

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


def check_word(name: str, path: str) -> None:
    """Raise ValueError unless a name that is taught is a word."""
    if not name.isidentifier():
        raise ValueError(f"{path}: a taught name is a word of letters, digits and _, not {name!r}")


NOW = "now"
"""The orientation that the hand has when the motion begins."""
FREE = "free"
"""A tolerance that any turn is within."""
_KEYS = ("orientation", "tolerance", "axes", "box")
_BOX = ("position", "quaternion", "size")


def verify_keep(leaf: Leaf, keep: Mapping[str, object]) -> None:
    """Verify before the run what a leaf's motion has to keep to; ValueError where it is said twice, or wrongly."""
    if not keep:
        return
    if "constraint" in leaf.readers:
        raise ValueError(f"{leaf.path}: give either `with: {{keep: ...}}` or `in: {{constraint: ...}}`")
    if keep.get("orientation") == NOW and "start" in leaf.readers:
        raise ValueError(f"{leaf.path}: keep: `{NOW}` is how the hand is; this plan begins at a given `start`")
    try:
        read_keep(keep, Pose())
    except ValueError as error:
        raise ValueError(f"{leaf.path}: keep: {error}") from error


def read_keep(keep: Mapping[str, object], here: Pose) -> PathConstraint:
    """Read the parameter `keep`.

    Args:
        keep: `orientation` (`now`, or w x y z), `tolerance` (3 angles [rad], or `free`), `axes`, `box`.
        here: the pose that `now` means.

    Raises:
        ValueError: a key or a value isn't one of these, or there is nothing to keep to.
    """
    _known(keep, _KEYS, "keep")
    if "orientation" not in keep and "box" not in keep:
        raise ValueError("it holds an `orientation`, a `box` or both")
    if "orientation" not in keep and ("tolerance" in keep or "axes" in keep):
        raise ValueError("`tolerance` and `axes` belong to an `orientation`: `now`, or the numbers w, x, y, z")
    fields: dict[str, Value] = {}
    if "orientation" in keep:
        fields["orientation"] = _orientation(keep["orientation"], here)
        fields["axes"] = keep.get("axes", "world")
        fields["tolerance"] = _tolerance(keep.get("tolerance", (0.1, 0.1, FREE)))
    if "box" in keep:
        fields |= _box(keep["box"])
    return PathConstraint(**fields)


def _orientation(given: object, here: Pose) -> Pose:
    if given == NOW:
        return Pose(quaternion=here.quaternion)
    if isinstance(given, str):
        raise ValueError(f"orientation is `{NOW}` or the numbers w, x, y, z, not {given!r}{nearest(given, [NOW])}")
    return Pose(quaternion=_numbers(given, 4, "orientation"))


def _tolerance(given: object) -> tuple[float, ...]:
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 3:
        raise ValueError(f"tolerance is 3 angles [rad], each a number or `{FREE}`, not {given!r}")
    return tuple(_numbers([np.inf if angle == FREE else angle for angle in given], 3, "tolerance"))


def _box(given: object) -> dict[str, Value]:
    if not isinstance(given, Mapping) or "position" not in given or "size" not in given:
        raise ValueError("box is `{position: [x, y, z], size: [x, y, z]}`: its centre and edge lengths [m]")
    _known(given, _BOX, "box")
    centre = Pose(
        _numbers(given["position"], 3, "box: position"),
        _numbers(given.get("quaternion", (1, 0, 0, 0)), 4, "box: quaternion"),
    )
    return {"box": centre, "size": tuple(_numbers(given["size"], 3, "box: size"))}


def _numbers(given: Any, count: int, name: str) -> list[float]:
    fits = isinstance(given, Sequence) and not isinstance(given, str) and len(given) == count
    if not fits or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in given):
        raise ValueError(f"{name} is {count} numbers, not {given!r}")
    return [float(x) for x in given]


def _known(given: Mapping[str, object], keys: tuple[str, ...], where: str) -> None:
    for key in given:
        if key not in keys:
            raise ValueError(f"{where} has no {key!r}{nearest(key, keys)} (available: {listing(keys)})")
