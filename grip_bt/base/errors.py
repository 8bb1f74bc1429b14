"""Every error that GRIP raises on purpose, but for the failures that a task expects (`grip_bt.base.failures`).

Three ways to fail are kept apart. A *bad document* is a list of issues (`InvalidTaskError` carries it). An *expected
robot failure* is an `ExpectedError`: its `code` becomes the failure reason of the leaf that met it. Anything else is
a *bug*: it ends the run as `error` and is reported with the path of the node.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from functools import lru_cache
from typing import Any


def nearest(word: str, allowed: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the closest allowed word, or an empty string."""
    return _nearest(word, tuple(allowed))


@lru_cache(maxsize=1024)
def _nearest(word: str, allowed: tuple[str, ...]) -> str:
    """As above, kept: one wrong name in each of 10,000 nodes is looked for once."""
    close = get_close_matches(word, allowed, n=1, cutoff=0.6)
    if word and not close:  # the last name of a path alone
        close = [path for path in allowed if path.endswith(f"/{word}")][:1]
    return f"; did you mean {close[0]!r}?" if close else ""


def plural(n: int, word: str) -> str:
    """Return a number of things in words, such as `1 run` or `2 runs`."""
    return f"{n} {word}{'s' * (n != 1)}"


def listing(words: Iterable[str], nothing: str = "none") -> str:
    """Return the words joined by commas for an error message, or `nothing`."""
    return ", ".join(words) or nothing


class GripError(Exception):
    """Root of all errors that GRIP raises on purpose. They can be sent between processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Restore the attributes as they are: constructors ask for more than the message that `args` holds."""
        return _restored, (type(self), self.args, dict(self.__dict__))


def _restored(cls: type[GripError], args: tuple[object, ...], attributes: dict[str, Any]) -> GripError:
    error = cls.__new__(cls, *args)
    error.__dict__.update(attributes)
    return error


class UnknownNameError(GripError):
    """A name was looked up that isn't there: a node type, an arm, a sensor, a component, a group ..."""

    def __init__(self, kind: str, name: str, allowed: Iterable[str], where: str = ""):
        self.kind, self.name, self.allowed, self.where = kind, name, tuple(sorted(allowed)), where
        at = f"{where}: " if where else ""
        unknown = f"unknown {kind} {name!r}{nearest(name, self.allowed)}" if name else f"which {kind}? None is named"
        super().__init__(f"{at}{unknown} (available: {listing(self.allowed)})")


class AmbiguousNameError(UnknownNameError):
    """A beginning of a name that several have; `allowed` are those, in an order that helps."""

    def __init__(self, kind: str, name: str, allowed: Sequence[str], where: str = "", most: int = 8):
        super().__init__(kind, name, allowed, where)
        more = ", ..." if len(allowed) > most else ""
        at = f"{where}: " if where else ""
        self.args = (
            f"{at}{len(allowed)} {kind}s begin with {name!r}: {', '.join(allowed[:most])}{more}; give more characters",
        )


class MissingPartError(GripError):
    """Something that this command needs isn't installed; `remedy` is the command that mends it."""

    def __init__(self, what: str, remedy: str):
        self.what, self.remedy = what, remedy
        super().__init__(f"{what} isn't available here. Fix: {remedy}")


EXTRAS = {
    "motion": "coal ompl pinocchio pytracik scipy toppra xacro",
    "sim": "coacd collada PIL sapien trimesh",
    "vision": "cv2",
    "ros": "action_msgs ament_index_python builtin_interfaces geometry_msgs rclpy rosidl_adapter rosidl_generator_c"
    " rosidl_generator_py rosidl_generator_type_description rosidl_parser rosidl_typesupport_c sensor_msgs shape_msgs"
    " rosidl_typesupport_fastrtps_c rosidl_typesupport_introspection_c std_msgs trajectory_msgs unique_identifier_msgs"
    " diagnostic_msgs std_srvs",
    "parquet": "pyarrow",
    "registration": "small_gicp",
    "recording": "mcap",
    "rerun": "rerun",
    "cluster": "ray",
}
"""Extra of our installation -> the packages that it brings, by what is imported."""


def remedy_of(error: BaseException) -> str:
    """Return how to install what couldn't be imported where an extra brings it, otherwise nothing."""
    name = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
    extra = next((extra for extra, brings in EXTRAS.items() if name in brings.split()), "")
    return f"pip install 'grip-bt[{extra}]'" if extra else libraries_of(str(error))


def libraries_of(reason: str) -> str:
    """Return how to install the system's libraries that wheels rely on, if an import failed for want of one."""
    return "sudo apt-get install libgl1 libglib2.0-0 libx11-6" if "cannot open shared object file" in reason else ""


class DocumentError(GripError):
    """A file can't be read as a task, a project or a manifest; `line` and `column` are 1-based."""

    def __init__(self, message: str, source: str = "", line: int | None = None, column: int | None = None):
        self.message, self.source, self.line, self.column = message, source, line, column
        place = source or "<text>"
        if line is not None:
            place += f":{line}" + (f":{column}" if column is not None else "")
        super().__init__(f"{place}: {message}")


class ExpressionError(GripError):
    """A text isn't an expression of the language of guards and switches; `column` is 1-based, within it."""

    def __init__(self, text: str, message: str, column: int = 1):
        self.text, self.message, self.column = text, message, column
        super().__init__(f"`{text}`, column {column}: {message}")


class EvaluationError(GripError):
    """An expression can't be computed with the values that its variables have; a bug of the task."""

    def __init__(self, text: str, message: str):
        self.text, self.message = text, message
        super().__init__(f"`{text}`: {message}")


