"""Leaves that move an arm to a state or a pose."""

from __future__ import annotations

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm
from grip_bt.base.values import JointState, PathConstraint

from .keeping import read_keep, verify_keep
from .leaf import OperationLeaf, Status
from .motion import go


class ArmLeaf(OperationLeaf):
    """A leaf with a parameter `arm`; verifies before the run that the project has it."""

    arm: Arm

    def prepare(self) -> None:
        """Look the arm up."""
        self.arm = self.context.arm(self.params["arm"])


class KeepingLeaf(ArmLeaf):
    """A leaf whose motion may have to keep to something on its whole way."""

    def prepare(self) -> None:
        """Look the arm up, and verify what is to be kept."""
        super().prepare()
        verify_keep(self, self.params["keep"])

    def constraint(self) -> PathConstraint | None:
        """Return what the motion that begins now keeps to."""
        bound: PathConstraint | None = self.read("constraint")
        keep = self.params["keep"]
        return read_keep(keep, self.arm.grasp_pose()) if keep else bound


class MoveTo(KeepingLeaf):
    """Go to a named state of the arm."""

    def prepare(self) -> None:
        """Verify that the arm has the state."""
        super().prepare()
        states = self.arm.named_states()
        if self.params["state"] not in states:
            raise UnknownNameError("named state", self.params["state"], states, where=self.path)

    def start(self) -> Operation[JointState]:
        """Plan and follow."""
        return go(self.arm, self.params["state"], self.constraint())

    def finish(self, result: JointState) -> Status:
        """Hand out what was measured."""
        return self.end(reached=result)


class MoveToPose(KeepingLeaf):
    """Go to a pose of the hand's grasp frame."""

    def start(self) -> Operation[JointState]:
        """Plan and follow."""
        return self.arm.plan(self.read("pose"), free=self.params["free"], constraint=self.constraint()).then(
            self.arm.execute
        )

    def finish(self, result: JointState) -> Status:
        """Hand out what was measured."""
        return self.end(reached=result)
