"""Which containers can be edited in both forms, and which edges keep the others from it."""

from __future__ import annotations

from collections.abc import Callable

from grip_bt.base.errors import GripError, InvalidTaskError
from grip_bt.compilers.restructure import to_state_machines, to_trees
from grip_bt.task import Fallback, Sequence, StateMachine, Task, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.walking import join
from grip_gui.edit_messages import FormsView, FormView

from .sheet import Sheet


def forms_view(sheet: Sheet, catalog: Catalog) -> Callable[[], FormsView]:
    """Return what finds the forms of a document's composites and state machines; it needs nobody to wait for it.

    Once the document has changed, nobody asks about this one: the rest isn't looked for, so that edits have the time.
    """
    revision, history = sheet.revision, sheet.history
    if history is None or sheet.draft is not None:
        return lambda: FormsView(revision=revision, forms=[], trouble="the text isn't a task at the moment")
    task = history.document.task

    def found() -> FormsView:
        try:
            forms = _forms(task, catalog, lambda: sheet.revision == revision)
            return FormsView(revision=revision, forms=forms)
        except InvalidTaskError:
            return FormsView(revision=revision, forms=[], trouble="known once the task has no errors")
        except GripError as error:
            return FormsView(revision=revision, forms=[], trouble=str(error))

    return found


def _edge(machine: str, label: str) -> tuple[str, str]:
    """Return the path and the outcome of `state.outcome -> target`."""
    state, _, outcome = label.partition(" -> ")[0].partition(".")
    return join(machine, state), outcome


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
            edges = [_edge(path, label) for label in note.edges] if note else []
            forms.append(FormView(path=path, both=note is None, reason=note.reason if note else "", edges=edges))
    return forms
