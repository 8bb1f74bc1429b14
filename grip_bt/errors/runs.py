"""Errors that end a run, or keep one from being gone on with."""

from __future__ import annotations

from collections.abc import Iterable

from .base import GripError, listing


class NodeError(GripError):
    """A leaf raised an exception that isn't an expected failure; it ends the run as `error`."""

    def __init__(self, path: str, cause: BaseException):
        self.path, self.cause = path, cause
        super().__init__(f"{path}: {type(cause).__name__}: {cause}")


class HungError(GripError):
    """A node's code doesn't return. `where` is the function, `seconds` how long it was waited for."""

    def __init__(self, where: str, seconds: float):
        self.where, self.seconds = where, seconds
        super().__init__(
            f"{where} hasn't returned for {seconds:g} s; a leaf's update() never blocks: "
            "return self.running() and come back, or do the work with self.context.run_in_worker(...)"
        )


class NotStoppedError(GripError):
    """What was told to stop hasn't, so that nothing else that moves is begun; it ends the run as `error`.

    Attributes:
        paths: the nodes whose work goes on.
    """

    def __init__(self, paths: Iterable[str], why: str):
        self.paths = tuple(paths)
        super().__init__(
            f"{listing(map(repr, self.paths))}: was told to stop, but {why}; nothing else that may move something is"
            " begun. Look at the robot, and at what was asked; if that moves nothing, say `moves: false` there"
        )


class LivelockError(GripError):
    """A task changed state too often within one tick."""

    def __init__(self, path: str, transitions: int):
        self.path, self.transitions = path, transitions
        super().__init__(f"{path}: {transitions} transitions in one tick: the task loops without waiting for anything")


class DivergedError(GripError):
    """A recorded run doesn't happen again: its task, its nodes or its inputs aren't those that they were.

    Attributes:
        path: the node.
        now: what it does.
        before: what it did, as the journal has it.
    """

    def __init__(self, path: str, now: str, before: str):
        self.path, self.now, self.before = path, now, before
        super().__init__(
            f"{path}: the journal has {before!r} there, and now it is {now!r}: the task, a subtask or the project's"
            " nodes have changed since; fork the run before that event, or run the task anew"
        )


class ResumeError(GripError):
    """A run of the journal can't be gone on with; the message says why, and what can be done."""


class SimulatorLostError(GripError):
    """The simulator's process ended, so that nothing can be measured or moved any more."""


class CampaignError(GripError):
    """A campaign can't be run as it is written, or its results can't be gone on with.

    Attributes:
        source: its file.
    """

    def __init__(self, source: str, message: str):
        self.source = source
        super().__init__(f"{source}: {message}")
