"""A state of the planning scene as a value: objects, what hands hold, and which contacts are allowed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import CellMap, Solid

ANYTHING = "*"
"""In an allowed collision, stands for every object and link."""


@dataclass(frozen=True, slots=True)
class SceneObject:
    """One object.

    Attributes:
        name: unique in its scene.
        shape: of any kind.
        pose: in world; in the hand's grasp frame when it is attached.
        hand: the hand that it moves with, or empty.
        fixed: part of the room (a table, a crate): never grasped and never removed.
    """

    name: str
    shape: Solid
    pose: Pose
    hand: str = ""
    fixed: bool = False


@dataclass(frozen=True, slots=True)
class HandMount:
    """What a hand is in the robot's model, so that what it holds can be avoided by others.

    Attributes:
        group: of the arm that it is at; what the hand holds moves with this group's grasp frame.
        links: of the hand; what it holds may touch them.
    """

    group: str
    links: frozenset[str]


@dataclass(frozen=True)
class SceneSnapshot:
    """A state of the scene.

    Attributes:
        objects: name -> object.
        allowed: sorted pairs of names (objects or links) that may touch; `ANYTHING` stands for every name.
        carriers: hand -> where it is on the robot.
    """

    objects: Mapping[str, SceneObject] = field(default_factory=dict)
    allowed: frozenset[tuple[str, str]] = frozenset()
    carriers: Mapping[str, HandMount] = field(default_factory=dict)

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
        if not self.allowed:
            return False
        pairs = ((one, other), (one, ANYTHING), (other, ANYTHING))
        return any(sorted_pair(*pair) in self.allowed for pair in pairs)

    def around(self, point: Array, within: float) -> tuple[str, ...]:
        """Return the names of objects at most `within` [m] from a point, nearest first.

        What is fixed, what a hand holds, and maps of cells, which aren't one thing, are left out.
        """
        found = []
        for item in self.objects.values():
            if item.fixed or item.hand or isinstance(item.shape, CellMap):
                continue
            local = np.abs(item.pose.rotation().T @ (point - item.pose.position) - item.shape.centre())
            distance = float(np.linalg.norm(np.maximum(local - np.array(item.shape.extents()) / 2, 0.0)))
            if distance <= within:
                found.append((distance, item.name))
        return tuple(name for _, name in sorted(found))


def sorted_pair(one: str, other: str) -> tuple[str, str]:
    """Return two names in order."""
    return (min(one, other), max(one, other))
