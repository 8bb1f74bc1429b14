"""A container, or the whole task, in the other form: looked at first, with what was found by comparing both."""

from __future__ import annotations

from dataclasses import dataclass

from grip_bt.catalog import Catalog
from grip_bt.compilers.restructure import Comparison, Note, Restructured, compare, to_state_machines, to_trees
from grip_bt.errors import EditError, InvalidTaskError, NodeError
from grip_bt.graph import StateMachine, Task, walk
from grip_bt.graph.canonical import data_of
from grip_bt.graph.edit import Patch
from grip_bt.graph.edit.draft import deep
from grip_bt.graph.edit.rewriting import differences
from grip_bt.graph.model import AnyNode, children_of
from grip_bt.validation import validate

from ..edit_messages import ConversionView, Form
from .sheet import Sheet


@dataclass(frozen=True)
class Conversion:
    """What a container becomes.

    Attributes:
        result: the task afterwards.
        notes: what keeps its kind within the container.
        comparison: what came of running both forms.
    """

    result: Restructured
    notes: tuple[Note, ...]
    comparison: Comparison


def conversion(task: Task, catalog: Catalog, path: str, form: Form) -> Conversion:
    """Convert a container with all that is in it; the root means the whole task.

    Raises:
        EditError: there is nothing to convert, or it can't be converted alone.
    """
    if path not in dict(walk(task.root)):
        raise EditError(path, "there is no such node")
    try:
        whole = to_trees(task, catalog) if form == "tree" else to_state_machines(task, catalog)
        result = whole if path == "/" else _within(task, whole, path)
        if not validate(result.task, catalog).ok:
            raise EditError(path, "can't be converted alone: what is around it would have to change; convert the task")
        comparison = compare(task, result, catalog)
    except InvalidTaskError as error:
        raise EditError(path, f"the task has errors, mend them first: {error.issues[0]}") from error
    except NodeError as error:
        raise EditError(path, f"the two forms can't be compared: {error}") from error
    notes = tuple(note for note in whole.notes if not note.by_design and _is_within(note.path, path))
    if result.task == task:
        why = f"{notes[0].path}: {notes[0].reason}" if notes else f"nothing in it has another form as a {form}"
        raise EditError(path, f"stays as it is: {why}")
    return Conversion(result, notes, comparison)


def conversion_view(sheet: Sheet, catalog: Catalog, path: str, form: Form) -> ConversionView:
    """Return what a conversion would do, and whether both forms do the same."""
    task = _task(sheet)
    found = conversion(task, catalog, path, form)
    difference = found.comparison.difference
    return ConversionView(
        before=_outline(task, path),
        after=_outline(found.result.task, found.result.paths.get(path, path)),
        kept=[str(note) for note in found.notes],
        same=difference is None,
        compared=str(found.comparison),
        script=[str(end) for end in difference.script] if difference else [],
        does_before=list(difference.before) if difference else [],
        does_after=list(difference.after) if difference else [],
    )


def convert(sheet: Sheet, catalog: Catalog, path: str, form: Form, base: int) -> None:
    """Convert as one edit; what stays keeps its lines and comments."""
    task = _task(sheet)
    after = conversion(task, catalog, path, form).result.task
    steps = tuple(differences(_data(task), _data(after)))
    sheet.do(Patch(title=f"convert {path} to a {form}", steps=steps), base)


def _task(sheet: Sheet) -> Task:
    if sheet.history is None or sheet.draft is not None:
        raise EditError("", "the text isn't a task at the moment; mend it first")
    return sheet.history.document.task


def _data(task: Task) -> dict[str, object]:
    found = deep(data_of(task))
    assert isinstance(found, dict)
    return found


def _within(task: Task, whole: Restructured, path: str) -> Restructured:
    """Return the task with only the container at a path as it is in the converted task."""
    new_path = whole.paths[path]
    nodes = dict(walk(whole.task.root))
    root = _replaced(task.root, path.split("/"), nodes[new_path], None)
    paths = {}
    for old, new in whole.paths.items():
        inside = _is_within(old, path)
        if inside and not _is_within(new, new_path):
            raise EditError(path, "can't be converted alone: its parts would go elsewhere; convert the task")
        paths[old] = path + new.removeprefix(new_path) if inside else old
    return Restructured(task.model_copy(update={"root": root}), paths, whole.notes)


def _replaced(node: AnyNode, names: list[str], new: AnyNode, parent: AnyNode | None) -> AnyNode:
    """Return a node in which the one at the end of some names is another one, which leads where that one led."""
    if not names:
        more = new.on if isinstance(parent, StateMachine) else {}
        return new.model_copy(update={"on": type(node.on)({**more, **node.on})})
    children = children_of(node)
    key = "child" if hasattr(node, "child") else "children"
    changed = {**children, names[0]: _replaced(children[names[0]], names[1:], new, node)}
    return node.model_copy(update={key: type(children)(changed)})


def _is_within(path: str, container: str) -> bool:
    return container == "/" or path == container or path.startswith(f"{container}/")


def _outline(task: Task, path: str) -> list[str]:
    """Return a part of a task in lines: kinds and names, indented."""
    lines = []
    for each, node in walk(task.root):
        if _is_within(each, path):
            depth = 0 if each == path else len(each.split("/")) - (0 if path == "/" else len(path.split("/")))
            name = task.name if each == "/" else each.rpartition("/")[2]
            lines.append(f"{'  ' * depth}{name}: {getattr(node, 'kind', None) or getattr(node, 'node', '')}")
    return lines
