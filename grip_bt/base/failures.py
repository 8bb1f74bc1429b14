"""Failures that a task should expect: of arms, hands, planners, sensors, servers and message stores.

Each has a `code`, which becomes the failure reason of the leaf that met it.
"""

from __future__ import annotations

from typing import Any

from .errors import GripError


class ExpectedError(GripError):
    """Trouble that a task should expect. `code` is the failure reason, `data` what may help to mend it."""

    code = "failed"

    def __init__(self, message: str, **data: Any):
        self.message, self.data = message, data
        super().__init__(message)


class CanceledError(ExpectedError):
    """An operation ended because it was cancelled."""

    code = "canceled"


class TimeOutError(ExpectedError):
    """An operation didn't end within its time."""

    code = "time_out"


class BadFileError(ExpectedError):
    """A file that a task names can't be read, or isn't what it should be."""

    code = "bad_file"


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


class ServerLostError(ExpectedError):
    """An external component's server isn't there, or died in the middle of a call."""

    code = "server_lost"


class IncompatibleServerError(ServerLostError):
    """A server is there but can't be used: another type or definition, several servers, best-effort."""


class ServerTimeOutError(ExpectedError):
    """An external component didn't answer in time."""

    code = "timed_out"


class GoalRejectedError(ExpectedError):
    """An external action's server didn't take the goal."""

    code = "rejected"


class GoalAbortedError(ExpectedError):
    """An external action's server aborted the goal; `data['result']` holds what it said about it, by field."""

    code = "aborted"


class BadReplyError(ExpectedError):
    """An external component answered with something that its contract doesn't allow."""

    code = "bad_reply"


class EmptyQueueError(ExpectedError):
    """A value was taken from a queue that has none."""

    code = "empty"

    def __init__(self, store: str):
        super().__init__(f"store {store!r}: its queue is empty", store=store)


class NoEntryError(ExpectedError):
    """A message manager doesn't have what it was asked for; `data['names']` lists what it has."""

    code = "no_entry"
