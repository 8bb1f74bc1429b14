"""Failures that a task should expect: of arms, hands, planners, sensors, servers and message stores."""

from __future__ import annotations

from typing import Any

from .errors import GripError


class ExpectedError(GripError):
    """Trouble that a task should expect. `code` is the failure reason, `data` what may help to mend it."""

    code = "failed"

    def __init_subclass__(cls, code: str = "") -> None:
        cls.code = code or cls.code

    def __init__(self, message: str, **data: Any):
        self.message, self.data = message, data
        super().__init__(message)


class CanceledError(ExpectedError, code="canceled"):
    """An operation ended because it was cancelled."""


class TimeOutError(ExpectedError, code="time_out"):
    """An operation didn't end within its time."""


class BadFileError(ExpectedError, code="bad_file"):
    """A file that a task names can't be read, or isn't what it should be."""


class NoIkError(ExpectedError, code="no_ik"):
    """No joint positions reach the wanted pose."""


class OutOfLimitsError(ExpectedError, code="out_of_limits"):
    """Joints would be outside their limits, of positions or on the way; `data['joints']` names the joints."""


class StartInCollisionError(ExpectedError, code="start_in_collision"):
    """The robot is in collision before it moves; `data['pairs']` names what touches."""


class GoalInCollisionError(ExpectedError, code="goal_in_collision"):
    """The goal is in collision; `data['pairs']` names what touches."""


class NoPlanError(ExpectedError, code="no_plan"):
    """The planner found no path."""


class PathInvalidError(ExpectedError, code="path_invalid"):
    """A path collides, jumps or breaks limits, for instance after timing."""


class ConstraintBrokenError(ExpectedError, code="constraint_broken"):
    """The start or the goal of a motion breaks what its whole path must keep to."""


class PlannerLostError(ExpectedError, code="planner_lost"):
    """The planning process died twice over one request."""


class ExecutionAbortedError(ExpectedError, code="aborted"):
    """The robot didn't reach the end of the motion."""


class NoGraspError(ExpectedError, code="no_grasp"):
    """No grasp candidate is feasible."""


class NoContactError(ExpectedError, code="no_contact"):
    """The hand closed without touching anything."""


class NothingHeldError(ExpectedError, code="nothing_held"):
    """A hand was asked to put down what it doesn't hold."""


class NoObjectError(ExpectedError, code="no_object"):
    """The planning scene doesn't have the object that was named; `data['objects']` lists what it has."""


class NoTargetError(ExpectedError, code="no_target"):
    """The planning scene doesn't have the target that was named."""


class NoRoomError(ExpectedError, code="no_room"):
    """No spot of a target is free and within reach."""


class NameTakenError(ExpectedError, code="name_taken"):
    """A name that was to be taught means something else already."""


class NotTaughtError(ExpectedError, code="not_taught"):
    """Nothing was taught under a name; `data['taught']` lists what was."""


class ViewBlockedError(ExpectedError, code="view_blocked"):
    """The robot hides what a camera is to see; `data['hidden']` tells how much of the view, 0..1."""


class SensorError(ExpectedError, code="no_data"):
    """A sensor gave nothing usable."""


class ServerLostError(ExpectedError, code="server_lost"):
    """An external component's server isn't there, or died in the middle of a call."""


class IncompatibleServerError(ServerLostError):
    """A server is there but can't be used: another type or definition, several servers, best-effort."""


class ServerTimeOutError(ExpectedError, code="timed_out"):
    """An external component didn't answer in time."""


class GoalRejectedError(ExpectedError, code="rejected"):
    """An external action's server didn't take the goal."""


class GoalAbortedError(ExpectedError, code="aborted"):
    """An external action's server aborted the goal; `data['result']` holds what it said about it, by field."""


class BadReplyError(ExpectedError, code="bad_reply"):
    """An external component answered with something that its contract doesn't allow."""


class EmptyQueueError(ExpectedError, code="empty"):
    """A value was taken from a queue that has none."""

    def __init__(self, store: str):
        super().__init__(f"store {store!r}: its queue is empty", store=store)


class NoEntryError(ExpectedError, code="no_entry"):
    """A message manager doesn't have what it was asked for; `data['names']` lists what it has."""
