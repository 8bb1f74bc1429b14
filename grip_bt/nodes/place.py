"""The leaf that puts an object down in a target."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.errors import listing
from grip_bt.base.failures import (
    CanceledError,
    ExpectedError,
    NoGraspError,
    NoRoomError,
    NoTargetError,
    NothingHeldError,
)
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.base.values.pose import quaternion_of

from .evidence import EvidenceLimits, hand_evidence
from .grasping import ArmHandLeaf
from .motion import first_of, go, go_straight, widened
from .objects import (
    PLACED,
    TABLE_GAP,
    Disc,
    Region,
    free_name,
    free_spots,
    objects_near,
    opening_room,
    region_of,
    rename,
)

YAWS = np.radians(np.arange(0, 360, 15))
_TRIES = 4
"""Spots that are planned for, one after the other; a plan that isn't found costs seconds."""
_NARROW = 0.01
"""Distance that opening fingers keep from what was placed [m]."""
SHIFT = 0.02
"""How far what was placed may stand from where it is believed to be [m]."""


class Place(ArmHandLeaf):
    """Put down what the hand holds.

    A way to put something down is a grasp backwards: come straight from above, let go, leave straight up. So the
    candidates (free spots of the target, turned about the vertical, object upright) are `Grasp` values, and the arm
    itself says which of them it can reach free of collisions; the rest is planning and following. What was let go
    stays in the scene as `placed_*`, on the support, and the next candidates keep away from it.

    The object's size is that of the box that `arm/lift` attached; how it sits in the hand was measured at that moment.
    """

    _object: str = ""

    def start(self) -> Steps[JointState]:
        held = self.context.scene().attached(self.hand.name)
        if not held:
            raise NothingHeldError(f"the scene has nothing attached to the hand {self.hand.name!r}")
        self._object = held[0]
        region = self._region()
        candidates: list[Grasp] = yield self.context.run_in_worker(lambda: self._candidates(region))
        spot = yield from self._go(candidates)
        against = [one for one in hand_evidence(self.hand, EvidenceLimits()) if one.held is False]
        if against:
            raise NothingHeldError(f"it was lost on the way: {'; '.join(map(str, against))}")
        holding = self.hand.state()
        yield self.hand.open()
        self._let_go()
        return (yield from self._leave(spot, holding))

    def _region(self) -> Region:
        region = region_of(self.context.scene(), self.params["target"])
        if region is None and self.params["position"]:
            spot = np.array(self.params["position"], dtype=float)
            return Region(spot, spot, 0.0, 0.0)
        if region is None:
            scene, target = self.context.scene(), self.params["target"] or "<target>"
            raise NoTargetError(
                f"the scene has no region {target!r} and no boxes {target}_*; its regions: {listing(scene.regions())}; "
                f"it has {listing(scene.names(), 'nothing')}. Name a target of the world, or give a position"
            )
        return region

    def _candidates(self, region: Region) -> list[Grasp]:
        """Return ways to let go: low rather than from a height, since what falls leans or topples."""
        scene = self.context.scene()
        size, pose = scene.box(self._object)
        me = Disc.around(size, pose)
        in_hand = pose.inverse() @ self.arm.grasp_pose()
        taken = self._taken()
        if self.params["position"]:
            spots = np.array([self.params["position"]], dtype=float)
        else:
            spots = free_spots(region, me.radius, taken)
        height = region.floor + self.params["clearance"] + float(size[2]) / 2
        # On the way in the object has to pass the rim; on the way out the hand has to end above the object.
        up = max(float(size[2]) + 0.02, region.rim + 0.03 - region.floor - self.params["clearance"])
        candidates = []
        for rank, spot in enumerate(spots):
            for yaw in YAWS:
                for extra in (0.0, 0.025, 0.05):
                    hand = Pose([*spot, height + extra], quaternion_of(0, 0, yaw)) @ in_hand
                    room = opening_room(hand, taken)
                    if room > _NARROW:
                        quality = _ease(hand, spot) + 4 * min(room, 0.05) - 0.05 * rank - 20 * extra
                        above = hand.moved([0, 0, up])
                        candidates.append(Grasp(hand, above, above, quality=quality, provenance="arm/place"))
        return candidates

    def _taken(self) -> list[Disc]:
        scene = self.context.scene()
        return [Disc.around(*scene.box(n)) for n in scene.names() if n.startswith(PLACED)]

    def _go(self, candidates: list[Grasp]) -> Steps[Grasp]:
        if not candidates:
            raise NoRoomError(f"no free spot in {self.params['target'] or 'reach of the position'}")
        remaining = sorted(candidates, key=lambda c: -c.quality)
        taken = self._taken()
        roomy = [c for c in remaining if taken and opening_room(c.pose, taken) > _NARROW + SHIFT]
        spot: Grasp = yield first_of(lambda: run_steps(self._come(roomy, remaining)) for _ in range(_TRIES))
        return spot

    def _come(self, roomy: list[Grasp], remaining: list[Grasp]) -> Steps[Grasp]:
        spot = yield from self._roomy(roomy, remaining) if roomy else self._feasible(remaining)
        yield go(self.arm, spot.pre_grasp)
        yield go_straight(self.arm, [spot.pose])
        return spot

    def _roomy(self, roomy: list[Grasp], remaining: list[Grasp]) -> Steps[Grasp]:
        """Take the best candidate that is free too where what was placed stands a little beside its box.

        It may: things shift in the fingers while these close, and the camera doesn't see into the target. Where there
        is no such candidate, take the best one of those that `remaining` holds.
        """
        scene = self.context.scene()
        placed = [name for name in scene.names() if name.startswith(PLACED)]
        try:
            found: Grasp = yield widened(scene, placed, SHIFT, lambda: run_steps(self._feasible(roomy)))
        except CanceledError:
            raise
        except ExpectedError:
            roomy.clear()
            return (yield from self._feasible(remaining))
        remaining[:] = [c for c in remaining if c != found]
        return found

    def _feasible(self, remaining: list[Grasp]) -> Steps[Grasp]:
        """Take the best candidate out of `remaining` that is free both with the fingers as they hold and open."""
        holding, failed = self.hand.state(), ExpectedError("there was nothing to try")
        while remaining:
            left = len(remaining)
            try:
                spot: Grasp = yield self.arm.choose_grasp(tuple(remaining))
                remaining[:] = [c for c in remaining if c is not spot and c != spot]
                yield self.arm.choose_grasp((replace(spot, pre_posture=holding),))
                return spot
            except CanceledError:
                raise
            except ExpectedError as error:
                failed = error
            if len(remaining) == left:  # none is free with open fingers
                break
        if isinstance(failed, NoGraspError):
            raise NoRoomError("no free spot is within reach: " + failed.message, **failed.data)
        raise failed

    def _let_go(self) -> None:
        """Have what was held stand in the scene where it is now, on the support."""
        scene = self.context.scene()
        name = free_name(scene, PLACED)
        rename(scene, self._object, name)
        size, pose = scene.box(name)
        standing = self._region().floor + float(size[2]) / 2 + TABLE_GAP
        scene.set_box(name, size.tolist(), Pose([*pose.position[:2], standing], pose.quaternion))

    def _leave(self, spot: Grasp, holding: JointState) -> Steps[JointState]:
        """Go straight up; where that is blocked, a little back first; at last with the fingers half closed again.

        Open fingers may touch a wall, and nothing can be planned while they do.
        """
        scene, here = self.context.scene(), self.arm.grasp_pose()
        ignore = objects_near(scene, here)
        up = spot.post_grasp.position - spot.pose.position
        back = -here.rotation()[:, 2]
        ways = [[here.moved(up)], *([here.moved(d * back), here.moved(d * back + up)] for d in (0.03, 0.08))]

        def leave() -> Operation[JointState]:
            return first_of(partial(go_straight, self.arm, way, scene, ignore) for way in ways)

        try:
            end: JointState = yield leave()
        except CanceledError:
            raise
        except ExpectedError:
            halfway = (holding.position + self.hand.state().ordered(holding.names)) / 2
            yield self.hand.open(JointState(holding.names, halfway))
            end = yield leave()
        return end


def _ease(hand: Pose, spot: NDArray[np.float64]) -> float:
    """Return the cosine between the palm's normal and the direction from the robot's base to the spot.

    An arm reaches outward more easily than around a thing.
    """
    normal, outward = hand.rotation()[:2, 2], spot / np.linalg.norm(spot)
    return float(normal @ outward)
