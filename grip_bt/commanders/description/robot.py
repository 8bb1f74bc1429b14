"""What a robot is, as a value: its URDF, its groups of joints, its named states and its hand's grasp frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.values import JointState, Pose

from .config import Drive

RESTING = ("home", "open", "ready", "default")
"""Names of states in which a group rests, best first."""


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
class Mimic:
    """A joint that follows another one: position = multiplier * the other's + offset.

    Attributes:
        joint: the one that leads.
        multiplier: [rad/rad], or m where one of them slides.
        offset: [rad or m].
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Preference:
    """What a robot's files prefer for a field of an arm.

    Attributes:
        value: a planner's or a solver's name, or a factor; None where what they ask for isn't there.
        source: the file that says so.
        unknown: what it asks for, where that isn't there.
    """

    value: str | float | None
    source: str
    unknown: str = ""


@dataclass(frozen=True, slots=True)
class EndEffector:
    """What an arm's group carries.

    Attributes:
        name: as the SRDF calls it.
        group: group of the hand's joints; empty for a bare tool.
        parent_link: the arm's link that it sits on.
        parent_group: group of the arm.
    """

    name: str
    group: str
    parent_link: str
    parent_group: str


@dataclass(frozen=True, slots=True)
class RobotDescription:
    """Arms and hands, described for planning and for simulation.

    Attributes:
        name: the catalogue's name, such as `panda_allegro`.
        urdf: URDF text; mesh paths are absolute on this machine.
        base_link: the link that stands still; its frame is `world`.
        groups: group -> its joints, in order. Groups may overlap, as one of two arms does.
        named_states: group -> name -> state.
        grasp_frame: the grasp frame of the hand, or of the first arm where there are several.
        finger_links: the hands' links that may touch an object while they close, finger by finger, thumb last.
        drives: joint -> its drive.
        acceleration_limits: joint -> [rad/s^2 or m/s^2], for timing; URDF knows only positions and velocities.
        disabled_pairs: pairs of links that the vendor declares free of collision, each sorted.
        grasp_frames: arm's group -> its grasp frame, where there are several arms.
        hands: hand's group -> its links.
        mimics: joint that follows another one -> whom and how. It belongs to no group.
        rest: joint -> where it is unless told otherwise [rad or m]; joints that it lacks rest as `at_rest` says.
        end_effectors: which hand sits on which arm.
        preferences: group -> field of an arm, such as `planner` -> what the robot's files prefer.
        jerk_limits: joint -> [rad/s^3 or m/s^3], for timing; of joints whose limit isn't known, nothing.
    """

    name: str
    urdf: str
    base_link: str
    groups: Mapping[str, tuple[str, ...]]
    named_states: Mapping[str, Mapping[str, JointState]]
    grasp_frame: GraspFrame
    finger_links: Mapping[str, tuple[str, ...]]
    drives: Mapping[str, Drive]
    acceleration_limits: Mapping[str, float]
    disabled_pairs: frozenset[tuple[str, str]] = field(default_factory=frozenset)
    grasp_frames: Mapping[str, GraspFrame] = field(default_factory=dict)
    hands: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    mimics: Mapping[str, Mimic] = field(default_factory=dict)
    rest: Mapping[str, float] = field(default_factory=dict)
    end_effectors: tuple[EndEffector, ...] = ()
    preferences: Mapping[str, Mapping[str, Preference]] = field(default_factory=dict)
    jerk_limits: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for f in fields(self):
            object.__setattr__(self, f.name, _read_only(getattr(self, f.name)))

    @property
    def joints(self) -> tuple[str, ...]:
        """All joints of all groups, each once."""
        return tuple(dict.fromkeys(j for joints in self.groups.values() for j in joints))

    @property
    def hand_links(self) -> tuple[str, ...]:
        """Every link of every hand."""
        return tuple(dict.fromkeys(link for links in self.hands.values() for link in links))

    @property
    def at_rest(self) -> dict[str, float]:
        """Where joints begin [rad or m]: by `rest`, else any group's `home`, else the next of `RESTING`."""
        positions: dict[str, float] = {}
        for name in RESTING:
            for states in self.named_states.values():
                positions = (states[name].as_mapping() if name in states else {}) | positions
        return positions | dict(self.rest)

    def opened(self, arm: str) -> JointState:
        """Return the state `open` of the hands that an arm's group carries; no joints where it has none."""
        mine = set(self.groups.get(arm, ()))
        carried = [e.group for e in self.end_effectors if e.group and mine & set(self.groups.get(e.parent_group, ()))]
        if not self.end_effectors:
            carried = list(self.hands)
        states = [self.named_states[hand]["open"] for hand in carried if "open" in self.named_states.get(hand, {})]
        positions = {joint: q for state in states for joint, q in state.as_mapping().items()}
        return JointState(tuple(positions), tuple(positions.values()))

    def group(self, name: str) -> tuple[str, ...]:
        """Return the joints of a group. Raises UnknownNameError: there is no such group."""
        if name not in self.groups:
            raise UnknownNameError("group", name, self.groups, where=f"robot {self.name}")
        return self.groups[name]

    def named_state(self, group: str, name: str) -> JointState:
        """Return a named state of a group. Raises UnknownNameError: there is no such group or state."""
        self.group(group)
        states = self.named_states.get(group, {})
        if name not in states:
            raise UnknownNameError(f"state of group {group!r}", name, states, f"robot {self.name}")
        return states[name]

    def with_followers(self, positions: Mapping[str, float]) -> dict[str, float]:
        """Return positions [rad or m], and where joints are then that follow others; what isn't named is at 0."""
        followed = {name: m.multiplier * positions.get(m.joint, 0.0) + m.offset for name, m in self.mimics.items()}
        return {**positions, **followed}


def _read_only(value: object) -> object:
    return FrozenDict({k: _read_only(v) for k, v in value.items()}) if isinstance(value, Mapping) else value
