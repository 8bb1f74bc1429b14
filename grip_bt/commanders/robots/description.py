"""What a robot is, as a value: its URDF, its groups of joints, its named states and its hand's grasp frame."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any

from grip_bt.errors import UnknownNameError
from grip_bt.values import JointState, Pose

from .assembly import without_visuals


@dataclass(frozen=True, slots=True)
class Drive:
    """A joint's position drive: torque = stiffness * error - damping * velocity, clamped.

    Attributes:
        stiffness: [N m/rad].
        damping: [N m s/rad].
        limit: largest torque [N m].
        armature: rotor inertia seen at the joint [kg m^2]; light fingers need some to be stable.
    """

    stiffness: float
    damping: float
    limit: float
    armature: float = 0.0


@dataclass(frozen=True, slots=True)
class GraspFrame:
    """The frame that grasps are given in.

    Its origin lies on the palm opposite the closing point, z leaves the palm, x runs along the fingers.

    Attributes:
        link: the link that carries it.
        pose: the frame in that link.
    """

    link: str
    pose: Pose


@dataclass(frozen=True, slots=True)
class RobotDescription:
    """An arm with a hand, described for planning and for simulation.

    Attributes:
        name: the catalogue's name, such as `panda_allegro`.
        urdf: URDF text; mesh paths are absolute on this machine.
        base_link: the link that stands still; its frame is `world`.
        groups: group -> its joints, in order. `arm` and `hand` exist.
        named_states: group -> name -> state; `arm` has `home`, `hand` has `open` and `closed`.
        grasp_frame: the hand's grasp frame.
        hand_links: every link of the hand.
        finger_links: the hand's links that may touch an object while it closes, finger by finger, thumb last.
        drives: joint -> its drive.
        acceleration_limits: joint -> [rad/s^2], for timing; URDF knows only positions and velocities.
        disabled_pairs: pairs of links that the vendor declares free of collision, each sorted.
    """

    name: str
    urdf: str
    base_link: str
    groups: Mapping[str, tuple[str, ...]]
    named_states: Mapping[str, Mapping[str, JointState]]
    grasp_frame: GraspFrame
    hand_links: tuple[str, ...]
    finger_links: Mapping[str, tuple[str, ...]]
    drives: Mapping[str, Drive]
    acceleration_limits: Mapping[str, float]
    disabled_pairs: frozenset[tuple[str, str]] = field(default_factory=frozenset)

    def __post_init__(self) -> None:
        for name in ("groups", "finger_links", "drives", "acceleration_limits"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        states = {g: MappingProxyType(dict(s)) for g, s in self.named_states.items()}
        object.__setattr__(self, "named_states", MappingProxyType(states))

    def __reduce__(self) -> tuple[Any, ...]:
        """Send read-only mappings as plain ones: those can't be pickled."""
        states = {group: dict(states) for group, states in self.named_states.items()}
        values = {f.name: getattr(self, f.name) for f in fields(self)} | {"named_states": states}
        plain = (dict(v) if isinstance(v, Mapping) else v for v in values.values())
        return type(self), tuple(plain)

    @property
    def joints(self) -> tuple[str, ...]:
        """All joints of all groups."""
        return tuple(j for joints in self.groups.values() for j in joints)

    def group(self, name: str) -> tuple[str, ...]:
        """Return the joints of a group.

        Raises:
            UnknownNameError: there is no such group.
        """
        if name not in self.groups:
            raise UnknownNameError("group", name, self.groups, where=f"robot {self.name}")
        return self.groups[name]

    def named_state(self, group: str, name: str) -> JointState:
        """Return a named state of a group.

        Raises:
            UnknownNameError: there is no such group or state.
        """
        self.group(group)
        states = self.named_states.get(group, {})
        if name not in states:
            raise UnknownNameError(f"state of group {group!r}", name, states, f"robot {self.name}")
        return states[name]

    def urdf_without_visuals(self) -> str:
        """Return the URDF without `<visual>` elements, for a simulator that has no renderer."""
        return ET.tostring(without_visuals(ET.fromstring(self.urdf)), encoding="unicode")
