"""What goes over the wire between the server and the page: the one source of the TypeScript types.

`python -m grip_gui.typescript` writes these models to `frontend/src/protocol/generated.ts`; a test keeps the two equal.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Meaning = Literal["success", "failure"]
RunState = Literal["starting", "running", "paused", "stopping", "ended"]
Robot = Literal["sim", "fake"]
Target = Literal["bt", "sm"]
Command = Literal["pause", "resume", "step", "stop"]


class Wire(BaseModel):
    """Base of all messages: unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", json_schema_serialization_defaults_required=True)


# --- the task, as the page draws it -----------------------------------------------------------------------------------


class Transition(Wire):
    """An edge of a state machine, or of the root: what happens after one outcome of a node."""

    outcome: str
    """`outcome`, or `outcome.code` where a failure code refines it."""
    target: str
    """Name of a sibling, or of an outcome of the container."""
    ends: bool
    """Whether the target is an outcome of the container rather than a sibling."""


class NodeView(Wire):
    """One node of a task."""

    path: str
    parent: str | None
    name: str
    kind: str
    """`leaf`, or the kind of the container."""
    label: str
    """What the node does, in short: the catalogue id of a leaf, the settings of a container."""
    doc: str = ""
    children: list[str] = []
    outcomes: dict[str, Meaning] = {}
    """Every outcome and what it means to the parent."""
    initial: bool = False
    """Whether a state machine starts with it."""
    on: list[Transition] = []
    inputs: dict[str, str] = {}
    """Input port -> variable."""
    outputs: dict[str, str] = {}
    """Output port -> variable."""
    parameters: dict[str, Any] = {}
    fields: dict[str, Any] = {}
    """The node's other keys, as they stand in the file."""


class VariableView(Wire):
    """A variable that the task declares."""

    scope: str
    """Path of the declaring container; empty for the task itself."""
    name: str
    type: str
    doc: str = ""
    initial: str | None = None
    """Preview of the initial value, None when there is none."""


class FixView(Wire):
    """A way to mend a problem with one press."""

    title: str
    command: dict[str, Any]
    """What to send as an edit."""


class Problem(Wire):
    """Something that the validation found, or why a file can't be read."""

    path: str = ""
    code: str
    severity: Literal["error", "warning"]
    message: str
    fix: str = ""
    line: int | None = None
    column: int | None = None
    key: list[str] = []
    """Keys within the node that lead to it; empty for the node as a whole."""
    fixes: list[FixView] = []


class TaskView(Wire):
    """A task file. `nodes` is empty when the text can't be read as a task; `problems` then says why."""

    path: str
    """Relative to the project folder, with `/`."""
    name: str
    doc: str = ""
    outcomes: dict[str, Meaning] = {}
    nodes: list[NodeView] = []
    """Parents first, in document order; the root is the first."""
    variables: list[VariableView] = []
    problems: list[Problem] = []


class TaskEntry(Wire):
    """A task file of the project."""

    path: str
    name: str


class ProjectView(Wire):
    """What the page knows about the project when it opens."""

    name: str
    folder: str
    tasks: list[TaskEntry]
    robots: list[str]
    """What a run may be started on."""
    selected: str | None = None
    """The task that `grip edit` was asked to open."""


# --- runs -------------------------------------------------------------------------------------------------------------


class RunRecord(Wire):
    """A run of the journal."""

    id: str
    task_name: str
    task_path: str
    target: str
    seed: int | None
    started: float
    """Seconds since the epoch."""
    ended: float | None
    status: str
    outcome: str | None


class RunView(Wire):
    """A run with the task as it was when it ran."""

    run: RunRecord
    task: TaskView


class RunEvent(Wire):
    """One line of the journal."""

    seq: int
    t: float
    """On the run's clock [s]."""
    path: str
    event: str
    outcome: str | None = None
    code: str | None = None
    data: dict[str, Any] = {}


class StartRun(Wire):
    """Start a run of a task."""

    task: Annotated[str, Field(max_length=1024)]
    robot: Robot = "sim"
    target: Target = "bt"
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    pace: Annotated[float, Field(gt=0, le=1000)] | None = 1.0
    """Simulated seconds in a second; None for as fast as it goes."""


class Control(Wire):
    """Ask the run under way for something."""

    command: Command


class SessionView(Wire):
    """The run that this server started last, and how its process is."""

    state: RunState
    task: str
    robot: Robot
    target: Target
    seed: int
    pace: float | None
    run: str | None = None
    """Id in the journal; None until the process has said it."""
    status: str | None = None
    """How it ended: success, failure, error, stopped, killed, or died."""
    outcome: str | None = None
    message: str = ""
    """What a person should know: the last line of output while starting, or why the process is gone."""


# --- socket -----------------------------------------------------------------------------------------------------------


class Subscribe(Wire):
    """Page to server: send this run's events from `from_seq` on."""

    type: Literal["subscribe"] = "subscribe"
    run: Annotated[str, Field(min_length=1, max_length=200)]
    from_seq: Annotated[int, Field(ge=0)] = 0


class SessionFrame(Wire):
    """Server to page: how the run under way is; None when none was started."""

    type: Literal["session"] = "session"
    session: SessionView | None


class EventsFrame(Wire):
    """Server to page: more of a run, in order and without gaps."""

    type: Literal["events"] = "events"
    run: str
    events: list[RunEvent]
    complete: bool
    """Whether the run has ended and this was its last part."""


class RefusedFrame(Wire):
    """Server to page: a message that wasn't understood."""

    type: Literal["refused"] = "refused"
    reason: str


class RevisionsFrame(Wire):
    """Server to page: the revision of each open task file."""

    type: Literal["revisions"] = "revisions"
    revisions: dict[str, int]


ServerFrame = Annotated[SessionFrame | EventsFrame | RefusedFrame | RevisionsFrame, Field(discriminator="type")]
ClientFrame = Subscribe


class Trouble(Wire):
    """Body of every refused request."""

    detail: str
    kind: str = ""
    """`stale`, `disk` or `unfinished` where the page can do something about it."""
