"""Every error that GRIP raises on purpose, in one place. This module imports nothing of the project.

Three ways to fail are kept apart. A *bad document* is a list of issues (`InvalidTaskError` carries it). An *expected
robot failure* is an `ExpectedError`: its `code` becomes the failure reason of the leaf that met it. Anything else is
a *bug*: it ends the run as `error` and is reported with the path of the node.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any


def nearest(word: str, allowed: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the closest allowed word, or an empty string."""
    close = get_close_matches(word, list(allowed), n=1, cutoff=0.6)
    return f"; did you mean {close[0]!r}?" if close else ""


def listing(words: Iterable[str], nothing: str = "none") -> str:
    """Return the words joined by commas for an error message, or `nothing`."""
    return ", ".join(words) or nothing


class GripError(Exception):
    """Root of all errors that GRIP raises on purpose. They can be sent between processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Restore the attributes as they are: constructors ask for more than the message that `args` holds."""
        return _restored, (type(self), self.args, dict(self.__dict__))


def _restored(cls: type[GripError], args: tuple[Any, ...], attributes: dict[str, Any]) -> GripError:
    error = cls.__new__(cls, *args)
    error.__dict__.update(attributes)
    return error


class DocumentError(GripError):
    """A file can't be read as a task, a project or a manifest.

    Attributes:
        source: the file's name as the user gave it.
        line: 1-based line, or None.
        column: 1-based column, or None.
    """

    def __init__(self, message: str, source: str = "", line: int | None = None, column: int | None = None):
        self.message, self.source, self.line, self.column = message, source, line, column
        place = source or "<text>"
        if line is not None:
            place += f":{line}" + (f":{column}" if column is not None else "")
        super().__init__(f"{place}: {message}")


class ExpressionError(GripError):
    """A text isn't an expression of the language of guards and switches.

    Attributes:
        text: the expression.
        message: what is wrong and what is allowed.
        column: 1-based column within the expression.
    """

    def __init__(self, text: str, message: str, column: int = 1):
        self.text, self.message, self.column = text, message, column
        super().__init__(f"`{text}`, column {column}: {message}")


class EvaluationError(GripError):
    """An expression can't be computed with the values that its variables have; a bug of the task."""

    def __init__(self, text: str, message: str):
        self.text, self.message = text, message
        super().__init__(f"`{text}`: {message}")


class InvalidTaskError(GripError):
    """A task was read but is wrong; `issues` holds everything that was found."""

    def __init__(self, issues: Sequence[Any], source: str = ""):
        self.issues, self.source = tuple(issues), source
        super().__init__("\n".join(str(i) for i in issues))


class EditError(GripError):
    """An edit that can't be made; the task is as it was.

    Attributes:
        path: the node, or the place in the file, that the edit is about.
        message: what is wrong and what to do.
    """

    def __init__(self, path: str, message: str):
        self.path, self.message = path, message
        super().__init__(f"{path or 'the task'}: {message}")


class HandoverError(EditError):
    """A part and a subtask can't take each other's place unseen: values go in and out of a subtask all at once.

    Who wants it all the same says `approximate: true`.
    """


class SubtaskError(GripError):
    """A file can't be run as a subtask.

    Attributes:
        file: its name, as `task:` of the subtask has it.
        reason: why, and what to do.
    """

    def __init__(self, file: str, reason: str):
        self.file, self.reason = file, reason
        super().__init__(f"subtask {file!r}: {reason}")


class RefusedFileError(GripError):
    """Parts of a file from elsewhere have no exact equal in a task; nothing was made of it.

    Attributes:
        source: the file.
        refused: each of them, with its place, and what to do.
    """

    def __init__(self, source: str, refused: Sequence[Any]):
        self.source, self.refused = source, tuple(refused)
        parts = "part has" if len(self.refused) == 1 else "parts have"
        listed = "".join(f"\n  {refusal}" for refusal in self.refused)
        super().__init__(f"{source or '<text>'}: {len(self.refused)} {parts} no exact equal in a task:{listed}")


class NotExpressibleError(GripError):
    """A compiler can't express a node exactly in the target form; it refuses instead of approximating."""

    def __init__(self, path: str, what: str, target: str):
        self.path, self.what, self.target = path, what, target
        super().__init__(f"{path}: {what} can't be expressed exactly as {target}")


class UnknownNameError(GripError):
    """A name was looked up that isn't there: a node type, an arm, a sensor, a component, a group ..."""

    def __init__(self, kind: str, name: str, allowed: Iterable[str], where: str = ""):
        self.kind, self.name, self.allowed, self.where = kind, name, tuple(sorted(allowed)), where
        at = f"{where}: " if where else ""
        super().__init__(
            f"{at}unknown {kind} {name!r}{nearest(name, self.allowed)} (there are: {listing(self.allowed)})"
        )


