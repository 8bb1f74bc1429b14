"""Leaves that move an arm through way points as one motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from grip_bt.base.failures import PathInvalidError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Plan, Pose, WayPoint

from .arm import KeepingLeaf
from .leaf import Status


@dataclass(frozen=True, slots=True)
class Passed:
    """What came of a motion: the plan, and what was measured at its end."""

    plan: Plan
    reached: JointState


class ThroughLeaf(KeepingLeaf):
    """A leaf that is given way points, as offsets or bound."""

    def prepare(self) -> None:
        """Verify that there is one list of way points, and that the radii are lengths."""
        super().prepare()
        offsets, radii = self.params["offsets"], self.params["radii"]
        if bool(offsets) == ("way_points" in self.readers):
            raise ValueError(
                f"{self.path}: give either `with: {{offsets: [[x, y, z], ...]}}` or `in: {{way_points: ...}}`"
            )
        if wrong := [offset for offset in offsets if len(offset) != 3]:
            raise ValueError(f"{self.path}: an offset is 3 lengths [m] in world, not {wrong[0]}")
        if wrong := [r for r in (self.params["radius"], *radii) if not (np.isfinite(r) and r >= 0)]:
            raise ValueError(f"{self.path}: a blend radius is a length [m], 0 or more, not {wrong[0]}")
        if offsets and radii and len(radii) != len(offsets) - 1:
            raise ValueError(f"{self.path}: {_mismatch(radii, offsets)}")

    def way_points(self) -> list[WayPoint]:
        """Return them, with their radii.

        Raises:
            PathInvalidError: none are bound, or there is another number of radii.
        """
        here = self.arm.grasp_pose() if self.params["offsets"] else Pose()
        goals: list[Any] = [here.moved(offset) for offset in self.params["offsets"]] or self.read("way_points")
        radii: list[float] = self.params["radii"] or [self.params["radius"]] * (len(goals) - 1)
        if not goals:
            raise PathInvalidError("there are no way points to go through")
        if len(radii) != len(goals) - 1:
            raise PathInvalidError(_mismatch(radii, goals))
        straight = self.params["straight"]
        return [
            goal if isinstance(goal, WayPoint) else WayPoint(goal, radius, straight)
            for goal, radius in zip(goals, [*radii, 0.0], strict=True)
        ]


class PlanThrough(ThroughLeaf):
    """Plan through way points."""

    def start(self) -> Operation[Plan]:
        """Ask."""
        return self.arm.plan_through(self.way_points(), start=self.read("start"), constraint=self.constraint())

    def finish(self, result: Plan) -> Status:
        """Hand the plan out, and its radii."""
        return self.end(plan=result, radii=list(result.radii))


class MoveThrough(ThroughLeaf):
    """Go through way points."""

    def start(self) -> Operation[Passed]:
        """Plan and follow."""
        return self.arm.plan_through(self.way_points(), constraint=self.constraint()).then(
            lambda plan: self.arm.execute(plan).then(lambda reached: Operation.finished(Passed(plan, reached)))
        )

    def finish(self, result: Passed) -> Status:
        """Hand out what was measured, and the plan's radii."""
        return self.end(reached=result.reached, radii=list(result.plan.radii))


def _mismatch(radii: list[float], goals: list[Any]) -> str:
    return f"{len(goals)} way points have {len(goals) - 1} inner ones, and there are {len(radii)} radii"
