"""The planning scene: what motions avoid, and what moves along with a hand. Every state of it is a value.

Plans are made on a `SceneSnapshot`, so a change during planning never reaches a plan under way.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from grip_bt.errors import UnknownNameError
from grip_bt.values import Pose
from grip_bt.values.pose import check_frame


@dataclass(frozen=True, slots=True)
class Box:
    """A box, centred at its pose; `size` holds its edge lengths [m]."""

    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", _lengths("box", self.size, 3))

    def extents(self) -> tuple[float, float, float]:
        """Return the edge lengths of the bounding box along the shape's own axes [m]."""
        return self.size

    def grown(self, margin: float) -> Box:
        """Return the box with `margin` [m] more on every side; a negative one shrinks it, down to a sliver."""
        x, y, z = (max(length + 2 * margin, 1e-3) for length in self.size)
        return Box((x, y, z))


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder about its z axis, centred at its pose; lengths in m."""

    radius: float
    height: float

    def __post_init__(self) -> None:
        _lengths("cylinder", (self.radius, self.height), 2)

    def extents(self) -> tuple[float, float, float]:
        """Return the edge lengths of the bounding box along the shape's own axes [m]."""
        return (2 * self.radius, 2 * self.radius, self.height)

    def grown(self, margin: float) -> Cylinder:
        """Return the cylinder with `margin` [m] more on every side; a negative one shrinks it, down to a sliver."""
        return Cylinder(max(self.radius + margin, 5e-4), max(self.height + 2 * margin, 1e-3))


@dataclass(frozen=True, slots=True)
class SceneObject:
    """One object.

    Attributes:
        name: unique in its scene.
        shape: a box or a cylinder.
        pose: in world; in the hand's grasp frame when it is attached.
        hand: the hand that it moves with, or empty.
        fixed: part of the room (a table, a crate): never grasped and never removed.
    """

    name: str
    shape: Box | Cylinder
    pose: Pose
    hand: str = ""
    fixed: bool = False


@dataclass(frozen=True)
class SceneSnapshot:
    """A state of the scene.

    Attributes:
        objects: name -> object.
        allowed: sorted pairs of names (objects or links) that may touch.
    """

    objects: Mapping[str, SceneObject] = field(default_factory=dict)
    allowed: frozenset[tuple[str, str]] = frozenset()

    def with_object(self, item: SceneObject) -> SceneSnapshot:
        """Return the scene with an object added or replaced."""
        return replace(self, objects={**self.objects, item.name: item})

    def without(self, names: Iterable[str]) -> SceneSnapshot:
        """Return the scene without some objects."""
        gone = frozenset(names)
        return replace(self, objects={n: o for n, o in self.objects.items() if n not in gone})

    def attached(self, hand: str) -> tuple[SceneObject, ...]:
        """Return the objects that move with a hand."""
        return tuple(o for o in self.objects.values() if hand and o.hand == hand)

    def attaching(self, name: str, hand: str, grasp: Pose) -> SceneSnapshot:
        """Return the scene in which a hand whose grasp frame is at `grasp` holds the object."""
        item = self.objects[name]
        return self.with_object(replace(item, hand=hand, pose=grasp.inverse() @ item.pose))

    def may_touch(self, one: str, other: str) -> bool:
        """Tell whether a contact of two names is allowed."""
        return (min(one, other), max(one, other)) in self.allowed

    def around(self, point: NDArray[np.float64], within: float) -> tuple[str, ...]:
        """Return the names of objects at most `within` [m] from a point, nearest first; not fixed or held ones."""
        found = []
        for item in self.objects.values():
            if item.fixed or item.hand:
                continue
            local = np.abs(item.pose.rotation().T @ (point - item.pose.position))
            distance = float(np.linalg.norm(np.maximum(local - np.array(item.shape.extents()) / 2, 0.0)))
            if distance <= within:
                found.append((distance, item.name))
        return tuple(name for _, name in sorted(found))


