"""What goes over the wire about tasks."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict

Meaning = Literal["success", "failure"]
FieldType = Literal["bool", "int", "float", "choice", "text", "expression", "variable", "child", "cases", "json"]


class Wire(BaseModel):
    """Base of all messages: unknown keys are refused; they can be made of objects with the same attributes."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", from_attributes=True, json_schema_serialization_defaults_required=True
    )


class Transition(Wire):
    """An edge of a state machine, or of the root: what happens after one outcome of a node."""

    outcome: str  # `outcome`, or `outcome.code` where a failure code refines it
    target: str  # name of a sibling, or of an outcome of the container
    ends: bool  # whether the target is an outcome of the container rather than a sibling


class NodeView(Wire):
    """One node of a task."""

    path: str
    parent: str | None
    name: str
    kind: str  # `leaf`, or the kind of the container
    label: str  # what the node does, in short: the catalogue id of a leaf, the settings of a container
    doc: str = ""
    children: list[str] = []
    outcomes: dict[str, Meaning] = {}  # every outcome and what it means to the parent
    initial: bool = False  # whether its container begins with it, whatever happens
    on: list[Transition] = []
    derived: list[Transition] = []
    """Where its ends lead by the kind of its container, by their meaning; one that isn't here ends the container with
    that meaning."""
    inputs: dict[str, str] = {}  # input port -> variable
    outputs: dict[str, str] = {}  # output port -> variable
    parameters: dict[str, Any] = {}
    fields: dict[str, Any] = {}  # the node's other keys, as they stand in the file


class VariableView(Wire):
    """A variable that the task declares."""

    scope: str  # path of the declaring container; empty for the task itself
    name: str
    type: str
    doc: str = ""
    initial: str | None = None  # the initial value as JSON, None when there is none
    whole: bool = True  # whether `initial` is all of it, and not just its beginning
    ports: list[Literal["input", "output"]] = []
    """How the task's file hands it in and out; empty for a variable of its own."""


class FixView(Wire):
    """A way to fix a problem with one press."""

    title: str
    command: dict[str, Any]  # what to send as an edit


class Problem(Wire):
    """Something that the validation found, or why a file can't be read."""

    path: str = ""
    code: str
    severity: Literal["error", "warning"]
    message: str
    fix: str = ""
    line: int | None = None
    column: int | None = None
    key: list[
        Annotated[str, BeforeValidator(str)]
    ] = []  # keys within the node that lead to it; empty for the node as a whole
    fixes: list[FixView] = []


class TaskView(Wire):
    """A task file. `nodes` is empty when the text can't be read as a task; `problems` then says why."""

    path: str  # relative to the project folder, with `/`
    name: str
    doc: str = ""
    outcomes: dict[str, Meaning] = {}
    nodes: list[NodeView] = []  # parents first, in document order; the root is the first
    variables: list[VariableView] = []
    problems: list[Problem] = []


class TaskEntry(Wire):
    """A task file of the project."""

    path: str
    name: str


class SettingView(Wire):
    """A setting of a container."""

    key: str
    type: FieldType
    doc: str
    required: bool
    default: Any = None
    choices: list[str] = []


class KindView(Wire):
    """A kind of container: what the page has to know to draw and to edit one."""

    kind: str
    title: str
    icon: str  # an SVG path in a square of 16
    doc: str
    holds: Literal["none", "one", "many"]  # how many children
    needs_child: bool
    edges: bool  # whether its children's outcomes say who is next
    concurrent: bool  # whether its children run at the same time
    declares: bool  # whether it has variables and outcomes of its own
    fields: list[SettingView]
    blank: dict[str, Any]  # settings that a new one needs


class ProjectView(Wire):
    """What the page knows about the project when it opens."""

    name: str
    folder: str
    tasks: list[TaskEntry]
    kinds: list[KindView]
    robots: list[str]  # what a run may be started on
    selected: str | None = None  # the task that `grip edit` was asked to open


class ErrorBody(Wire):
    """Body of every refused request."""

    detail: str
    kind: str = ""  # `stale`, `disk`, `unfinished` or `held` where the page can do something about it
