"""What really happened: the truth about each object, for referees and tests, never for the task under test."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from grip_bt.base.values import Pose
from grip_sim.specs import GRAVITY, ObjectSpec

if TYPE_CHECKING:  # the client imports this module, and must not import sapien
    from grip_sim.world import Contact, World

Status = Literal["held", "placed", "fallen", "standing", "lying", "elsewhere"]
STILL, STILL_TURN = 0.05, 0.6
UPRIGHT_COSINE = 0.9
BORNE = 0.05
"""What pushes an object up with more than this share of its weight bears it."""


class ObjectTruth(NamedTuple):
    """Where an object is and in which state.

    Attributes:
        status: `held`: the hand touches it and nothing else bears it; things beside it may touch it too.
            `placed`: at rest, its centre in a region that is a target. `fallen`: lower than where the world begins.
            `standing`, `lying`: at rest elsewhere. `elsewhere`: none of these.
        regions: those that its centre lies in.
        pose: of its centre, in world.
        hand_force: sum of the contact forces of the hand's links on it [N].
    """

    name: str
    status: Status
    pose: Pose
    hand_force: float
    regions: tuple[str, ...] = ()


def judge(world: World) -> tuple[ObjectTruth, ...]:
    """Return the truth about each object of a world, as it is now."""
    contacts = list(world.contacts())
    return tuple(_verdict(world, spec, [c for c in contacts if c.body == spec.name]) for spec in world.spec.objects)


def _verdict(world: World, spec: ObjectSpec, contacts: Iterable[Contact]) -> ObjectTruth:
    robot, hand_force, borne = world.robot, 0.0, 0.0
    frames = robot.description.grasp_frame, *robot.description.grasp_frames.values()
    hand = robot.hand_links.union(frame.link for frame in frames)  # a palm isn't moved by the joints of its hand
    for contact in contacts:
        if contact.other in hand:
            hand_force += contact.force
        else:
            borne += max(0.0, contact.push[2])
    resting = borne > BORNE * spec.mass * GRAVITY
    pose = world.object_pose(spec.name)
    speed, turn = world.object_speeds(spec.name)
    at_rest = speed < STILL and turn < STILL_TURN
    status: Status = "elsewhere"
    regions = [region for region in world.spec.regions if region.holds(pose.position)]
    if pose.position[2] < world.spec.fallen_below:
        status = "fallen"
    elif hand_force > 0 and not resting:
        status = "held"
    elif at_rest and not hand_force:
        upright = abs(pose.rotation()[2, 2]) > UPRIGHT_COSINE
        status = "placed" if any(region.target for region in regions) else "standing" if upright else "lying"
    names = tuple(region.name for region in regions)
    return ObjectTruth(spec.name, status, pose, float(np.round(hand_force, 6)), names)
