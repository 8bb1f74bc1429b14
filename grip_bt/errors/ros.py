"""Errors of components and of their servers on ROS."""

from __future__ import annotations

from collections.abc import Sequence

from .base import ExpectedError, GripError


class ContractError(GripError):
    """An interface doesn't keep the component contract; `problems` holds everything that was found."""

    def __init__(self, where: str, problems: Sequence[str]):
        self.where, self.problems = where, tuple(problems)
        super().__init__("\n  ".join([f"{where} doesn't keep the component contract:", *problems]))


class ServerLostError(ExpectedError):
    """An external component's server isn't there, or died in the middle of a call."""

    code = "server_lost"


class UnfitServerError(ServerLostError):
    """A server is there but can't be used: another type or definition, several servers, best-effort."""


class ServerTimeOutError(ExpectedError):
    """An external component didn't answer in time."""

    code = "timed_out"


class GoalRejectedError(ExpectedError):
    """An external action's server didn't take the goal."""

    code = "rejected"


class GoalAbortedError(ExpectedError):
    """An external action's server gave the goal up; `data['result']` holds what it said about it, by field."""

    code = "aborted"


class BadReplyError(ExpectedError):
    """An external component answered with something that its contract doesn't allow."""

    code = "bad_reply"
