"""What a planner is asked, as values that can be sent to another process, and what it answers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from grip_bt.base.operation import Operation
from grip_bt.base.ports.motion import Free
from grip_bt.base.values import Grasp, JointState, PathConstraint, Plan, Pose, Trajectory, WayPoint

from ..scene_state import SceneSnapshot
from ..settings import PlanningSettings


@dataclass(frozen=True, slots=True)
class Situation:
    """Where a plan begins.

    Attributes:
        group: the joints to move.
        start: measured positions of the robot's joints, those of the hand included.
        scene: what to avoid.
        hand: the hand at the group's end, by its name in the scene.
        settings: how to plan.
    """

    group: str
    start: JointState
    scene: SceneSnapshot
    hand: str
    settings: PlanningSettings


@dataclass(frozen=True, slots=True)
class PlanTo:
    """Plan a free path to joint positions or to a pose of the grasp frame.

    Attributes:
        situation: where it begins.
        goal: where it ends; of several poses, whichever is reached best.
        hints: for a pose: joint positions that reach it, to be tried first.
        free: for a pose: what of it doesn't matter; see `ik.Target`.
        constraint: what the whole path keeps to.
    """

    situation: Situation
    goal: JointState | Pose | tuple[Pose, ...]
    hints: tuple[JointState, ...] = ()
    free: Free = "none"
    constraint: PathConstraint | None = None


@dataclass(frozen=True, slots=True)
class PlanStraight:
    """Plan a motion of the grasp frame along straight lines through poses in world."""

    situation: Situation
    poses: tuple[Pose, ...]


@dataclass(frozen=True, slots=True)
class PlanThrough:
    """Plan one motion through way points, without a stop at those that have a blend radius.

    Attributes:
        situation: where it begins.
        way_points: one or more, without names of states.
        constraint: what the whole motion keeps to.
    """

    situation: Situation
    way_points: tuple[WayPoint, ...]
    constraint: PathConstraint | None = None


@dataclass(frozen=True, slots=True)
class PlanServoStep:
    """Plan a step of a steered motion: with a twist for a moment, and then to rest.

    Attributes:
        situation: where it begins; the velocities of `start` are those that it begins with, at rest when None.
        linear: velocity of the grasp frame's origin in world [m/s].
        angular: angular velocity in world [rad/s].
        hold: how long the twist is held [s].
    """

    situation: Situation
    linear: tuple[float, ...]
    angular: tuple[float, ...]
    hold: float


@dataclass(frozen=True, slots=True)
class CheckTrajectory:
    """Make a plan of a trajectory that is given, if it can be followed.

    Attributes:
        situation: where the joints are that it doesn't name, and what is avoided.
        trajectory: of some joints of the group.
        slow_down: whether it is made longer as a whole where it is faster than the settings say.
    """

    situation: Situation
    trajectory: Trajectory
    slow_down: bool = False


@dataclass(frozen=True, slots=True)
class ChooseGrasp:
    """Find the first feasible grasp, by falling quality."""

    situation: Situation
    grasps: tuple[Grasp, ...]


@dataclass(frozen=True, slots=True)
class CheckTogether:
    """Check that plans of different groups, begun at the same time, keep the groups apart.

    Attributes:
        situation: where the joints of no plan are, and what is avoided.
        plans: of groups without common joints.
    """

    situation: Situation
    plans: tuple[Plan, ...]


@dataclass(frozen=True, slots=True)
class ChosenGrasp:
    """A feasible grasp.

    Attributes:
        grasp: one of those that were asked about.
        at_pre_grasp: joint positions of the group where the straight approach begins.
        at_grasp: joint positions where it ends.
        reasons: how often better ones were refused, by reason.
    """

    grasp: Grasp
    at_pre_grasp: JointState
    at_grasp: JointState
    reasons: dict[str, int] = field(default_factory=dict)


Request = PlanTo | PlanStraight | PlanThrough | PlanServoStep | CheckTrajectory | ChooseGrasp | CheckTogether


class PlanningService(Protocol):
    """Answers planning requests without blocking."""

    def submit(self, request: Request) -> Operation[Plan | ChosenGrasp | None]:
        """Ask; the operation ends with the answer, or with the `ExpectedError` that says why there is none."""


Search = PlanTo | PlanStraight | ChooseGrasp
"""The requests that ask for a way or a grasp. The others are about motions that are given, and ask for no planner."""


class Searcher(Protocol):
    """Answers the requests that search for something."""

    def submit(self, request: Search) -> Operation[Plan | ChosenGrasp | None]:
        """Ask; see `PlanningService`."""