class PlanningScene:
    """The scene of a run; implements `ports.Scene`. Safe to use from any thread.

    Args:
        hands: hand -> function that returns the measured pose of its grasp frame in world.
        fixed: name -> (edge lengths [m], pose in world) of boxes that belong to the room.
    """

    def __init__(
        self,
        hands: Mapping[str, Callable[[], Pose]],
        fixed: Mapping[str, tuple[Sequence[float], Pose]] | None = None,
    ):
        self._hands = dict(hands)
        self._lock = threading.Lock()
        objects = {
            name: SceneObject(name, Box(tuple(size)), _in_world(pose), fixed=True)  # type: ignore[arg-type]
            for name, (size, pose) in (fixed or {}).items()
        }
        self._snapshot = SceneSnapshot(objects)

    def snapshot(self) -> SceneSnapshot:
        """Return the present state."""
        return self._snapshot

    def set_box(self, name: str, size: Sequence[float], pose: Pose) -> None:
        """Add or replace a box; see `ports.Scene`."""
        self._put(SceneObject(name, Box(tuple(size)), _in_world(pose)))  # type: ignore[arg-type]

    def set_cylinder(self, name: str, radius: float, height: float, pose: Pose) -> None:
        """Add or replace a cylinder about the z axis of `pose` in world; lengths in m."""
        self._put(SceneObject(name, Cylinder(radius, height), _in_world(pose)))

    def remove(self, name: str) -> None:
        """Remove an object; nothing happens when it isn't there.

        Raises:
            ValueError: it is part of the room.
        """
        with self._lock:
            item = self._snapshot.objects.get(name)
            if item is not None and item.fixed:
                raise ValueError(f"scene object {name!r} is part of the room and stays")
            self._snapshot = self._snapshot.without([name])

    def names(self) -> tuple[str, ...]:
        """Return the names of all objects, those of the room included."""
        return tuple(self._snapshot.objects)

    def box(self, name: str) -> tuple[NDArray[np.float64], Pose]:
        """Return an object's edge lengths and its present pose in world; see `ports.Scene`."""
        item = self._object(self._snapshot, name)
        pose = self._hand(item.hand)() @ item.pose if item.hand else item.pose
        return np.array(item.shape.extents()), pose

    def attached(self, hand: str) -> tuple[str, ...]:
        """Return the names of the objects that move with the hand."""
        self._hand(hand)
        return tuple(o.name for o in self._snapshot.attached(hand))

    def attach(self, name: str, hand: str) -> None:
        """From now on the object moves with the hand and may touch it.

        Raises:
            UnknownNameError: there is no such object or hand.
            ValueError: the object is part of the room.
        """
        grasp = self._hand(hand)()
        with self._lock:
            item = self._object(self._snapshot, name)
            if item.fixed:
                raise ValueError(f"scene object {name!r} is part of the room and can't be attached")
            if item.hand != hand:
                self._snapshot = self._detached(self._snapshot, name).attaching(name, hand, grasp)

    def detach(self, name: str) -> None:
        """The object stays where it is now; nothing happens when it isn't there or isn't attached."""
        with self._lock:
            self._snapshot = self._detached(self._snapshot, name)

    def allow(self, one: str, other: str, allowed: bool = True) -> None:
        """Allow or forbid contact between two names, of objects or of links."""
        pair = (min(one, other), max(one, other))
        with self._lock:
            pairs = self._snapshot.allowed | {pair} if allowed else self._snapshot.allowed - {pair}
            self._snapshot = replace(self._snapshot, allowed=pairs)

    def _put(self, item: SceneObject) -> None:
        with self._lock:
            old = self._snapshot.objects.get(item.name)
            if old is not None and old.fixed:
                raise ValueError(f"scene object {item.name!r} is part of the room; choose another name")
            self._snapshot = self._snapshot.with_object(item)

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


def _lengths(what: str, values: Sequence[float], count: int) -> tuple[float, ...]:
    lengths = tuple(float(v) for v in values)
    if len(lengths) != count or not all(np.isfinite(v) and v > 0 for v in lengths):
        raise ValueError(f"a {what} has {count} positive lengths, not {lengths}")
    return lengths
