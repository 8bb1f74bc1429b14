"""Leaves that move an arm to a state or a pose, that steer it (jog, follow, hold), and that teach it names."""

from __future__ import annotations

import numpy as np

from grip_bt.base.errors import UnknownNameError, listing
from grip_bt.base.failures import NameTakenError, NotTaughtError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm
from grip_bt.base.values import JointState, PathConstraint, Pose
from grip_bt.commanders.steering import twist_towards
from grip_bt.nodes.leaf import OperationLeaf, Status
from grip_bt.nodes.motion import Resting, check_word, go, read_keep, verify_keep


class ArmLeaf(OperationLeaf):
    """A leaf with a parameter `arm`; verifies before the run that the project has it."""

    arm: Arm

    def prepare(self) -> None:
        self.arm = self.context.arm(self.params["arm"])


def expect_state(arm: Arm, name: str, path: str) -> None:
    """Raise UnknownNameError unless an arm has a named state."""
    states = arm.named_states()
    if name not in states:
        raise UnknownNameError("named state", name, states, where=path)


class KeepingLeaf(ArmLeaf):
    """A leaf whose motion may have to keep to something on its whole way."""

    def prepare(self) -> None:
        super().prepare()
        verify_keep(self, self.params["keep"])

    def constraint(self) -> PathConstraint | None:
        bound: PathConstraint | None = self.read("constraint")
        keep = self.params["keep"]
        return read_keep(keep, self.arm.grasp_pose()) if keep else bound


class MoveTo(KeepingLeaf):
    """Go to a named state of the arm."""

    def prepare(self) -> None:
        super().prepare()
        expect_state(self.arm, self.params["state"], self.path)

    def start(self) -> Operation[JointState]:
        return go(self.arm, self.params["state"], self.constraint())


class MoveToPose(KeepingLeaf):
    """Go to a pose of the hand's grasp frame."""

    def start(self) -> Operation[JointState]:
        return self.arm.plan(self.read("pose"), free=self.params["free"], constraint=self.constraint()).then(
            self.arm.execute
        )


LOOK = 0.1
"""A steered arm is sent its target again after this time [s]."""
_IDLE = 0.2


class _SteeringLeaf(ArmLeaf):
    _asked_before = False

    def initialise(self) -> None:
        self._asked_before = self.context.preempt_requested

    def steer(self) -> Operation[JointState]:
        raise NotImplementedError

    def start(self) -> Operation[JointState]:
        return self.steer()

    def update(self) -> Status:
        if self.operation is not None and not self.operation.done() and not self.operation.cancel_asked:
            self.steer()
        self.context.wake_at(self.context.clock.now() + LOOK)
        return super().update()

    def finish(self, result: JointState) -> Status:
        """Go on: it was only at rest for a moment."""
        self.operation = None
        self.context.wake()
        return self.running("moving")


class Jog(_SteeringLeaf):
    """Move the hand with a twist, for a while or until interrupted."""

    def update(self) -> Status:
        """A motion whose length is known is made in one; else go on."""
        if self.params["seconds"] is None:
            return super().update()
        return super(_SteeringLeaf, self).update()

    def start(self) -> Operation[JointState]:
        if self.params["seconds"] is None:
            return self.steer()
        return self.arm.jog(self.params["linear"], self.params["angular"], self.params["seconds"])

    def steer(self) -> Operation[JointState]:
        return self.arm.steer(self.params["linear"], self.params["angular"])

    def finish(self, result: JointState) -> Status:
        return super().finish(result) if self.params["seconds"] is None else self.end(reached=result)


class Follow(_SteeringLeaf):
    """Follow a pose that may move."""

    def update(self) -> Status:
        """At the target end, or wait for it to move; else go on towards it."""
        if (self.operation is None or not self.operation.cancel_asked) and self._at_target():
            if not self.params["keep_on"]:
                return self.end(reached=self.arm.grasp_pose())
            if self.operation is None:
                if self.context.preempt_requested and not self._asked_before:
                    return self.fail("preempted", "the task was asked to end while the arm followed a target")
                self.context.wake_at(self.context.clock.now() + _IDLE)
                return self.running("at the target")
        return super().update()

    def steer(self) -> Operation[JointState]:
        return self.arm.steer_to(self.read("pose"), self.params["speed"])

    def _at_target(self) -> bool:
        target: Pose = self.read("pose")
        linear, angular = twist_towards(self.arm.grasp_pose(), target, 1.0)
        return bool(
            np.linalg.norm(linear) <= self.params["tolerance"] and np.linalg.norm(angular) <= self.params["angle"]
        )


class Hold(ArmLeaf):
    """End a motion of the arm and hold it where it is, until it rests and for some time, or until interrupted."""

    _until: float | None = None

    def initialise(self) -> None:
        self.arm.stop()
        self._rest = Resting(self.context, self.arm.state)
        seconds: float | None = self.params["seconds"]
        self._until = None if seconds is None else self.context.clock.now() + seconds
        if self._until is not None:
            self.context.wake_at(self._until)

    def update(self) -> Status:
        if self._until is None:
            return self.running("holding")
        left, at_rest = self._until - self.context.clock.now(), self._rest.reached()
        if left > 0:
            return self.running(f"holding, {left:.1f} s left")
        return self.end() if at_rest else self.running("until the joints are measured at rest")


class ReadState(ArmLeaf):
    """Hand out the arm's measured joints."""

    def update(self) -> Status:
        return self.end(state=self.arm.state())


class ReadPose(ArmLeaf):
    """Hand out the measured pose of the hand's grasp frame."""

    def update(self) -> Status:
        return self.end(pose=self.arm.grasp_pose())


class ReadWrench(ArmLeaf):
    """Hand out what the sensor at the wrist bears."""

    def update(self) -> Status:
        zero: list[float] = self.read("zero") or [0.0] * 6
        try:
            return self.end(wrench=(self.arm.wrench() - zero).tolist())
        except SensorError as error:
            return self.fail(error.code, error.message)


class Teach(ArmLeaf):
    """Remember where the arm is now."""

    def prepare(self) -> None:
        super().prepare()
        check_word(self.params["name"], self.path)

    def update(self) -> Status:
        try:
            return self.end(value=self.arm.teach(self.params["name"], pose=self.params["pose"]))
        except NameTakenError as error:
            return self.fail(error.code, error.message)


class MoveToTaught(KeepingLeaf):
    """Go to what was taught, in this run or before."""

    def start(self) -> Operation[JointState]:
        taught, name = self.arm.taught(), self.params["name"]
        if name not in taught:
            raise NotTaughtError(
                f"nothing was taught as {name!r} (available: {listing(sorted(taught))})", taught=sorted(taught)
            )
        return go(self.arm, taught[name], self.constraint())
