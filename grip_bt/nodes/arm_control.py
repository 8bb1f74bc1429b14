"""Leaves that steer an arm directly: jogging, following a moving target, holding; and reading where it is."""

from __future__ import annotations

import numpy as np

from grip_bt.commanders.jogging import twist_towards
from grip_bt.operation import Operation
from grip_bt.values import JointState, Pose

from .arm import ArmLeaf
from .leaf import Status

STEP = 0.4
"""A followed target is looked at after each step of so long [s]."""


class Jog(ArmLeaf):
    """Move the hand with a twist for a while."""

    def start(self) -> Operation[JointState]:
        """Go."""
        return self.arm.jog(self.params["linear"], self.params["angular"], self.params["seconds"])

    def finish(self, result: JointState) -> Status:
        """Hand out what was measured."""
        return self.end(reached=result)


class Follow(ArmLeaf):
    """Follow a pose that may move: each step goes straight towards where it is then."""

    _asked_before = False

    def initialise(self) -> None:
        """Note what was asked before this activation."""
        self._asked_before = self.context.preempt_requested

    def update(self) -> Status:
        """At the target end, or wait for it to move; else make a step."""
        if self.operation is None and self._at_target():
            if not self.params["keep_on"]:
                return self.end(reached=self.arm.grasp_pose())
            if self.context.preempt_requested and not self._asked_before:
                return self.fail("preempted", "the task was asked to end while the arm followed a target")
            self.context.wake_at(self.context.clock.now() + STEP / 2)
            return self.running("at the target")
        return super().update()

    def start(self) -> Operation[JointState]:
        """Make one step, no quicker than allowed."""
        linear, angular = twist_towards(self.arm.grasp_pose(), self.read("pose"), STEP)
        slower = min(1.0, self.params["speed"] / max(float(np.linalg.norm(linear)), 1e-9))
        return self.arm.jog([v * slower for v in linear], [w * slower for w in angular], STEP)

    def finish(self, result: JointState) -> Status:
        """Look again."""
        self.operation = None
        self.context.wake()
        return self.running("following")

    def _at_target(self) -> bool:
        target: Pose = self.read("pose")
        linear, angular = twist_towards(self.arm.grasp_pose(), target, 1.0)
        return bool(
            np.linalg.norm(linear) <= self.params["tolerance"] and np.linalg.norm(angular) <= self.params["angle"]
        )


class Hold(ArmLeaf):
    """End a motion of the arm and hold it where it is, for some time or until interrupted."""

    _until: float | None = None

    def initialise(self) -> None:
        """Stop."""
        self.arm.stop()
        seconds: float | None = self.params["seconds"]
        self._until = None if seconds is None else self.context.clock.now() + seconds
        if self._until is not None:
            self.context.wake_at(self._until)

    def update(self) -> Status:
        """Look at the clock."""
        if self._until is None:
            return self.running("holding")
        left = self._until - self.context.clock.now()
        return self.end() if left <= 0 else self.running(f"holding, {left:.1f} s left")


class ReadState(ArmLeaf):
    """Hand out the arm's measured joints."""

    def update(self) -> Status:
        """Measure."""
        return self.end(state=self.arm.state())


class ReadPose(ArmLeaf):
    """Hand out the measured pose of the hand's grasp frame."""

    def update(self) -> Status:
        """Measure."""
        return self.end(pose=self.arm.grasp_pose())
