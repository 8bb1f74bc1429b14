"""Errors of robots, and the failures that a task should expect of arms, hands, planners and sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .base import ExpectedError, GripError


class UnfitSolverError(GripError):
    """A kinematics solver that was asked for by name doesn't take this arm."""


class InvalidRobotError(GripError):
    """A robot's files are wrong; `findings` holds every error that was found, with its place."""

    def __init__(self, name: str, findings: Sequence[Any]):
        self.name, self.findings = name, tuple(findings)
        listed = "".join(f"\n  {finding}" for finding in self.findings)
        super().__init__(f"robot {name} can't be used; `grip robot check` tells all about it:{listed}")


class NoIkError(ExpectedError):
    """No joint positions reach the wanted pose."""

    code = "no_ik"


class OutOfLimitsError(ExpectedError):
    """Joints would be outside their limits, of positions or on the way; `data['joints']` names the joints."""

    code = "out_of_limits"


class StartInCollisionError(ExpectedError):
    """The robot is in collision before it moves; `data['pairs']` names what touches."""

    code = "start_in_collision"


class GoalInCollisionError(ExpectedError):
    """The goal is in collision; `data['pairs']` names what touches."""

    code = "goal_in_collision"


class NoPlanError(ExpectedError):
    """The planner found no path."""

    code = "no_plan"


class PathInvalidError(ExpectedError):
    """A path collides, jumps or breaks limits, for instance after timing."""

    code = "path_invalid"


class ConstraintBrokenError(ExpectedError):
    """The start or the goal of a motion breaks what its whole path must keep to."""

    code = "constraint_broken"


class PlannerLostError(ExpectedError):
    """The planning process died twice over one request."""

    code = "planner_lost"


class ExecutionAbortedError(ExpectedError):
    """The robot didn't reach the end of the motion."""

    code = "aborted"


class NoGraspError(ExpectedError):
    """No grasp candidate is feasible."""

    code = "no_grasp"


class NoContactError(ExpectedError):
    """The hand closed without touching anything."""

    code = "no_contact"


class LostContactError(ExpectedError):
    """A hand has lost what it held."""

    code = "lost_contact"


class NothingHeldError(ExpectedError):
    """A hand was asked to put down what it doesn't hold."""

    code = "nothing_held"


class NoObjectError(ExpectedError):
    """The planning scene doesn't have the object that was named; `data['objects']` lists what it has."""

    code = "no_object"


class NoTargetError(ExpectedError):
    """The planning scene doesn't have the target that was named."""

    code = "no_target"


class NoRoomError(ExpectedError):
    """No spot of a target is free and within reach."""

    code = "no_room"


class NameTakenError(ExpectedError):
    """A name that was to be taught means something else already."""

    code = "name_taken"


class NotTaughtError(ExpectedError):
    """Nothing was taught under a name; `data['taught']` lists what was."""

    code = "not_taught"


class ViewBlockedError(ExpectedError):
    """The robot hides what a camera is to see; `data['hidden']` tells how much of the view, 0..1."""

    code = "view_blocked"


class SensorError(ExpectedError):
    """A sensor gave nothing usable."""

    code = "no_data"
