"""The planning scene: what motions avoid, and what moves along with a hand. Every state of it is a value.

Plans are made on a `SceneSnapshot`, so a change during planning never reaches a plan under way.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import JointState, Pose
from grip_bt.base.values.pose import check_frame
from grip_bt.base.values.solids import Box, Mesh, Solid

from .scene_file import load_scene
from .scene_state import ANYTHING, HandMount, SceneObject, SceneSnapshot, sorted_pair


class PlanningScene:
    """The scene of a run; implements `ports.Scene`. Safe to use from any thread.

    Args:
        hands: hand -> function that returns the measured pose of its grasp frame in world.
        fixed: name -> (edge lengths [m], pose in world) of boxes that belong to the room.
        room: further objects that belong to it, of any shape, such as those of a `.scene` file.
        links: name -> links that it stands for in allowed collisions: a hand's or an arm's, for instance.
        folder: that relative paths of scene and mesh files begin in.
        carriers: hand -> where it is on the robot; arms avoid what other hands hold only of these.
        robot: returns the robot's shapes, see `ports.Scene`; without it, its geometry isn't known.
        regions: name -> (edge lengths [m], pose of the middle in world) of places to aim at, which nothing bounds.
    """

    def __init__(
        self,
        hands: Mapping[str, Callable[[], Pose]],
        fixed: Mapping[str, tuple[Sequence[float], Pose]] | None = None,
        room: Iterable[SceneObject] = (),
        links: Mapping[str, Sequence[str]] | None = None,
        folder: Path | None = None,
        carriers: Mapping[str, HandMount] | None = None,
        robot: Callable[[JointState | None], Sequence[Array]] | None = None,
        regions: Mapping[str, tuple[Sequence[float], Pose]] | None = None,
    ):
        self._robot = robot
        self._regions = dict(regions or {})
        self._folder = folder or Path()
        self._hands = dict(hands)
        self._links = {name: tuple(names) for name, names in (links or {}).items()}
        self._lock = threading.Lock()
        objects = {
            name: SceneObject(name, Box(tuple(size)), _in_world(pose), fixed=True)  # type: ignore[arg-type]
            for name, (size, pose) in (fixed or {}).items()
        }
        objects |= {item.name: replace(item, pose=_in_world(item.pose), fixed=True) for item in room}
        self._snapshot = SceneSnapshot(objects, carriers=dict(carriers or {}))

    def snapshot(self) -> SceneSnapshot:
        return self._snapshot

    def restore(self, snapshot: object) -> None:
        if not isinstance(snapshot, SceneSnapshot):
            raise TypeError(
                f"a scene is restored from what `snapshot()` returned, not from a {type(snapshot).__name__}"
            )
        for item in snapshot.objects.values():
            if item.hand:
                self._hand(item.hand)
        with self._lock:
            self._snapshot = snapshot

    def robot(self, at: JointState | None = None) -> Sequence[Array]:
        return () if self._robot is None else self._robot(at)

    def regions(self) -> Mapping[str, tuple[Sequence[float], Pose]]:
        return self._regions

    def put(self, name: str, solid: Solid, pose: Pose) -> None:
        self._put(SceneObject(name, solid, _in_world(pose)))

    def load(self, file: str) -> tuple[str, ...]:
        objects = load_scene(self._folder / file)
        for item in objects:
            self._refuse_fixed(item.name)
        for item in objects:
            self._put(item)
        return tuple(item.name for item in objects)

    def mesh(self, file: str, scale: Sequence[float] = (1.0, 1.0, 1.0), hollow: bool = False) -> Mesh:
        from .kinematics.shapes import load_mesh

        x, y, z = scale
        beside = {folder.name: folder for folder in self._folder.iterdir() if folder.is_dir()}
        return load_mesh(file, (x, y, z), hollow=hollow, packages=beside, folder=self._folder)

    def solid(self, name: str) -> tuple[Solid, Pose]:
        item = self._object(self._snapshot, name)
        return item.shape, self._hand(item.hand)() @ item.pose if item.hand else item.pose

    def fixed(self, name: str) -> bool:
        item = self._snapshot.objects.get(name)
        return item is not None and item.fixed

    def set_box(self, name: str, size: Sequence[float], pose: Pose) -> None:
        self.put(name, Box(tuple(size)), pose)  # type: ignore[arg-type]

    def remove(self, name: str) -> None:
        with self._lock:
            item = self._snapshot.objects.get(name)
            if item is not None and item.fixed:
                raise ValueError(f"scene object {name!r} is a static object of the room and stays")
            self._snapshot = self._snapshot.without([name])

    def names(self) -> tuple[str, ...]:
        return tuple(self._snapshot.objects)

    def box(self, name: str) -> tuple[Array, Pose]:
        solid, pose = self.solid(name)
        return np.array(solid.extents()), pose.moved(pose.rotation() @ solid.centre())

    def attached(self, hand: str) -> tuple[str, ...]:
        self._hand(hand)
        return tuple(o.name for o in self._snapshot.attached(hand))

    def attach(self, name: str, hand: str) -> None:
        grasp = self._hand(hand)()
        with self._lock:
            item = self._object(self._snapshot, name)
            if item.fixed:
                raise ValueError(f"scene object {name!r} is a static object of the room and can't be attached")
            if item.hand != hand:
                self._snapshot = self._detached(self._snapshot, name).attaching(name, hand, grasp)

    def detach(self, name: str) -> None:
        with self._lock:
            self._snapshot = self._detached(self._snapshot, name)

    def allow(self, one: str, other: str, allowed: bool = True) -> None:
        meant = {sorted_pair(a, b) for a in self._stands_for(one) for b in self._stands_for(other)}
        with self._lock:
            pairs = self._snapshot.allowed | meant if allowed else self._snapshot.allowed - meant
            self._snapshot = replace(self._snapshot, allowed=pairs)

    def _stands_for(self, name: str) -> tuple[str, ...]:
        """Return the names that a name means: a hand's links, a link, an object, everything."""
        if name in self._links:
            return self._links[name]
        known = {ANYTHING, *self._snapshot.objects, *(link for links in self._links.values() for link in links)}
        if self._links and name not in known:
            raise UnknownNameError("object or link", name, {*known, *self._links}, where="planning scene")
        return (name,)

    def _put(self, item: SceneObject) -> None:
        with self._lock:
            self._refuse_fixed(item.name)
            self._snapshot = self._snapshot.with_object(item)

    def _refuse_fixed(self, name: str) -> None:
        if self.fixed(name):
            raise ValueError(f"scene object {name!r} is a static object of the room; choose another name")

    def _detached(self, snapshot: SceneSnapshot, name: str) -> SceneSnapshot:
        item = snapshot.objects.get(name)
        if item is None or not item.hand:
            return snapshot
        pose = self._hand(item.hand)() @ item.pose
        return snapshot.with_object(replace(item, hand="", pose=pose))

    def _hand(self, name: str) -> Callable[[], Pose]:
        if name not in self._hands:
            raise UnknownNameError("hand", name, self._hands, where="planning scene")
        return self._hands[name]

    @staticmethod
    def _object(snapshot: SceneSnapshot, name: str) -> SceneObject:
        if name not in snapshot.objects:
            raise UnknownNameError("scene object", name, snapshot.objects)
        return snapshot.objects[name]


def _in_world(pose: Pose) -> Pose:
    check_frame(pose, "world")
    return pose
