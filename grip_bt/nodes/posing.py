"""Leaves that make poses."""

from __future__ import annotations

from grip_bt.base.values import Pose

from .leaf import Leaf, Status


class Make(Leaf):
    """Make a pose of numbers."""

    def prepare(self) -> None:
        """Make it now, so that wrong numbers are found before the run."""
        self._pose = Pose(self.params["position"], self.params["quaternion"], self.params["frame"])

    def update(self) -> Status:
        """Hand it out."""
        return self.end(pose=self._pose)


class Offset(Leaf):
    """Move and turn a pose."""

    def prepare(self) -> None:
        """Make the way now, so that wrong numbers are found before the run."""
        self._way = Pose(self.params["position"], self.params["quaternion"])

    def update(self) -> Status:
        """Apply it."""
        pose: Pose = self.read("pose")
        turned = pose @ Pose(quaternion=self._way.quaternion)
        way = pose.rotation() @ self._way.position if self.params["own_axes"] else self._way.position
        return self.end(moved=turned.moved(way))
