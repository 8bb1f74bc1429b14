"""Leaves that make plans, also through way points, and leaves that follow them; in between, a plan is a value."""

from __future__ import annotations

from typing import Any

import numpy as np

from grip_bt.base.failures import PathInvalidError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm
from grip_bt.base.values import JointState, Plan, Pose, WayPoint
from grip_bt.commanders.joined import execute_together
from grip_bt.nodes.arm import ArmLeaf, KeepingLeaf, expect_state
from grip_bt.nodes.leaf import OperationLeaf, Status
from grip_bt.nodes.motion import expect_one, go, go_straight, read_keep, verify_keep

THERE = 0.005
"""An arm this near to the start of a trajectory [rad or m] isn't moved there first."""


class PlanTo(KeepingLeaf):
    """Plan to a named state, or to the state or pose that is bound."""

    def prepare(self) -> None:
        super().prepare()
        if self.params["state"]:
            expect_state(self.arm, self.params["state"], self.path)
        expect_one(self, "state", "goal")

    def start(self) -> Operation[Plan]:
        bound: JointState | Pose | None = self.read("goal")
        goal = self.params["state"] if bound is None else bound
        start: JointState | Pose | None = self.read("start")
        if isinstance(start, Pose):  # the joints that would bring the arm there
            return self.arm.plan(start).then(lambda way: self._plan(goal, way.trajectory.end()))
        return self._plan(goal, start)

    def _plan(self, goal: str | JointState | Pose, start: JointState | None) -> Operation[Plan]:
        return self.arm.plan(goal, start=start, free=self.params["free"], constraint=self.constraint())


class MakeConstraint(ArmLeaf):
    """Make a path constraint, to be bound by several motions."""

    def prepare(self) -> None:
        super().prepare()
        verify_keep(self, self.params["keep"])

    def update(self) -> Status:
        """Make it; `now` is how the hand is at this moment."""
        return self.end(constraint=read_keep(self.params["keep"], self.arm.grasp_pose()))


class PlanStraight(ArmLeaf):
    """Plan straight lines through poses."""

    def start(self) -> Operation[Plan]:
        return self.arm.plan_straight(self.read("poses"), start=self.read("start"))


class Execute(ArmLeaf):
    """Follow a plan."""

    def start(self) -> Operation[JointState]:
        return self.arm.execute(self.read("plan"))


class ExecuteTrajectory(ArmLeaf):
    """Follow a trajectory that was made elsewhere; one that can't be followed as a whole moves nothing."""

    def start(self) -> Operation[JointState]:
        return self.arm.plan_from_trajectory(self.read("trajectory"), slow_down=self.params["slow_down"]).then(
            self._follow
        )

    def _follow(self, plan: Plan) -> Operation[JointState]:
        if not self.params["approach"]:
            return self.arm.execute(plan)
        trajectory = plan.trajectory
        off = np.abs(self.arm.state().ordered(trajectory.names) - trajectory.positions[0]).max()
        if off <= THERE:
            return self.arm.execute(plan)
        begun = go(self.arm, JointState(trajectory.names, trajectory.positions[0]))
        return begun.then(lambda _: self.arm.execute(plan)) if trajectory.duration else begun


class ExecuteTogether(OperationLeaf):
    """Follow plans of several arms at once."""

    def prepare(self) -> None:
        names: list[str] = self.params["arms"]
        if len(set(names)) != len(names) or not names:
            raise ValueError(f"{self.path}: `arms` names each arm once, not {names}")
        self._arms: dict[str, Arm] = {name: self.context.arm(name) for name in names}

    def start(self) -> Operation[dict[str, JointState]]:
        plans: list[Plan] = self.read("plans")
        if len(plans) != len(self._arms):
            raise PathInvalidError(f"there are {len(plans)} plans for the arms {', '.join(self._arms)}")
        return execute_together(
            {name: (arm, plan) for (name, arm), plan in zip(self._arms.items(), plans, strict=True)}
        )

    def finish(self, result: dict[str, JointState]) -> Status:
        return self.end(reached=[result[name] for name in self._arms])


class MoveToJoints(KeepingLeaf):
    """Go to joint positions."""

    def start(self) -> Operation[JointState]:
        return go(self.arm, self.read("state"), self.constraint())


class MoveStraight(ArmLeaf):
    """Go straight: to a pose, or by an offset from where the hand is."""

    def prepare(self) -> None:
        super().prepare()
        offset = self.params["offset"]
        expect_one(self, "offset", "pose", "[x, y, z]")
        if offset and len(offset) != 3:
            raise ValueError(f"{self.path}: an offset is 3 lengths [m] in world, not {offset}")

    def start(self) -> Operation[JointState]:
        pose: Pose | None = self.read("pose")
        goal = self.arm.grasp_pose().moved(self.params["offset"]) if pose is None else pose
        return go_straight(self.arm, [goal], self.context.scene(), self.params["ignore"])


class _ThroughLeaf(KeepingLeaf):
    """A leaf that is given way points, as offsets or bound."""

    def prepare(self) -> None:
        super().prepare()
        offsets, radii = self.params["offsets"], self.params["radii"]
        expect_one(self, "offsets", "way_points", "[[x, y, z], ...]")
        if wrong := [offset for offset in offsets if len(offset) != 3]:
            raise ValueError(f"{self.path}: an offset is 3 lengths [m] in world, not {wrong[0]}")
        if wrong := [r for r in (self.params["radius"], *radii) if not (np.isfinite(r) and r >= 0)]:
            raise ValueError(f"{self.path}: a blend radius is a length [m], 0 or more, not {wrong[0]}")
        if offsets and radii and len(radii) != len(offsets) - 1:
            raise ValueError(f"{self.path}: {_mismatch(radii, offsets)}")

    def way_points(self) -> list[WayPoint]:
        """Return them, with their radii; PathInvalidError where none are bound, or there is another number of radii."""
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


class PlanThrough(_ThroughLeaf):
    """Plan through way points."""

    def start(self) -> Operation[Plan]:
        return self.arm.plan_through(self.way_points(), start=self.read("start"), constraint=self.constraint())

    def finish(self, result: Plan) -> Status:
        return self.end(plan=result, radii=list(result.radii))


class MoveThrough(_ThroughLeaf):
    """Go through way points."""

    def start(self) -> Operation[tuple[Plan, JointState]]:
        return self.arm.plan_through(self.way_points(), constraint=self.constraint()).then(
            lambda plan: self.arm.execute(plan).then(lambda reached: Operation.finished((plan, reached)))
        )

    def finish(self, result: tuple[Plan, JointState]) -> Status:
        plan, reached = result
        return self.end(reached=reached, radii=list(plan.radii))


def _mismatch(radii: list[float], goals: list[object]) -> str:
    return f"{len(goals)} way points have {len(goals) - 1} inner ones, and there are {len(radii)} radii"