class DataError(GripError):
    """A variable was read before it was written, isn't declared, or has the wrong type."""

    def __init__(self, path: str, port: str, message: str):
        self.path, self.port = path, port
        super().__init__(f"{path}: port {port!r}: {message}")


class WrongTypeError(GripError, TypeError):
    """A value was put into a store of another type."""

    def __init__(self, store: str, name: str, type_name: str, reason: str):
        self.store, self.name, self.type_name = store, name, type_name
        super().__init__(f"store {store!r}: {name!r} has to be of type {type_name}: {reason}")


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


class LivelockError(GripError):
    """A task changed state too often within one tick."""

    def __init__(self, path: str, transitions: int):
        self.path, self.transitions = path, transitions
        super().__init__(f"{path}: {transitions} transitions in one tick: the task loops without waiting for anything")


class ContractError(GripError):
    """An interface doesn't keep the component contract; `problems` holds everything that was found."""

    def __init__(self, where: str, problems: Sequence[str]):
        self.where, self.problems = where, tuple(problems)
        super().__init__("\n  ".join([f"{where} doesn't keep the component contract:", *problems]))


class MissingPartError(GripError):
    """Something that this command needs isn't installed; `remedy` is the command that mends it."""

    def __init__(self, what: str, remedy: str):
        self.what, self.remedy = what, remedy
        super().__init__(f"{what} isn't available here. To mend it: {remedy}")


class UnfitSolverError(GripError):
    """A kinematics solver that was asked for by name doesn't take this arm."""


class InvalidRobotError(GripError):
    """A robot's files are wrong; `findings` holds every error that was found, with its place."""

    def __init__(self, name: str, findings: Sequence[Any]):
        self.name, self.findings = name, tuple(findings)
        listed = "".join(f"\n  {finding}" for finding in self.findings)
        super().__init__(f"robot {name} can't be used; `grip robot check` tells all about it:{listed}")


class ProjectExistsError(GripError):
    """A new project was asked for where something is already.

    Attributes:
        folder: the folder, or file, that was named.
    """

    def __init__(self, folder: Any):
        self.folder = str(folder)
        super().__init__(f"{folder} isn't an empty folder; nothing was written. Name a folder that isn't there yet")


class ImplementationError(GripError):
    """A node's code can't be imported; `node` is its id, `implementation` what its manifest names."""

    def __init__(self, node: str, implementation: str, reason: str):
        self.node, self.implementation, self.reason = node, implementation, reason
        super().__init__(f"node {node}: {implementation}: {reason}")


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


# --- expected failures: their code is the reason that a leaf's failure carries --------------------------------------


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


class NoIkError(ExpectedError):
    """No joint positions reach the wanted pose."""

    code = "no_ik"


class OutOfLimitsError(ExpectedError):
    """Joint positions lie outside their limits; `data['joints']` names the joints."""

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


class NoObjectError(ExpectedError):
    """The planning scene doesn't have the object that was named; `data['objects']` lists what it has."""

    code = "no_object"


class BadFileError(ExpectedError):
    """A file that a task names can't be read, or isn't what it should be."""

    code = "bad_file"


class NameTakenError(ExpectedError):
    """A name that was to be taught means something else already."""

    code = "name_taken"


class NotTaughtError(ExpectedError):
    """Nothing was taught under a name; `data['taught']` lists what was."""

    code = "not_taught"


class NothingHeldError(ExpectedError):
    """A hand was asked to put down what it doesn't hold."""

    code = "nothing_held"


class NoTargetError(ExpectedError):
    """The planning scene doesn't have the target that was named."""

    code = "no_target"


class NoRoomError(ExpectedError):
    """No spot of a target is free and within reach."""

    code = "no_room"


class SensorError(ExpectedError):
    """A sensor gave nothing usable."""

    code = "no_data"


class PlannerLostError(ExpectedError):
    """The planning process died twice over one request."""

    code = "planner_lost"


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


class EmptyQueueError(ExpectedError):
    """A value was taken from a queue that has none."""

    code = "empty"

    def __init__(self, store: str):
        super().__init__(f"store {store!r}: nothing waits in its queue", store=store)


class NoEntryError(ExpectedError):
    """A message manager doesn't have what it was asked for; `data['names']` lists what it has."""

    code = "no_entry"


class BadReplyError(ExpectedError):
    """An external component answered with something that its contract doesn't allow."""

    code = "bad_reply"
