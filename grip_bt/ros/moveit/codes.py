"""MoveIt's error codes as the failures that tasks know; each keeps MoveIt's own name, number and words in its data."""

from __future__ import annotations

from typing import Any

from grip_bt.base.failures import (
    CanceledError,
    ConstraintBrokenError,
    ExecutionAbortedError,
    ExpectedError,
    GoalInCollisionError,
    GoalRejectedError,
    NoIkError,
    NoPlanError,
    OutOfLimitsError,
    PathInvalidError,
    PlannerLostError,
    SensorError,
    StartInCollisionError,
    TimeOutError,
)

SUCCESS = 1
_FAILURES: dict[str, tuple[type[ExpectedError], str]] = {
    "PLANNING_FAILED": (NoPlanError, "no path was found"),
    "FAILURE": (NoPlanError, "it failed and doesn't say why; its own log does"),
    "UNDEFINED": (NoPlanError, "it gave no answer that means anything; its own log may tell why"),
    "GOAL_CONSTRAINTS_VIOLATED": (NoPlanError, "the path that was found ends elsewhere"),
    "GOAL_STATE_INVALID": (NoPlanError, "the goal can't be reached, or not without touching something"),
    "INVALID_MOTION_PLAN": (PathInvalidError, "the path that was found isn't free"),
    "MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE": (PathInvalidError, "something came in the way"),
    "CONTROL_FAILED": (ExecutionAbortedError, "a controller gave the motion up"),
    "ABORT": (ExecutionAbortedError, "it was aborted"),
    "UNABLE_TO_AQUIRE_SENSOR_DATA": (SensorError, "a sensor that it needs gives nothing"),
    "ROBOT_STATE_STALE": (SensorError, "it has no recent joint states"),
    "SENSOR_INFO_STALE": (SensorError, "a sensor that it needs gives nothing new"),
    "TIMED_OUT": (TimeOutError, "its time was over; give the arm a longer `planning_time`"),
    "PREEMPTED": (CanceledError, "it was told to stop"),
    "START_STATE_IN_COLLISION": (StartInCollisionError, "the robot touches something where the motion begins"),
    "START_STATE_INVALID": (OutOfLimitsError, "where the motion begins, a joint is out of its limits"),
    "START_STATE_VIOLATES_PATH_CONSTRAINTS": (ConstraintBrokenError, "the start breaks what the path must keep to"),
    "GOAL_IN_COLLISION": (GoalInCollisionError, "the robot would touch something at the goal"),
    "GOAL_VIOLATES_PATH_CONSTRAINTS": (ConstraintBrokenError, "the goal breaks what the path must keep to"),
    "NO_IK_SOLUTION": (NoIkError, "no joint positions reach the pose"),
    "INVALID_GROUP_NAME": (
        GoalRejectedError,
        "it has no such group of joints; say its own name under `ros: {move_group: {groups: {GROUP: ITS_NAME}}}`",
    ),
    "INVALID_GOAL_CONSTRAINTS": (GoalRejectedError, "its planner can't take such a goal; choose another pipeline"),
    "UNRECOGNIZED_GOAL_TYPE": (GoalRejectedError, "its planner can't take such a goal; choose another pipeline"),
    "INVALID_ROBOT_STATE": (GoalRejectedError, "it has other joints; is it started for the same robot?"),
    "INVALID_LINK_NAME": (GoalRejectedError, "it has no such link; is it started for the same robot?"),
    "INVALID_OBJECT_NAME": (GoalRejectedError, "its scene has no such object"),
    "FRAME_TRANSFORM_FAILURE": (GoalRejectedError, "it doesn't know the robot's base link as a frame"),
    "COLLISION_CHECKING_UNAVAILABLE": (GoalRejectedError, "it can't check collisions"),
    "COMMUNICATION_FAILURE": (PlannerLostError, "it couldn't reach a part of itself"),
    "CRASH": (PlannerLostError, "its planner crashed; its own log tells why"),
}


def failure(code: Any, what: str) -> ExpectedError | None:
    """Return the failure that an error code stands for; None for success.

    Args:
        code: a `moveit_msgs/msg/MoveItErrorCodes`; the words that newer releases add are passed on.
        what: what was asked, and of whom; begins the message.
    """
    value = int(code.val)
    if value == SUCCESS:
        return None
    name = name_of(code)
    kind, meaning = _FAILURES.get(name, (NoPlanError, f"code {value}, which this version doesn't know"))
    said = str(getattr(code, "message", "")).strip()
    words = f"{what}: {meaning}{f' ({said})' if said else ''}"
    return kind(words, moveit=name.lower(), moveit_code=value, moveit_says=said)


def name_of(code: Any) -> str:
    """Return the name of an error code's value, such as `NO_IK_SOLUTION`; `CODE_<n>` for one without a name."""
    constants = {
        getattr(code, name): name
        for name in dir(type(type(code)))
        if name.isupper() and isinstance(getattr(code, name, None), int)
    }
    return constants.get(int(code.val), f"CODE_{int(code.val)}")


def known_codes() -> frozenset[str]:
    """Return the names of the codes that have a meaning here; success has none."""
    return frozenset(_FAILURES)
