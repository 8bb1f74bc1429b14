"""What hands feel in the simulated world besides how hard they press: the wrench at the wrist, and what slips."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TypeAlias

import numpy as np

from grip_bt.base.arrays import Array
from grip_sim.physics import physx, sapien
from grip_sim.specs import GRAVITY

Body: TypeAlias = "physx.PhysxRigidBodyComponent"
Link: TypeAlias = "physx.PhysxArticulationLinkComponent"


def wrist_wrench(robot: physx.PhysxArticulation, hand: Collection[Link], touching: Collection[str]) -> dict[str, Array]:
    """Return the link that a hand begins with, and what the hand bears from outside.

    That is force [N], and torque [N m] about the link's origin, in the link's axes, shape (6,).

    The hand's own weight isn't counted, as a sensor's driver is told the tool's; what accelerates the hand is. What the
    solver says that a palm passes on is off where fingers press, so it isn't asked unless something touches the palm.
    """
    links, root = list(robot.links), next(link for link in robot.links if link in hand)
    while not set(_beyond(root, links)).issuperset(hand):
        root = root.parent
    fingers = [link for link in links if link.parent == root and root.name not in touching] or [root]
    origin, passed = (root.entity_pose * root.joint.pose_in_child).p, robot.get_link_incoming_joint_forces()
    force, torque = np.zeros(3), np.zeros(3)
    for first in fingers:
        frame = (first.entity_pose * first.joint.pose_in_child).to_transformation_matrix()
        borne, turned = -np.float64(passed[links.index(first)]).reshape(2, 3) @ frame[:3, :3].T
        force, torque = force + borne, torque + turned + np.cross(frame[:3, 3] - origin, borne)
        for link in _beyond(first, links):
            weight = np.array([0.0, 0.0, link.mass * GRAVITY])
            force += weight
            torque += np.cross((link.entity_pose * link.cmass_local_pose).p - origin, weight)
    axes = root.entity_pose.to_transformation_matrix()[:3, :3]
    return {root.name: np.concatenate([force @ axes, torque @ axes])}


def _beyond(root: Link, links: Iterable[Link]) -> list[Link]:
    """Return a link and all that it carries; links are listed from the base on."""
    found = [root]
    for link in links:
        found += [link] if link.parent in found else []
    return found


class Slipping:
    """How fast what hands touch slides along their links, on the average since it was asked before.

    The way is that of a body's point at a contact in the link's frame, so what rolls doesn't slide. Velocities don't
    tell: the solver's of what stands still in a hand are up to 20 mm/s.
    """

    def __init__(self) -> None:
        self._time, self._before, self._speeds = -np.inf, dict[Body, sapien.Pose](), dict[str, float]()

    def speeds(self, time: float, contacts: Iterable[tuple[Link, Body, physx.PhysxContact]]) -> dict[str, float]:
        """Return link -> speed [m/s] at a time [s], of contacts that press; nothing when it is first asked."""
        if time == self._time:
            return self._speeds
        now, found = dict[Body, sapien.Pose](), dict[str, float]()
        for link, body, contact in contacts:
            point = max(contact.points, key=lambda point: float(np.linalg.norm(point.impulse)))
            if not np.any(point.impulse):
                continue
            now[link], now[body] = link.entity_pose, body.entity_pose
            if link in self._before and body in self._before:
                there = self._before[body] * now[body].inv() * sapien.Pose(point.position)
                way = (now[link] * self._before[link].inv() * there).p - point.position
                speed = float(np.linalg.norm(way - point.normal * (way @ point.normal))) / (time - self._time)
                found[link.entity.name] = max(found.get(link.entity.name, 0.0), speed)
        self._time, self._before, self._speeds = time, now, found
        return found
