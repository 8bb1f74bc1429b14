"""The leaf that puts an object down in a target."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.errors import listing
from grip_bt.base.failures import ExpectedError, NoGraspError, NoRoomError, NoTargetError, NothingHeldError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.nodes.objects import Disc, free_spots, opening_room, turned

from .evidence import EvidenceLimits, hand_evidence
from .grasping import ArmHandLeaf
from .motion import first_of, go, go_straight, tolerant, widened
from .objects import PLACED, TABLE_GAP, Region, free_name, objects_near, region_of, rename

YAWS = np.radians(np.arange(0, 360, 15))
_TRIES = 4
"""So many spots are planned for, one after the other; a plan that isn't found costs seconds."""
_NARROW = 0.01
"""Opening fingers stay so far from what was placed [m]."""
SHIFT = 0.02
"""What was placed may stand so far from where it is thought to [m]."""


class Place(ArmHandLeaf):
    """Put down what the hand holds.

    A way to put something down is a grasp backwards: come straight from above, let go, leave straight up. So the
    candidates (free spots of the target, turned about the vertical, object upright) are `Grasp` values, and the arm
    itself says which of them it can reach free of collisions; the rest is planning and following. What was let go
    stays in the scene as `placed_*`, on the support, and the next candidates keep away from it.

    The object's size is that of the box that `arm/lift` attached; how it sits in the hand was measured at that moment.
    """

    _object: str = ""

    def start(self) -> Operation[JointState]:
        scene = self.context.scene()
        held = scene.attached(self.hand.name)
        if not held:
            raise NothingHeldError(f"the scene has nothing attached to the hand {self.hand.name!r}")
        self._object = held[0]
        region = self._region()
        return (
            self.context.run_in_worker(lambda: self._candidates(region))
            .then(self._go)
            .then(self._verify)
            .then(self._release)
        )

    # --- where ---

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
                    hand = Pose([*spot, height + extra], turned(yaw)) @ in_hand
                    room = opening_room(hand, taken)
                    if room > _NARROW:
                        quality = _ease(hand, spot) + 4 * min(room, 0.05) - 0.05 * rank - 20 * extra
                        above = hand.moved([0, 0, up])
                        candidates.append(Grasp(hand, above, above, quality=quality, provenance="arm/place"))
        return candidates

    def _taken(self) -> list[Disc]:
        scene = self.context.scene()
        return [Disc.around(*scene.box(n)) for n in scene.names() if n.startswith(PLACED)]

    # --- how ---

    def _go(self, candidates: list[Grasp]) -> Operation[Grasp]:
        if not candidates:
            raise NoRoomError(f"no free spot in {self.params['target'] or 'reach of the position'}")
        remaining = sorted(candidates, key=lambda c: -c.quality)
        taken = self._taken()
        roomy = [c for c in remaining if taken and opening_room(c.pose, taken) > _NARROW + SHIFT]
        ways = (
            lambda: (self._roomy(roomy, remaining) if roomy else self._feasible(remaining)).then(self._come)
            for _ in range(_TRIES)
        )
        return first_of(ways)

    def _roomy(self, roomy: list[Grasp], remaining: list[Grasp]) -> Operation[Grasp]:
        """Take the best candidate that is free too where what was placed stands a little beside its box.

        It may: things shift in the fingers while these close, and the camera doesn't see into the target. Where there
        is no such candidate, take the best one of those that `remaining` holds.
        """
        scene = self.context.scene()
        placed = [name for name in scene.names() if name.startswith(PLACED)]
        found = tolerant(widened(scene, placed, SHIFT, lambda: self._feasible(roomy)))

        def settle(result: Grasp | ExpectedError) -> Operation[Grasp]:
            if isinstance(result, ExpectedError):
                roomy.clear()
                return self._feasible(remaining)
            remaining[:] = [c for c in remaining if c != result]
            return Operation.finished(result)

        return found.then(settle)

    def _feasible(self, remaining: list[Grasp]) -> Operation[Grasp]:
        """Take the best candidate out of `remaining` that is free both with the fingers as they hold and open."""
        holding = self.hand.state()

        def with_fingers_as_they_hold(spot: Grasp) -> Operation[Grasp]:
            remaining[:] = [c for c in remaining if c is not spot and c != spot]
            closed = self.arm.choose_grasp((replace(spot, pre_posture=holding),))
            return closed.then(lambda _: Operation.finished(spot))

        def attempts() -> Iterator[Callable[[], Operation[Grasp]]]:
            while remaining:
                left = len(remaining)
                yield lambda: self.arm.choose_grasp(tuple(remaining)).then(with_fingers_as_they_hold)
                if len(remaining) == left:  # none is free with open fingers
                    return

        return _no_room(first_of(attempts()))

    def _come(self, spot: Grasp) -> Operation[Grasp]:
        there = go(self.arm, spot.pre_grasp).then(lambda _: go_straight(self.arm, [spot.pose]))
        return there.then(lambda _: Operation.finished(spot))

    def _verify(self, spot: Grasp) -> Operation[Grasp]:
        """Ask the hand, before it lets go, whether it still holds what it is to put down."""
        against = [one for one in hand_evidence(self.hand, EvidenceLimits()) if one.held is False]
        if against:
            raise NothingHeldError(f"it was lost on the way: {'; '.join(map(str, against))}")
        return Operation.finished(spot)

    def _release(self, spot: Grasp) -> Operation[JointState]:
        holding = self.hand.state()

        def let_go(_: JointState) -> Operation[JointState]:
            scene = self.context.scene()
            name = free_name(scene, PLACED)
            rename(scene, self._object, name)
            size, pose = scene.box(name)
            region = self._region()
            standing = region.floor + float(size[2]) / 2 + TABLE_GAP
            scene.set_box(name, size.tolist(), Pose([*pose.position[:2], standing], pose.quaternion))
            return self._leave(spot, holding)

        return self.hand.open().then(let_go)

    def _leave(self, spot: Grasp, holding: JointState) -> Operation[JointState]:
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

        def leave_half_closed() -> Operation[JointState]:
            halfway = (holding.position + self.hand.state().ordered(holding.names)) / 2
            return self.hand.open(JointState(holding.names, halfway)).then(lambda _: leave())

        return first_of([leave, leave_half_closed])


def _ease(hand: Pose, spot: NDArray[np.float64]) -> float:
    """Return the cosine between the palm's normal and the direction from the robot's base to the spot.

    An arm reaches outward more easily than around a thing.
    """
    normal, outward = hand.rotation()[:2, 2], spot / np.linalg.norm(spot)
    return float(normal @ outward)


def _no_room(choice: Operation[Grasp]) -> Operation[Grasp]:
    """Say in terms of spots that no candidate is feasible."""

    def translate(result: Grasp | ExpectedError) -> Operation[Grasp]:
        if isinstance(result, NoGraspError):
            return Operation.failed(NoRoomError("no free spot is within reach: " + result.message, **result.data))
        if isinstance(result, ExpectedError):
            return Operation.failed(result)
        return Operation.finished(result)

    return tolerant(choice).then(translate)
