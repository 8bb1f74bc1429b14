"""Leaves that move an arm to a state or a pose."""

from __future__ import annotations

from grip_bt.errors import UnknownNameError
from grip_bt.operation import Operation
from grip_bt.ports import Arm
from grip_bt.values import JointState

from .leaf import OperationLeaf, Status
from .motion import go


class ArmLeaf(OperationLeaf):
    """A leaf with a parameter `arm`; verifies before the run that the project has it."""

    arm: Arm

    def prepare(self) -> None:
        """Look the arm up."""
        self.arm = self.context.arm(self.params["arm"])


class MoveTo(ArmLeaf):
    """Go to a named state of the arm."""

    def prepare(self) -> None:
        """Verify that the arm has the state."""
        super().prepare()
        states = self.arm.named_states()
        if self.params["state"] not in states:
            raise UnknownNameError("named state", self.params["state"], states, where=self.path)

    def start(self) -> Operation[JointState]:
        """Plan and follow."""
        return go(self.arm, self.params["state"])

    def finish(self, result: JointState) -> Status:
        """Hand out what was measured."""
        return self.end(reached=result)


class MoveToPose(ArmLeaf):
    """Go to a pose of the hand's grasp frame."""

    def start(self) -> Operation[JointState]:
        """Plan and follow."""
        return self.arm.plan(self.read("pose"), free=self.params["free"]).then(self.arm.execute)

    def finish(self, result: JointState) -> Status:
        """Hand out what was measured."""
        return self.end(reached=result)
