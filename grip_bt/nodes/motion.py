"""Operations made of operations: what several leaves need to move an arm through a scene; and what a motion keeps to.

Tasks say it by the parameter `keep`, or by a bound `PathConstraint`:

keep: {orientation: now, tolerance: [0.1, 0.1, free]}
keep: {box: {position: [0.5, 0, 0.4], size: [0.4, 0.8, 0.3]}}
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, TypeVar

import numpy as np
from pydantic import model_validator

from grip_bt.base.failures import CanceledError, ExpectedError, NoPlanError, PathInvalidError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Context, Scene
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.types import Value
from grip_bt.base.values import JointState, PathConstraint, Pose
from grip_bt.base.values.solids import Solid
from grip_bt.base.yaml.models import Settings, check_model
from grip_bt.base.yaml.tree import from_data
from grip_bt.commanders.trajectory.limits import RestDetector

from .leaf import Leaf

T = TypeVar("T")


def go(arm: Arm, goal: JointState | Pose | str, constraint: PathConstraint | None = None) -> Operation[JointState]:
    """Plan a free path from where the arm is now, one that keeps to a constraint if there is one, and follow it."""
    return arm.plan(goal, constraint=constraint).then(arm.execute)


def go_straight(
    arm: Arm, goals: Sequence[Pose], scene: Scene | None = None, ignore: Sequence[str] = ()
) -> Operation[JointState]:
    """Move the grasp frame along straight lines through `goals`.

    The plan doesn't see the objects of the scene that `ignore` names, but for attached ones.
    """
    if scene is None:
        return arm.plan_straight(goals).then(arm.execute)
    taken = {name: scene.solid(name) for name in ignore if name in scene.names()}
    for name in taken:
        scene.remove(name)
    return _restoring(scene, taken, lambda: arm.plan_straight(goals)).then(arm.execute)


OFF = 0.01
"""How far a hand may go in contact with what it touched where it was [m]."""


def leaving(arm: Arm, goal: Pose, scene: Scene, ignore: Sequence[str] = ()) -> Steps[JointState]:
    """Go straight; where that begins in contact, as fingers that press have with a table, it may for a centimetre."""
    try:
        end: JointState = yield go_straight(arm, [goal], scene, ignore)
    except PathInvalidError as error:
        if error.data.get("fraction") != 0:
            raise
        touched, here = error.data.get("pairs", ()), arm.grasp_pose()
        way = goal.position - here.position
        for one, other in touched:
            scene.allow(one, other)
        try:
            yield go_straight(arm, [here.moved(OFF * way / np.linalg.norm(way))], scene, ignore)
        finally:
            for one, other in touched:
                scene.allow(one, other, allowed=False)
        end = yield go_straight(arm, [goal], scene, ignore)
    return end


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


def expect_one(leaf: Leaf, parameter: str, port: str, example: str = "...") -> None:
    """Raise ValueError unless either a parameter is given or an input port is bound."""
    if bool(leaf.params[parameter]) == (port in leaf.readers):
        raise ValueError(f"{leaf.path}: give either `with: {{{parameter}: {example}}}` or `in: {{{port}: ...}}`")


def check_word(name: str, path: str) -> None:
    """Raise ValueError unless a name that is taught is a word."""
    if not name.isidentifier():
        raise ValueError(f"{path}: a taught name is a word of letters, digits and _, not {name!r}")


NOW = "now"
"""The orientation that the hand has when the motion begins."""
FREE = "free"
"""A tolerance that any turn is within."""
_FORM = (
    "{orientation: now or [w, x, y, z], tolerance: [3 angles, each a number or free], axes: world or own, "
    "box: {position: [x, y, z], size: [x, y, z], quaternion: [w, x, y, z]}}"
)
_Three = tuple[float, float, float]
_Four = tuple[float, float, float, float]
_Angle = float | Literal["free"]


class _Box(Settings):
    position: _Three
    quaternion: _Four = (1.0, 0.0, 0.0, 0.0)
    size: _Three


class _Keep(Settings):
    """The parameter `keep`; `orientation` is `now`, or w x y z, `tolerance` 3 angles [rad]."""

    orientation: Literal["now"] | _Four | None = None
    tolerance: tuple[_Angle, _Angle, _Angle] = (0.1, 0.1, "free")
    axes: Literal["world", "own"] = "world"
    box: _Box | None = None

    @model_validator(mode="after")
    def _of_something(self) -> _Keep:
        if self.orientation is None and self.box is None:
            raise ValueError("it holds an `orientation`, a `box` or both")
        if self.orientation is None and not self.model_fields_set.isdisjoint(("tolerance", "axes")):
            raise ValueError("`tolerance` and `axes` belong to an `orientation`: `now`, or the numbers w, x, y, z")
        return self


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
    """Read the parameter `keep`; `here` is the pose that `now` means.

    Raises:
        ValueError: a key or a value isn't one that it has, or there is nothing to keep to.
    """
    said, faults = check_model(from_data(dict(keep)), _Keep, "keep")
    if said is None:
        raise ValueError(f"{'; '.join(message for message, _, _ in faults)} (it is {_FORM})")
    fields: dict[str, Value] = {}
    if said.orientation is not None:
        fields["orientation"] = Pose(quaternion=here.quaternion if said.orientation == NOW else said.orientation)
        fields["tolerance"] = tuple(np.inf if angle == FREE else angle for angle in said.tolerance)
        fields["axes"] = said.axes
    if said.box is not None:
        fields |= {"box": Pose(said.box.position, said.box.quaternion), "size": said.box.size}
    return PathConstraint(**fields)