class EditError(GripError):
    """An edit that can't be made; the task is as it was. `path` is the node, or the place in the file."""

    def __init__(self, path: str, message: str):
        self.path, self.message = path, message
        super().__init__(f"{path or 'the task'}: {message}")


class HandoverError(EditError):
    """A part and a subtask can't take each other's place unseen: a subtask's values go in and out all at once."""


class SubtaskError(GripError):
    """A file can't be run as a subtask; `file` is its name, as `task:` of the subtask has it."""

    def __init__(self, file: str, reason: str):
        self.file, self.reason = file, reason
        super().__init__(f"subtask {file!r}: {reason}")


class ProjectExistsError(GripError):
    """A new project was asked for where something is already."""

    def __init__(self, folder: object):
        self.folder = str(folder)
        super().__init__(f"{folder} is not an empty folder; nothing was written. Name a new folder")


class NotWritableError(GripError):
    """A file or folder that has to be written can't be: no permission, a read-only disk, no room."""

    def __init__(self, place: object, error: OSError, advice: str):
        self.place = str(place)
        super().__init__(f"{place} can't be written ({error.strerror or error}): {advice}")


class ImplementationError(GripError):
    """A node's code can't be imported; `node` is its id, `implementation` what its manifest names."""

    def __init__(self, node: str, implementation: str, reason: str):
        self.node, self.implementation, self.reason = node, implementation, reason
        super().__init__(f"node {node}: {implementation}: {reason}")


class UntrustedCodeError(GripError):
    """Code that isn't GRIP's would be run, and `--no-code` was said; `found` is that, each in words."""

    def __init__(self, found: Sequence[str]):
        self.found = tuple(found)
        super().__init__(
            "--no-code: this would run third-party code:\n"
            + "".join(f"  {each}\n" for each in self.found)
            + "none of it was imported or started; review it, and drop --no-code if you trust it"
        )


class InvalidTaskError(GripError):
    """A task was read but is wrong; `issues` holds everything that was found."""

    def __init__(self, issues: Sequence[object], source: str = ""):
        self.issues, self.source = tuple(issues), source
        super().__init__("\n".join(str(i) for i in issues))


class NotExpressibleError(GripError):
    """A compiler can't express a node exactly in the target form; it refuses instead of approximating."""

    def __init__(self, path: str, what: str, target: str):
        self.path, self.what, self.target = path, what, target
        super().__init__(f"{path}: {what} can't be expressed exactly as {target}")


class NodeError(GripError):
    """A leaf raised an exception that isn't an expected failure; it ends the run as `error`."""

    def __init__(self, path: str, cause: BaseException):
        self.path, self.cause = path, cause
        remedy = remedy_of(cause)
        super().__init__(f"{path}: {type(cause).__name__}: {cause}" + (f". Fix: {remedy}" if remedy else ""))


class NodeFailedError(GripError):
    """A node that was called on its own has failed; `failure` has its code, message and data, `outcome` its end."""

    def __init__(self, node: str, outcome: str, failure: Any):
        self.node, self.outcome, self.failure = node, outcome, failure
        why = outcome if failure is None else f"{failure.code}: {failure.message}"
        super().__init__(f"{node}: {why}")


class HungError(GripError):
    """A node's code doesn't return. `where` is the function, `seconds` how long it was waited for."""

    def __init__(self, where: str, seconds: float):
        self.where, self.seconds = where, seconds
        super().__init__(
            f"{where} hasn't returned for {seconds:g} s; a leaf's update() never blocks: "
            "return self.running() and come back, or do the work with self.context.run_in_worker(...)"
        )


class NotStoppedError(GripError):
    """What was told to stop hasn't, so that nothing else that moves is begun; it ends the run as `error`."""

    def __init__(self, paths: Iterable[str], why: str):
        self.paths = tuple(paths)
        super().__init__(
            f"{listing(map(repr, self.paths))}: was told to stop, but {why}; nothing else that may move is started."
            " Check the robot and the request; if it moves nothing, declare `moves: false` there"
        )


class DivergedError(GripError):
    """A recorded run doesn't happen again: its task, its nodes or its inputs aren't those that they were."""

    def __init__(self, path: str, now: str, before: str):
        self.path, self.now, self.before = path, now, before
        super().__init__(
            f"{path}: the journal has {before!r} there, and now it is {now!r}: the task, a subtask or the project's"
            " nodes have changed since; fork the run before that event, or start the task again"
        )


class ResumeError(GripError):
    """A run of the journal can't be resumed; the message says why, and what can be done."""


class SimulatorLostError(GripError):
    """The simulator's process ended, so that nothing can be measured or moved any more."""


class CampaignError(GripError):
    """A campaign can't be run as it is written, or its results can't be gone on with."""

    def __init__(self, source: str, message: str):
        self.source = source
        super().__init__(f"{source}: {message}")


class InvalidRobotError(GripError):
    """A robot's files are wrong; `findings` holds every error that was found, with its place."""

    def __init__(self, name: str, findings: Sequence[object]):
        self.name, self.findings = name, tuple(findings)
        listed = "".join(f"\n  {finding}" for finding in self.findings)
        super().__init__(f"robot {name} can't be used; `grip robot check` lists everything that is wrong:{listed}")


class ContractError(GripError):
    """An interface doesn't keep the component contract; `problems` holds everything that was found."""

    def __init__(self, where: str, problems: Sequence[str]):
        self.where, self.problems = where, tuple(problems)
        super().__init__("\n  ".join([f"{where} doesn't keep the component contract:", *problems]))


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
