"""A part of a task as a file of its own: `extract`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath

from grip_bt.base.errors import EditError, HandoverError, listing
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.scalars import write_scalar
from grip_bt.base.yaml.tree import YamlMapping, parse
from grip_bt.compilers.restructure.result import is_within
from grip_bt.task import read_text
from grip_bt.task.canonical import dumps, file_data
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import Document
from grip_bt.task.edit import Extract, Patch, Set, Unset, apply_to_document, title_of
from grip_bt.task.edit.editing import Edit, slot
from grip_bt.task.edit.steps import Assign
from grip_bt.task.edit.text import Text
from grip_bt.task.model import Kind, Subtask, Task, type_of
from grip_bt.task.validation import analyse
from grip_bt.task.validation.analysis import PlacedNode, TaskAnalysis
from grip_bt.task.validation.dataflow import DataFlow


def expect_nobody_can_tell(placed: PlacedNode, reads: set[str], writes: set[str]) -> None:
    """Refuse values that go in and out at another moment where something around a node could notice.

    Raises:
        HandoverError: it could; the message names what, and where.
    """
    fix = "take all of that container, or say `approximate: true`"
    for around, inside in _interrupting(placed):
        kind = around.node.kind  # type: ignore[union-attr]
        if writes:
            raise HandoverError(
                placed.path,
                f"it writes {listing(sorted(writes))}, and the {kind} {around.path} may halt it, after which a subtask "
                f"hands nothing out; {fix}",
            )
        beside = 0
        for child in around.children.values():
            beside |= 0 if child is inside else child.writes
        changed = [name for name in sorted(reads) if name in placed.around and placed.around[name].bit & beside]
        if changed:
            raise HandoverError(
                placed.path,
                f"it reads {listing(changed)}, which another child of the {kind} {around.path} may write while it runs,"
                f" and a subtask gets its inputs on entry; {fix}",
            )


def _interrupting(placed: PlacedNode) -> Iterator[tuple[PlacedNode, PlacedNode]]:
    """Yield the containers above a node that may halt it or run something beside it, with their child above it."""
    inside, around = placed, placed.parent
    while around is not None:
        node = around.node
        if isinstance(node, Kind) and (node.concurrent or not node.blocking):
            yield around, inside
        inside, around = around, around.parent


_AROUND = ("on", "precondition")
"""Keys that speak about what is around a node, and so stay where it was."""


@dataclass(frozen=True)
class Extracted:
    """A part of a task, taken out.

    Attributes:
        text: what is in it, with the comments of the part where it was taken from a document.
        edit: the command that puts a subtask in its place.
    """

    file: str
    text: str
    edit: Patch


def extracted(command: Extract, source: Document | Task, catalog: Catalog) -> Extracted:
    """Take a node with all below it out to a file, which the task then runs as a subtask of the same name.

    Inputs are the variables around it that it may read before it has written them, outputs those that it writes, each
    with its type and its name; outcomes are the node's. Its `on` and `precondition` stay.

    Args:
        source: the task, or the document that it was read from; comments go with the part.

    Raises:
        EditError: there is no such node, it is the root, the part has errors, or a subtask would do something else.
    """
    document = source if isinstance(source, Document) else read_text(dumps(source))
    placed, analysis = _placed(command, document.task, catalog)
    part = _part(command, placed, analysis, catalog)
    inputs, outputs = _ports(command, placed, part, catalog)
    if not command.approximate:
        written = {name for name in outputs if placed.around[name].bit & placed.writes}
        expect_nobody_can_tell(placed, set(inputs), written)
    record: dict[str, object] = {"kind": Subtask.kind_name(), "task": command.file}
    for key, bound in (("in", inputs), ("out", outputs)):
        record |= {key: {name: name for name in bound}} if bound else {}
    record |= {key: file_data(value) for key in _AROUND if (value := getattr(placed.node, key))}
    moving = Edit(document.task)
    parent, name, container = moving.parent(command.path, "is the task already; wrap it, and take out the child")
    at = (*moving.place(parent), slot(container))
    text = _text(part, Text(document.text).lines_at(at, name), inputs, outputs)
    edit = Patch(title=title_of(command), steps=(Assign(at=at, key=name, value=record),))
    return Extracted(command.file, text, edit)


def _placed(command: Extract, task: Task, catalog: Catalog) -> tuple[PlacedNode, TaskAnalysis]:
    analysis = analyse(task, catalog)
    placed = next((placed for placed in analysis.nodes if placed.path == command.path), None)
    if placed is None:
        raise EditError(command.path, "there is no such node")
    if placed.parent is None:
        raise EditError(command.path, "the root is the task already; wrap it, and take out the child")
    file = PurePosixPath(command.file)
    if file.is_absolute() or ".." in file.parts or file.suffix not in (".yaml", ".yml"):
        raise EditError(command.path, f"{command.file!r} isn't a task file of the project, such as `tasks/fetch.yaml`")
    if any(inside.manifest is None for inside in analysis.leaves if is_within(inside.path, placed.path)):
        raise EditError(command.path, "it has a node that the catalogue doesn't know; fix it first (`grip check`)")
    missing = [name for (path, _), name in DataFlow(analysis).missing.items() if is_within(path, placed.path)]
    if missing:
        raise EditError(command.path, f"{missing[0]!r} may be read in it before it is written; fix that first")
    return placed, analysis


def _part(command: Extract, placed: PlacedNode, analysis: TaskAnalysis, catalog: Catalog) -> Task:
    root = {key: value for key, value in file_data(placed.node).items() if key not in _AROUND}
    types = {name: str(declared.type or "Any") for name, declared in placed.around.items()}
    outcomes = dict(placed.outcomes)
    bare = Task.model_validate({"grip": 1, "name": "part", "root": root})
    if placed.node.precondition and "failure" not in TaskAnalysis(bare, catalog).root.outcomes:
        del outcomes["failure"]  # only its refusal is one, which stays outside
    name = PurePosixPath(command.file).stem
    return Task.model_validate({"grip": 1, "name": name, "outcomes": outcomes, "data": types, "root": root})


def _ports(command: Extract, placed: PlacedNode, part: Task, catalog: Catalog) -> tuple[dict[str, str], dict[str, str]]:
    types = {name: type_of(declared.variable) for name, declared in TaskAnalysis(part, catalog).task_scope.items()}
    inputs: dict[str, str] = {}
    while True:  # an expression that reads several variables names one of them at a time
        asked = part.model_copy(update={"inputs": FrozenDict(inputs), "data": FrozenDict(types)})
        analysis = analyse(asked, catalog)
        missing = set(DataFlow(analysis).missing.values()) & types.keys()
        if not missing:
            break
        inputs |= {name: types.pop(name) for name in sorted(missing)}
    used, written, scope = analysis.root.reads, analysis.root.writes, analysis.task_scope
    # what is read only where nothing leads to has to be declared all the same, and need not be there on entry
    unread = {name for name, declared in scope.items() if declared.bit & used and name not in inputs}
    outputs = {n: type_of(declared.variable) for n, declared in scope.items() if declared.bit & written or n in unread}
    return inputs, outputs


def _text(part: Task, source: str, inputs: dict[str, str], outputs: dict[str, str]) -> str:
    """Return the new file: the very lines of the part, below a head of its own."""
    head = f"grip: 1\nname: {write_scalar(part.name, False)}\n"
    tree = parse(source)
    assert isinstance(tree, YamlMapping), "an entry is a mapping of one key"
    entry = next(iter(tree.entries.values()))
    made = read_text(head + source[: entry.start] + "root" + source[entry.key_end :])
    for key in _AROUND:
        if getattr(made.task.root, key):
            made = apply_to_document(made, Unset(path="/", key=(key,))).document
    if dict(part.outcomes) != {"success": "success", "failure": "failure"}:
        made = apply_to_document(made, Set(path="", key=("outcomes",), value=dict(part.outcomes))).document
    for key, ports in (("inputs", inputs), ("outputs", outputs)):
        if ports:
            made = apply_to_document(made, Set(path="", key=(key,), value=ports)).document
    return made.text
