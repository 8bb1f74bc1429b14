"""Leaves that move the fingers of a hand."""

from __future__ import annotations

from grip_bt.base.operation import Operation
from grip_bt.base.ports import Hand
from grip_bt.base.values import Grasp, JointState

from .leaf import OperationLeaf, Status


class HandLeaf(OperationLeaf):
    """A leaf with a parameter `hand`; verifies before the run that the project has it."""

    hand: Hand

    def prepare(self) -> None:
        """Look the hand up."""
        self.hand = self.context.hand(self.params["hand"])


class Open(HandLeaf):
    """Open a hand and forget what it held.

    Where a released object ends up isn't known before the next look, so its box leaves the scene instead of staying
    as an obstacle at a place where it may not be.
    """

    def start(self) -> Operation[JointState]:
        """Open to the grasp's own pre-posture or to a named one."""
        grasp: Grasp | None = self.read("grasp")
        own = None if grasp is None else grasp.pre_posture
        return self.hand.open(own if own is not None else self.params["posture"])

    def finish(self, result: JointState) -> Status:
        """Take what was held out of the scene."""
        scene = self.context.scene()
        for name in scene.attached(self.hand.name):
            scene.detach(name)
            scene.remove(name)
        return self.end()


class Close(HandLeaf):
    """Close a hand until the fingers stop; touching nothing is the failure `no_contact`."""

    def start(self) -> Operation[JointState]:
        """Close to the grasp's own posture or a named one; the parameter's torque limit wins over the grasp's."""
        grasp: Grasp | None = self.read("grasp")
        posture: JointState | str = self.params["posture"]
        limit = self.params["torque_limit"]
        if grasp is not None:
            posture = grasp.posture if grasp.posture is not None else posture
            limit = grasp.torque_limit if limit is None else limit
        return self.hand.close(posture, limit)

    def finish(self, result: JointState) -> Status:
        """Hand out what was measured."""
        return self.end(reached=result)


class ReadState(HandLeaf):
    """Hand out the hand's measured joints."""

    def update(self) -> Status:
        """Measure."""
        return self.end(state=self.hand.state())
