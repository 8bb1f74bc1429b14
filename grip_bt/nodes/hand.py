"""Leaves that move the fingers of a hand, to postures or by synergies, and that watch what it touches."""

from __future__ import annotations

from grip_bt.base.errors import listing
from grip_bt.base.failures import NameTakenError, NotTaughtError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Hand
from grip_bt.base.values import Grasp, JointState
from grip_bt.nodes.leaf import OperationLeaf, Status
from grip_bt.nodes.motion import Resting, check_word, expect_one


class HandLeaf(OperationLeaf):
    """A leaf with a parameter `hand`; verifies before the run that the project has it."""

    hand: Hand

    def prepare(self) -> None:
        self.hand = self.context.hand(self.params["hand"])


class Open(HandLeaf):
    """Open a hand and forget what it held.

    Where a released object ends up isn't known before the next look, so its box leaves the scene instead of staying
    as an obstacle at a place where it may not be.
    """

    def start(self) -> Operation[JointState]:
        grasp: Grasp | None = self.read("grasp")
        own = None if grasp is None else grasp.pre_posture
        return self.hand.open(own if own is not None else self.params["posture"])

    def finish(self, result: JointState) -> Status:
        scene = self.context.scene()
        for name in scene.attached(self.hand.name):
            scene.detach(name)
            scene.remove(name)
        return self.end()


class Close(HandLeaf):
    """Close a hand until the fingers stop; touching nothing is the failure `no_contact`."""

    def start(self) -> Operation[JointState]:
        """Close to the grasp's own posture or a named one; torque limit and force win over the grasp's limit."""
        grasp: Grasp | None = self.read("grasp")
        posture: JointState | str = self.params["posture"]
        limit, force = self.params["torque_limit"], self.params["force"]
        if grasp is not None:
            posture = grasp.posture if grasp.posture is not None else posture
            limit = grasp.torque_limit if limit is None and force is None else limit
        return self.hand.close(posture, limit, force)


class ReadState(HandLeaf):
    """Hand out the hand's measured joints, and how hard its links press."""

    def update(self) -> Status:
        asked = not self.writers.keys().isdisjoint(("forces", "pressing"))
        forces = dict(self.hand.contacts()) if asked else {}
        return self.end(state=self.hand.state(), forces=forces, pressing=sum(forces.values()) / 2)


class _MovingHandLeaf(HandLeaf):
    _posture: JointState

    def start(self) -> Operation[JointState]:
        return self.move(self._posture)

    def move(self, posture: JointState | str) -> Operation[JointState]:
        return self.hand.move(posture, self.params["torque_limit"], self.params["seconds"])


class Posture(_MovingHandLeaf):
    """Go to a posture, named or bound."""

    def prepare(self) -> None:
        super().prepare()
        expect_one(self, "posture", "state")

    def start(self) -> Operation[JointState]:
        """Go; the name is looked up now, since it may have been taught meanwhile.

        Raises:
            NotTaughtError: the hand has no posture of this name.
        """
        bound: JointState | None = self.read("state")
        known, name = self.hand.named_states(), self.params["posture"]
        if bound is None and name not in known:
            raise NotTaughtError(
                f"the hand has no posture {name!r} (available: {listing(sorted(known))})", taught=sorted(known)
            )
        return self.move(name if bound is None else bound)


class Fingers(_MovingHandLeaf):
    """Close some fingers in part."""

    def prepare(self) -> None:
        super().prepare()
        self._posture = self.hand.finger_posture(self.params["closing"])


class Fingertips(_MovingHandLeaf):
    """Bring fingertips to positions."""

    def prepare(self) -> None:
        super().prepare()
        expect_one(self, "tips", "targets")

    def start(self) -> Operation[JointState]:
        targets = self.read("targets") or self.params["tips"]
        found = self.context.run_in_worker(lambda: self.hand.fingertip_posture(targets, self.params["frame"]))
        return found.then(self.move)


class Synergy(_MovingHandLeaf):
    """Go to the posture of synergies."""

    def prepare(self) -> None:
        super().prepare()
        self._posture = self.hand.synergy(self.params["weights"])


class HoldHand(HandLeaf):
    """End a motion of the fingers and hold them where they are; it ends when they were measured at rest."""

    def initialise(self) -> None:
        self.hand.stop()
        self._rest = Resting(self.context, self.hand.state)

    def update(self) -> Status:
        return self.end() if self._rest.reached() else self.running("until the fingers are measured at rest")


class HasContact(HandLeaf):
    """Succeed when enough links of the hand touch something now."""

    def update(self) -> Status:
        force = self.params["force"]
        links = sorted(link for link, pressed in self.hand.contacts().items() if pressed >= force)
        if len(links) >= self.params["links"]:
            return self.end(links=links)
        return self.fail("no_contact", f"{len(links)} links touch something: {listing(links)}", links=links)


class KeepContact(HandLeaf):
    """Watch over a grasp: run while enough links touch something, and fail when they have ceased to.

    A contact that is away for a moment, as in a jerk, counts as kept.
    """

    _lost_since: float | None = None

    def initialise(self) -> None:
        self._lost_since = None

    def update(self) -> Status:
        now, force = self.context.clock.now(), self.params["force"]
        links = sorted(link for link, pressed in self.hand.contacts().items() if pressed >= force)
        self.context.wake_at(now + self.params["patience"] / 2)
        if len(links) >= self.params["links"]:
            self._lost_since = None
            return self.running(f"{len(links)} links touch")
        if self._lost_since is None:
            self._lost_since = now
        if now - self._lost_since < self.params["patience"]:
            return self.running("contact is lost")
        return self.fail("lost_contact", f"{len(links)} links touch something: {listing(links)}", links=links)


LOOK = 0.02
"""How often it is asked whether something slips [s]."""


class WatchSlip(HandLeaf):
    """Watch over a grasp: run while nothing slides along the hand's links, for some time or until interrupted."""

    def initialise(self) -> None:
        self._begun = self.context.clock.now()

    def update(self) -> Status:
        try:
            speeds = dict(self.hand.slips())
        except SensorError as error:
            return self.fail(error.code, error.message)
        slipping = sorted(link for link, speed in speeds.items() if speed >= self.params["speed"])
        if slipping:
            fastest = 1000 * max(speeds.values())
            said = f"at {fastest:.0f} mm/s along {listing(slipping)}"
            return self.fail("slipped", said, outputs={"speeds": speeds}, links=slipping)
        now, seconds = self.context.clock.now(), self.params["seconds"]
        if seconds is not None and now >= self._begun + seconds:
            return self.end(speeds=speeds)
        self.context.wake_at(now + LOOK)
        return self.running("nothing slips")


class TeachHand(HandLeaf):
    """Remember the fingers' posture."""

    def prepare(self) -> None:
        super().prepare()
        check_word(self.params["name"], self.path)

    def update(self) -> Status:
        try:
            return self.end(value=self.hand.teach(self.params["name"]))
        except NameTakenError as error:
            return self.fail(error.code, error.message)
