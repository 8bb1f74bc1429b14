"""Another form of a task, or of part of it: which there are, and what conversions would make of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePosixPath

from grip_bt.base.errors import EditError, GripError, InvalidTaskError
from grip_bt.compilers.restructure import to_state_machines, to_trees
from grip_bt.task import Fallback, Sequence, StateMachine, Task, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import join
from grip_gui.editing.open_document import OpenDocument
from grip_gui.wire.editing import ConversionView, Form, FormsView, FormView


def conversion_view(opened: OpenDocument, catalog: Catalog, path: str, form: Form) -> Callable[[], ConversionView]:
    """Return what finds what a conversion would do; nobody needs to wait for it.

    Raises:
        EditError: there is nothing to convert, or the task has errors; the second also from what is returned.
    """
    document = opened.document
    if document is None:
        raise EditError("", "the text is not a valid task; fix it first")
    task = document.task
    if path not in dict(walk(task.root)):
        raise EditError(path, "there is no such node")
    return lambda: _view(task, catalog, path, form)


def _view(task: Task, catalog: Catalog, path: str, form: Form) -> ConversionView:
    try:
        result = (to_trees if form == "tree" else to_state_machines)(task, catalog, path)
    except InvalidTaskError as error:
        raise EditError(path, f"the task has errors; fix them first: {error.issues[0]}") from error
    kept = [str(note) for note in result.notes if not note.by_design]
    if result.task == task:
        raise EditError(path, "; ".join(kept) or f"it has the form of a {form} already")
    return ConversionView(
        before=_outline(task, path), after=_outline(result.task, result.paths.get(path, path)), kept=kept
    )


def _outline(task: Task, path: str) -> list[str]:
    """Return a part of a task in lines: kinds and names, indented."""
    lines = []
    for each, node in walk(task.root):
        if path == "/" or each == path or each.startswith(f"{path}/"):
            depth = len(PurePosixPath("/", each).parts) - len(PurePosixPath("/", path).parts)
            kind = getattr(node, "kind", None) or getattr(node, "node", "")
            lines.append(f"{'  ' * depth}{each.rpartition('/')[2] or task.name}: {kind}")
    return lines


def forms_view(opened: OpenDocument, catalog: Catalog) -> Callable[[], FormsView]:
    """Return what finds the forms of a document's composites and state machines; it needs nobody to wait for it.

    Once the document has changed, nobody asks about this one: the rest isn't looked for, so that edits have the time.
    """
    revision, document = opened.revision, opened.document

    def found() -> FormsView:
        forms, why = [], "the text is not a valid task"
        if document is not None:
            try:
                forms, why = _forms(document.task, catalog, lambda: opened.revision == revision), ""
            except InvalidTaskError:
                why = "known once the task has no errors"
            except GripError as error:
                why = str(error)
        return FormsView(revision=revision, forms=forms, error=why)

    return found


def _forms(task: Task, catalog: Catalog, wanted: Callable[[], bool]) -> list[FormView]:
    notes = {}
    for convert in (to_trees, to_state_machines):
        if not wanted():
            return []
        notes.update({note.path: note for note in convert(task, catalog).notes})
    forms = []
    for path, node in walk(task.root):
        if isinstance(node, StateMachine | Sequence | Fallback):
            note = notes.get(path)
            ends = [label.partition(" -> ")[0].partition(".") for label in note.edges] if note else []
            edges = [(join(path, state), outcome) for state, _, outcome in ends]
            forms.append(FormView(path=path, both=note is None, reason=note.reason if note else "", edges=edges))
    return forms
