"""What really happened: the truth about each object, for referees and tests, never for the task under test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from grip_bt.values import Pose

from .specs import ObjectSpec

if TYPE_CHECKING:  # the client imports this module, and must not import sapien
    from .world import World

Status = Literal["held", "placed", "fallen", "standing", "lying", "elsewhere"]
LOW, STILL, STILL_TURN, BELOW = 0.14, 0.05, 0.6, -0.05
UPRIGHT_COSINE = 0.9


@dataclass(frozen=True, slots=True)
class ObjectTruth:
    """Where an object is and in which state.

    Attributes:
        name: the object. status: `held`: touched by the hand and by nothing that never moves. `placed`: at rest and
        low with its centre within the
            crate's walls. `fallen`: below the table's top. `standing`, `lying`: at rest on the table. `elsewhere`:
            none of these.
        pose: of its centre, in world.
        hand_force: sum of the contact forces of the hand's links on it [N].
    """

    name: str
    status: Status
    pose: Pose
    hand_force: float

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON data."""
        place = {"position": self.pose.position.tolist(), "quaternion": self.pose.quaternion.tolist()}
        return {"name": self.name, "status": self.status, "hand_force": self.hand_force, **place}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> ObjectTruth:
        """Return what `to_json` wrote."""
        pose = Pose(data["position"], data["quaternion"])
        return cls(data["name"], data["status"], pose, data["hand_force"])


def judge(world: World) -> tuple[ObjectTruth, ...]:
    """Return the truth about each object of a world, as it is now."""
    contacts = list(world.contacts())
    still = {box.name for box in world.spec.boxes()}
    verdicts = []
    for spec in world.spec.objects:
        touching: dict[str, float] = {}
        for one, two, force in contacts:
            if spec.name in (one, two):
                other = two if one == spec.name else one
                touching[other] = touching.get(other, 0.0) + force
        hand = sum(f for link, f in touching.items() if link in world.robot.hand_links)
        resting = not still.isdisjoint(touching)
        verdicts.append(_verdict(world, spec, hand, resting))
    return tuple(verdicts)


def _verdict(world: World, spec: ObjectSpec, hand_force: float, resting: bool) -> ObjectTruth:
    pose = world.object_pose(spec.name)
    speed, turn = world.object_speeds(spec.name)
    at_rest = speed < STILL and turn < STILL_TURN
    status: Status = "elsewhere"
    if pose.position[2] < BELOW:
        status = "fallen"
    elif hand_force > 0 and not resting:
        status = "held"
    elif at_rest and not hand_force and pose.position[2] < LOW:
        if world.spec.crate.holds(tuple(pose.position)):
            status = "placed"
        else:
            upright = abs(pose.rotation()[2, 2]) > UPRIGHT_COSINE
            status = "standing" if upright else "lying"
    return ObjectTruth(spec.name, status, pose, float(np.round(hand_force, 6)))
