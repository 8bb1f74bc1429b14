"""What goes over the wire while tasks are edited."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from grip_gui.wire.task import Meaning, Problem, TaskView, Wire

TaskPath = Annotated[str, Field(max_length=1024)]
View = Literal["flow", "tree"]
Form = Literal["tree", "machine"]
Change = Literal["", "changed", "deleted"]


class PortFace(Wire):
    """An input or an output of a leaf."""

    name: str
    type: str
    doc: str
    required: bool = False


class ParameterFace(PortFace):
    """A literal that a leaf takes."""

    default: Any = None


class NodeFace(Wire):
    """A leaf of the catalogue."""

    id: str
    doc: str
    parameters: list[ParameterFace]
    inputs: list[PortFace]
    outputs: list[PortFace]
    outcomes: dict[str, Meaning]
    codes: list[str]


class CatalogView(Wire):
    """Everything that the palette offers."""

    nodes: list[NodeFace]
    tasks: list[NodeFace] = []  # task files of the project, as subtasks see them; their id is the file
    error: str = ""  # why the project's own nodes are missing


class HistoryEntry(Wire):
    """One state of a document in its history."""

    number: int
    parent: int | None
    title: str


class HistoryView(Wire):
    """What can be undone and redone, and the branches."""

    at: int
    moments: list[HistoryEntry]  # the latest; those before are reached by undo
    can_undo: bool
    can_redo: bool


class LayoutView(Wire):
    """Pinned positions [px], by the path of the node."""

    flow: dict[str, tuple[int, int]] = {}
    tree: dict[str, tuple[int, int]] = {}


class DocumentView(Wire):
    """A task file that is open for editing."""

    path: str
    revision: int
    text: str
    saved: bool
    draft: bool  # whether the text isn't a task; `task` is then the last one that it was
    change: Change  # what somebody else did to the file since it was opened or saved
    history: HistoryView
    layout: LayoutView
    task: TaskView
    moved: dict[str, str] = {}
    """Old path -> new path of nodes that moved since the revision that the page has."""
    checked: bool = True  # whether `task.problems` are known; where they aren't yet, they are asked for by themselves


class ProblemsView(Wire):
    """What the validation says about a revision."""

    revision: int
    problems: list[Problem]


class FormView(Wire):
    """Whether a container can be edited in both forms, as a tree and as a flow chart."""

    path: str
    both: bool
    reason: str
    edges: list[tuple[str, str]]  # which edges of it are in the way: (node, outcome)


class FormsView(Wire):
    """The forms of all composites and state machines of a task; `error` says why they aren't known."""

    revision: int
    forms: list[FormView]
    error: str = ""


class ConversionView(Wire):
    """What a conversion would make of a container."""

    before: list[str]  # kinds and names, a line a node, indented
    after: list[str]
    kept: list[str]  # what stays as it is, and why


class PlacesView(Wire):
    """Where the nodes stand in the text: path -> 1-based line."""

    revision: int
    lines: dict[str, int]


class CommentView(Wire):
    """What the comment of a node or of the task says in the file; empty for none, None where the node has just gone."""

    revision: int
    node: str
    comment: str | None


class Part(Wire):
    """A copy of a node with all below it: what a clipboard holds and `paste` takes."""

    name: str
    node: dict[str, Any]
    variables: dict[str, Any] = {}  # the declarations of the variables that it uses and that are declared around it


class OfDocument(Wire):
    """Something about an open task file; as it is, to reload from the file for what is here."""

    path: TaskPath


class EditRequest(OfDocument):
    """Carry out a command that was made on a revision."""

    base: int
    command: dict[str, Any]


class SaveRequest(OfDocument):
    """Save a file."""

    over: bool = False  # also over somebody else's change


class TextRequest(SaveRequest):
    """Take a text that was typed on a revision; what `over` replaces comes back by undo."""

    base: int
    text: str


class StepRequest(OfDocument):
    """Undo, redo, or go to a moment of any branch."""

    base: int
    step: Literal["undo", "redo", "go"]
    number: int | None = None


class PinRequest(OfDocument):
    """Pin nodes at positions, or let them go (null)."""

    view: View
    positions: dict[str, tuple[float, float] | None]


class NewTask(OfDocument):
    """Make a task file."""

    text: str | None = None


class ExpressionRequest(OfDocument):
    """Check an expression where it would stand; nothing is changed."""

    node: str
    key: list[str]
    text: Annotated[str, Field(max_length=2000)]
