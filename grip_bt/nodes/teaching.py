"""Leaves that remember where an arm or a hand is, and go there again."""

from __future__ import annotations

from grip_bt.base.errors import listing
from grip_bt.base.failures import NameTakenError, NotTaughtError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState

from .arm import ArmLeaf, KeepingLeaf
from .hand import HandLeaf
from .leaf import Status
from .motion import go


class Teach(ArmLeaf):
    """Remember where the arm is now."""

    def prepare(self) -> None:
        super().prepare()
        _check_word(self.params["name"], self.path)

    def update(self) -> Status:
        try:
            return self.end(value=self.arm.teach(self.params["name"], pose=self.params["pose"]))
        except NameTakenError as error:
            return self.fail(error.code, error.message)


class MoveToTaught(KeepingLeaf):
    """Go to what was taught, in this run or before."""

    def start(self) -> Operation[JointState]:
        """Plan and follow.

        Raises:
            NotTaughtError: nothing has this name.
        """
        taught, name = self.arm.taught(), self.params["name"]
        if name not in taught:
            raise NotTaughtError(
                f"nothing was taught as {name!r} (available: {listing(sorted(taught))})", taught=sorted(taught)
            )
        return go(self.arm, taught[name], self.constraint())


class TeachHand(HandLeaf):
    """Remember the fingers' posture."""

    def prepare(self) -> None:
        super().prepare()
        _check_word(self.params["name"], self.path)

    def update(self) -> Status:
        try:
            return self.end(value=self.hand.teach(self.params["name"]))
        except NameTakenError as error:
            return self.fail(error.code, error.message)


def _check_word(name: str, path: str) -> None:
    if not name.isidentifier():
        raise ValueError(f"{path}: a taught name is a word of letters, digits and _, not {name!r}")
