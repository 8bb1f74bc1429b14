"""What fakes take from a robot's description: names of joints, fingers and states, but no kinematics and no shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from grip_bt.base.errors import GripError, InvalidRobotError
from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.fake import FakeArm

from .project import Project

if TYPE_CHECKING:
    from grip_bt.commanders.robots import RobotDescription

FINGERS = ("finger", "thumb")
"""Of a hand whose robot isn't known; each is one joint, 0 when open and 1 when closed."""
GRIPPED = 0.6
"""How far fingers close before they touch what is between them, of the way from `open` to `closed`."""


@dataclass(frozen=True)
class HandFacts:
    """What a fake hand has.

    Attributes:
        postures: its named postures, `open` and `closed` among them.
        fingers: finger -> its joints.
        thing: where something between the fingers stops them.
        forces: link -> force [N] while they press on it.
    """

    postures: Mapping[str, JointState]
    fingers: Mapping[str, tuple[str, ...]]
    thing: JointState
    forces: Mapping[str, float]


def description_of(project: Project) -> RobotDescription | None:
    """Return the project's robot, or None where there is none yet, or what describes it isn't installed.

    Raises:
        InvalidRobotError: its files are wrong.
    """
    try:
        return project.description()
    except InvalidRobotError:
        raise
    except (GripError, ImportError):
        return None  # a task can be tried before there is a robot


def arm_states(robot: RobotDescription | None, group: str) -> tuple[JointState | None, dict[str, JointState]]:
    """Return where a group's joints rest, and its named states.

    Each state but `home` is a place of the fake's own too, 5 cm above one another, since fakes know no kinematics.
    """
    if robot is None or group not in robot.groups:
        return None, {}
    joints, at_rest = robot.group(group), robot.at_rest
    own = JointState(joints, [at_rest[joint] for joint in joints])
    states, known = {}, robot.named_states.get(group, {})
    for number, name in enumerate(name for name in known if name != "home"):
        place = FakeArm(home=Pose((0.3, -0.4, 0.55 + 0.05 * number))).state()
        states[name] = JointState((*joints, *place.names), [*known[name].ordered(joints), *place.position])
    return own, states


def hand_facts(robot: RobotDescription | None, group: str) -> HandFacts:
    """Return what a fake of a hand has: its robot's own joints, fingers and postures, or two fingers of one joint."""
    known = {} if robot is None else robot.named_states.get(group, {})
    if robot is None or not {"open", "closed"} <= set(known):
        return _two_fingers(known)
    from grip_bt.commanders.robot_links import joints_of_fingers

    joints, fingers = robot.group(group), joints_of_fingers(robot, group)
    begin, end = (known[name].ordered(joints) for name in ("open", "closed"))
    tips = [robot.finger_links[finger][-1] for finger in fingers]
    return HandFacts(
        known, fingers, JointState(joints, begin + GRIPPED * (end - begin)), dict.fromkeys(tips or joints[-1:], 2.0)
    )


def _two_fingers(known: Mapping[str, JointState]) -> HandFacts:
    shares = dict.fromkeys(known, 0.5) | {"open": 0.0, "closed": 1.0}
    postures = {name: JointState(FINGERS, np.full(2, share)) for name, share in shares.items()}
    thing = JointState(FINGERS, np.full(2, GRIPPED))
    return HandFacts(postures, {joint: (joint,) for joint in FINGERS}, thing, {"thumb": 2.0})
